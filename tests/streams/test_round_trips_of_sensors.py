"""Sensors' names, order and pairs: from a recording through a run and its export back to a recording."""

import shutil
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from fesloop.experiment.export import export
from fesloop.experiment.export.channels import channels
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.recording.reading import Recording
from fesloop.streams.files import open_recording
from fesloop.streams.motion_file import write_motion_file
from fesloop.streams.recording import MotionRecording
from fesloop.streams.timebase import stamps_of_rate

SAMPLES = 12
AWKWARD = ("acc", "x", "F2p_gyr_x", "a.b", "1", "mag z", 'say "so"', "left, upper", "[T]", "<b>&", "hand")
NAMES = st.sampled_from(AWKWARD) | st.text(
    st.characters(categories=("L", "N", "P", "S", "Zs")), min_size=1, max_size=12).map(
        lambda name: " ".join(name.split())).filter(lambda name: name not in ("", "n/a"))


@st.composite
def worn(draw):
    """(names, pairs): any tree of sensors, in any order."""
    names = draw(st.lists(NAMES, min_size=2, max_size=6, unique_by=str.casefold))
    order = draw(st.permutations(range(len(names))))
    pairs = [(order[draw(st.integers(0, k - 1))], order[k]) for k in range(1, len(names))]
    return tuple(names), tuple(draw(st.permutations(pairs)))


def run_of(folder, names, pairs):
    """A recording of such sensors, each with samples of its own, and the run that `vqf` makes of it."""
    rng, shape = np.random.default_rng(0), (SAMPLES, len(names), 3)
    told = MotionRecording(
        path=folder / "lab", source_format="table", sensor_set=None, sensors=names, rate=Fraction(100),
        stamps_ns=stamps_of_rate(SAMPLES, Fraction(100)), gyr=rng.normal(0.0, 0.1, shape),
        acc=rng.normal([0.0, 0.0, 9.81], 0.1, shape), mag=None, reference=None, pairs=pairs)
    write_motion_file(told, folder / "lab.h5")
    experiment = from_document({
        "experiment": {"name": "worn"},
        "blocks": {"imus": {"kind": "replay", "recording": str(folder / "lab.h5")},
                   "tracker": {"kind": "vqf", "clock": "imus"}},
        "wires": [{"from": f"imus.{kind}", "to": f"tracker.{kind}"} for kind in ("gyr", "acc")]})
    return told, experiment.run(folder / "runs").recording


def imported(run, kind, folder):
    path = export(run, kind, folder / kind).path
    if kind == "csv":
        return open_recording(path / "imus.csv", layout=path / "imus.layout.toml")
    return open_recording(next(path.glob("*.xdf")) if kind == "xdf" else path)


@pytest.mark.parametrize("kind", ["xdf", "motion-bids", "csv"])
@given(worn=worn())
@example(worn=(("F2p", "forearm", "hand"), ((1, 2), (1, 0))))
@example(worn=(AWKWARD, tuple((k + 1, k) for k in range(len(AWKWARD) - 1))))
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_names_order_and_pairs_come_back(tmp_path, kind, worn):
    folder = tmp_path / "trip"
    shutil.rmtree(folder, ignore_errors=True)
    told, run = run_of(folder, *worn)
    found = imported(run, kind, folder)
    assert found.sensors == told.sensors
    assert found.pairs == told.pairs
    np.testing.assert_array_equal(found.gyr, told.gyr)
    np.testing.assert_array_equal(found.acc, told.acc)


def test_rows_of_a_tracker_are_named_after_sensors_and_pairs_and_its_columns_too(tmp_path):
    _, run = run_of(tmp_path, ("F2p", "forearm", "hand"), ((1, 2), (1, 0)))
    with Recording(run) as recording:
        signals = {signal.name: signal for table in recording.tables(recording.signals, 0)
                   for signal in table.signals}
        assert [channel.label for channel in channels(signals["imus.gyr"], {})][::3] == [
            "F2p.x", "forearm.x", "hand.x"]
        assert [channel.label for channel in channels(signals["tracker.orientation"], {})][::4] == [
            "F2p.w", "forearm.w", "hand.w"]
        assert [channel.label for channel in channels(signals["tracker.angles"], {})] == [
            "forearm-hand", "forearm-F2p"]
    lines = Path(export(run, "mot", tmp_path / "angles.mot").path).read_text().splitlines()
    assert lines[lines.index("endheader") + 1].split("\t")[1:] == ["forearm-hand", "forearm-F2p"]
