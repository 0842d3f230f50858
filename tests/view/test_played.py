"""Frames of a recording that is played, against the recording itself."""

import itertools
import os
import re
import shutil
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from markupsafe import escape
from view_parts import events, serving

from fesloop import Experiment, Recording
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import dorsal_points
from fesloop.loop.nodes import Node
from fesloop.show.view.played import _Playing
from fesloop.show.view.server import page_html
from fesloop.show.view.shown import Shown, Span, Start
from fesloop.show.view.sources import open_recording
from plants.moving_hand import MovingHand

GRASP = str(Path(__file__).parent.parent / "picture" / "grasp.toml")
ON_SKIN = dorsal_points(HandSize(side="left", hand_mm=180.0))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return Path(run(load(GRASP, ["experiment.trials=2"]), tmp_path_factory.mktemp("runs")).recording)


@pytest.fixture(scope="module")
def source(path):
    found = open_recording(path)
    yield found
    found.close()


def sites(poses):
    """Where sensors are on a hand of (17, 7)."""
    poses = np.asarray(poses)
    return poses[:, 4:] + quaternion.rotate(poses[:, :4], ON_SKIN)


def recorded(path, name, trial, time_s):
    with Recording(path) as recording:
        signal = recording.signal(name, trial)
    return signal.values[signal.times_ns <= round(time_s * 1e9)][-1]


def test_it_says_what_it_is(path, source):
    assert source.title == "made_up_grasp, seed 1"
    assert list(source.spans) == [0, 1]
    for trial, span in source.spans.items():
        with Recording(path) as recording:
            last = recording.signal("hand.angles", trial).times_ns[-1]
        assert (span.first_s, span.last_s) == (0.0, last / 1e9)


@pytest.mark.parametrize(("start", "elapsed_s", "time_s"), [
    (Start(trial=1, at_s=0.1), 0.2, 0.3), (Start(trial=0, speed=0.5), 0.4, 0.2),
    (Start(trial=1, at_s=0.2, speed=0.0), 5.0, 0.2), (Start(trial=0, at_s=0.3, speed=2.0), 9.0, None)])
def test_it_is_where_and_when_it_is_said_to_be(path, source, start, elapsed_s, time_s):
    expected = source.spans[start.trial].last_s if time_s is None else time_s
    shown = source.play(start)(elapsed_s + 1e-6)
    assert (shown.trial, shown.time_s) == (start.trial, pytest.approx(expected))
    np.testing.assert_allclose(sites(shown.hands["truth"]),
                               recorded(path, "hand.site_position", start.trial, shown.time_s), atol=1e-9)
    np.testing.assert_array_equal(shown.objects[0, 4:],
                                  recorded(path, "hand.object_position", start.trial, shown.time_s))


def test_nothing_is_sent_twice_and_nothing_after_the_end(source):
    play = source.play(Start(trial=0, at_s=0.3))
    shown = [play(elapsed) for elapsed in np.arange(0.0, 1.0, 0.01)]
    times = [each.time_s for each in shown if each is not None]
    assert all(before < after for before, after in itertools.pairwise(times))
    assert times[-1] == source.spans[0].last_s
    assert shown[-1] is None


@pytest.mark.parametrize("start", [Start(trial=2), Start(trial=-1), Start(speed=-1.0), Start(speed=1e6)])
def test_a_start_that_there_is_not_is_refused(source, start):
    with pytest.raises(InputError):
        source.play(start)


def test_what_comes_to_the_browser_is_the_recording(path, source):
    with serving(source) as server, events(server.server_port, "?trial=1&at=0.1&speed=0.25") as frames:
        for _ in range(12):
            frame = next(frames)
            # Numbers come with five digits.
            np.testing.assert_allclose(sites(frame["hands"]["truth"]),
                                       recorded(path, "hand.site_position", 1, frame["time_s"]), atol=5e-5)


def test_a_hand_alone_has_no_objects_about_it(tmp_path):
    experiment = Experiment(name="alone", nodes=(Node("hand", MovingHand(script="kortier_flexion")),),
                            duration_s=1.0)
    found = open_recording(Path(experiment.run(tmp_path).recording))
    assert found.play(Start(at_s=0.5))(0.0).objects.shape == (0, 7)
    found.close()


@pytest.mark.parametrize(("at_s", "elapsed_s", "shown_s"), [
    (0.0, 0.0, 2.0), (2.5, 0.0, 2.5), (2.5, 0.2, 2.7), (2.5, 9.0, 3.0), (9.0, 0.0, 3.0)])
def test_what_is_asked_for_outside_of_a_trial_is_its_first_or_last_frame(at_s, elapsed_s, shown_s):
    def frames(trial, times_s):
        return [Shown(trial=trial, time_s=time_s, hands={}, objects=np.empty((0, 7))) for time_s in times_s]

    playing = _Playing(frames, Start(trial=0, at_s=at_s), Span(first_s=2.0, last_s=3.0))
    assert playing.at(elapsed_s).time_s == pytest.approx(shown_s)


@pytest.fixture
def cut(path, tmp_path):
    """A recording of which the first part alone is there."""
    def made(share):
        whole = path.read_bytes()
        target = tmp_path / "cut.h5"
        target.write_bytes(whole[:int(share * len(whole))])
        os.utime(target, (0, 0))
        return target

    return made


@pytest.mark.parametrize("share", [0.7, 0.95])
def test_of_a_damaged_recording_what_is_left_is_shown_as_it_was(path, source, cut, share):
    left = open_recording(cut(share))
    assert left.notices[0].startswith("The file is damaged")
    assert any("cut short" in notice for notice in left.notices)
    assert left.title == source.title
    assert set(left.spans) <= set(source.spans)
    for trial, span in left.spans.items():
        assert span.last_s <= source.spans[trial].last_s
        start = Start(trial=trial, at_s=0.5 * span.last_s, speed=0.0)
        mine, whole = left.play(start)(0.0), source.play(start)(0.0)
        assert mine.hands.keys() <= whole.hands.keys()  # the end of the file has a signal's only copy
        for name, hand in mine.hands.items():
            np.testing.assert_array_equal(hand, whole.hands[name])
        assert share < 0.9 or "truth" in mine.hands
    left.close()


def test_the_page_says_what_is_missing_of_a_damaged_recording(source, cut):
    left = open_recording(cut(0.9))
    page, sound = page_html(left), page_html(source)
    plain = re.sub(r"</?code>", "`", page)
    for notice in left.notices:
        assert str(escape(notice)) in plain
    assert 'class="notice" role="note"' in page
    assert 'class="notice" role="note"' not in sound
    left.close()


def test_what_is_left_takes_no_room_once_it_is_closed(cut, monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "room"))
    (tmp_path / "room").mkdir()
    left = open_recording(cut(0.9))
    assert list((tmp_path / "room").iterdir())
    left.close()
    assert not list((tmp_path / "room").iterdir())


def test_a_recording_of_another_version_is_shown_with_a_word_on_it(path, tmp_path):
    newer = tmp_path / "newer.h5"
    shutil.copy(path, newer)
    with h5py.File(newer, "r+") as file:
        file.attrs["format"] = "fesloop recording 2"
    os.utime(newer, (0, 0))
    shown = open_recording(newer)
    assert "'fesloop recording 2'" in shown.notices[0]
    shown.close()
