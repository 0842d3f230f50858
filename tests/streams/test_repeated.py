"""Sensors that repeat themselves, or whose rates gravity cannot judge, are named at import."""

import numpy as np
import pytest
from agreement_parts import motion
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop import load
from fesloop.apps.cli import main
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.trouble import troubles
from fesloop.streams.doubts import all_doubts, repeated_text
from fesloop.streams.files import open_recording

LAYOUT = ("rate = 100\n[text]\nheader = 0\n[sensors.a]\ngyr = [1, 2, 3]\nacc = [4, 5, 6]\n"
          "[sensors.b]\ngyr = [7, 8, 9]\nacc = [10, 11, 12]\n")


def recorded(folder, *sensors):
    """A table of sensors, each (n, 6), opened."""
    np.savetxt(folder / "lab.csv", np.concatenate(sensors, axis=1), delimiter=",", fmt="%.17g")
    (folder / "layout.toml").write_text(LAYOUT)
    return open_recording(folder / "lab.csv", layout=folder / "layout.toml")


def moving(seed):
    _, gyr, acc = motion(seed, seconds=10.0)
    return np.concatenate([gyr, acc], axis=1)


@given(at=st.integers(1, 800), count=st.integers(1, 150), zeros=st.booleans())
@settings(max_examples=15, deadline=None)
def test_a_sensor_that_repeats_itself_for_a_tenth_of_a_second_is_named(tmp_path_factory, at, count, zeros):
    sound, held = moving(1), moving(2)
    held[at:at + count] = 0.0 if zeros else held[at - 1]
    repeats = count - 1 if zeros else count
    text = repeated_text(recorded(tmp_path_factory.mktemp("held"), sound, held))
    assert bool(text) == (repeats >= 10)
    if text:
        assert f"b once, {repeats / 100:.3g} s in all" in text
        assert " a " not in text.partition(":")[2].partition("b once")[0]


@given(at=st.integers(1, 800), count=st.integers(12, 150), zeros=st.booleans(), later=st.booleans())
@settings(max_examples=4, deadline=None)
def test_a_run_begins_with_what_import_says_of_a_sensor_that_repeats_itself(tmp_path_factory, at, count,
                                                                            zeros, later):
    folder = tmp_path_factory.mktemp("held")
    sound, held = moving(1), moving(2)
    held[at:at + count] = 0.0 if zeros else held[at - 1]
    first = (at + count) / 100 if later else 0.0
    recording = recorded(folder, sound, held)
    text = repeated_text(recording)
    assert f"from {(at - (not zeros)) / 100:.4g} s on" in text
    run = load("replay", [f"recording={folder / 'lab.csv'}", "blocks.tracker.pairs=[[0, 1]]",
                          f"blocks.recording.layout={folder / 'layout.toml'}",
                          f"blocks.recording.start_s={first}"]).run(folder)
    with Recording(run.recording) as done:
        sentences = [each.sentence for each in troubles(done, run.metrics)]
    assert any(f"lacks samples: {text}" in each for each in sentences) != later


@pytest.mark.parametrize(("turning", "told"), [(1.0, ""), (0.0, "1 of 2 sensors (b)")])
def test_a_sensor_that_could_not_be_judged_is_named(tmp_path, turning, told, capsys):
    _, gyr, acc = motion(2, turning=turning, shaking=0.0, bias=0.0)
    still = np.concatenate([gyr, acc], axis=1)
    _, gyr, acc = motion(1)
    recording = recorded(tmp_path, np.concatenate([gyr, acc], axis=1), still)
    doubts = dict(all_doubts(recording))
    unjudged = doubts.get("rates_not_checked", "")
    assert ("rates_disagree" in doubts, bool(unjudged)) == (False, bool(told))
    assert told in unjudged
    assert main(["import", str(tmp_path / "lab.csv"), str(tmp_path / "m.h5"), "--layout",
                 str(tmp_path / "layout.toml")]) == 0
    assert ("could not be checked against gravity" in capsys.readouterr().err) == bool(told)
