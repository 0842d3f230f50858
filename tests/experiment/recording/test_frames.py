"""Signals and events as pandas and xarray have them: the same numbers, named."""

import sys

import numpy as np
import pytest

import fesloop
from fesloop.errors import InputError


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    settings = ("tracker=vqf", "experiment.trials=2")
    return fesloop.load("finger_control", settings).run(tmp_path_factory.mktemp("runs")).recording


def test_columns_are_named_by_rows_and_components(run):
    with fesloop.Recording(run) as recording:
        angles = recording.signal("tracker.angles", trial=1)
        frame = angles.to_dataframe(degrees=True, stamps=True)
        stimulation = recording.signal("controller.stimulation")
        pulses = stimulation.to_dataframe()
        turned = recording.signal("tracker.orientation").to_dataframe()
    assert frame.index.name == "time_s"
    np.testing.assert_allclose(frame.iloc[:, :3], np.degrees(angles.values))
    np.testing.assert_allclose(frame.index, angles.times_ns / 1e9)
    assert frame.attrs == {"signal": "tracker.angles", "unit": "deg"}
    assert [*frame.columns[3:]] == ["captured_oldest_s", "captured_newest_s", "left_s"]
    np.testing.assert_allclose(frame["captured_oldest_s"], angles.oldest_ns / 1e9)
    assert {name.rpartition(".")[2] for name in pulses.columns} == {"current_a", "width_s"}
    np.testing.assert_array_equal(pulses.to_numpy().reshape(stimulation.values.shape), stimulation.values)
    assert {name.rpartition(".")[2] for name in turned.columns} == {"w", "x", "y", "z"}
    assert len({*pulses.columns}) == pulses.shape[1]


def test_a_preview_of_three_joints_is_no_vector_and_a_scalar_has_its_ports_name(run):
    with fesloop.Recording(run) as recording:
        preview = recording.signal("reference.preview").to_dataframe()
        aligned = recording.signal("tracker.aligned").to_dataframe()
    assert preview.columns[0] == "0.0"
    assert [*aligned.columns] == ["aligned"]


def test_rows_have_the_names_that_their_port_states(run):
    with fesloop.Recording(run) as recording:
        for name in recording.signals:
            signal = recording.signal(name)
            if signal.rows:
                frame, array = signal.to_dataframe(), signal.to_xarray()
                assert [*dict.fromkeys(name.partition(".")[0] for name in frame.columns)] == [*signal.rows]
                assert [*array.coords["row"].values] == [*signal.rows]


def test_every_signal_is_the_same_in_all_forms(run):
    with fesloop.Recording(run) as recording:
        for name in [*recording.signals, *recording.inputs]:
            signal = recording.signal(name)
            array = signal.to_xarray()
            np.testing.assert_array_equal(array.values, signal.values)
            np.testing.assert_array_equal(signal.to_dataframe().to_numpy().ravel(), signal.values.ravel())
            assert array.attrs["units"] == signal.unit
            np.testing.assert_array_equal(array.coords["captured_newest_s"], signal.newest_ns / 1e9)


def test_events_are_a_table(run):
    with fesloop.Recording(run) as recording:
        frame, events = recording.events_frame(), recording.events
    assert len(frame) == len(events) > 0
    assert [*frame.columns] == ["trial", "time_s", "where", "status", "detail"]
    assert [*frame["status"]] == [each.status for each in events]


def test_a_missing_library_is_named(run, monkeypatch):
    with fesloop.Recording(run) as recording:
        signal = recording.signal("tracker.angles")
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(InputError, match=r"xarray: is not installed.*fesloop\[frames\]"):
        signal.to_xarray()
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match="pandas: is not installed"):
        signal.to_dataframe()
