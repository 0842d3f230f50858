"""XDF files, as pyxdf reads them, hold every number and stamp of a run."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from export_parts import BLOCK, PLANT, Node, runs, same, times, write_run
from hypothesis import HealthCheck, given, settings

from fesloop import Recording
from fesloop.experiment.export import export

pyxdf = pytest.importorskip("pyxdf")


def read(path):
    """Streams by name."""
    streams, header = pyxdf.load_xdf(path, dejitter_timestamps=False)
    return {stream["info"]["name"][0]: stream for stream in streams}, header


def told(stream, key):
    """A field of every channel."""
    channels = stream["info"]["desc"][0]["channels"][0]["channel"]
    return [channel[key][0] for channel in channels]


@pytest.mark.slow
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=runs())
def test_every_run_reads_back_exactly(made, tmp_path_factory):
    nodes, events = made
    folder = tmp_path_factory.mktemp("run")
    run = write_run(folder / "run.h5", nodes, events)
    exported = export(run, "xdf", folder / "out")
    with Recording(run) as recording:
        assert len(exported.files) == recording.trials
        for trial, path in enumerate(exported.files):
            streams, _ = read(path)
            for name in recording.signals + recording.inputs:
                signal, stream = recording.signal(name, trial), streams[name]
                rows = len(signal.times_ns)
                if not rows:
                    assert len(stream["time_series"]) == 0
                    continue
                same(stream["time_series"], signal.values.reshape(rows, -1))
                np.testing.assert_array_equal(np.rint(stream["time_stamps"] * 1e9), signal.times_ns)
                table = name if name in recording.inputs else name.partition(".")[0]
                stamps = streams[f"{table}.stamps"]["time_series"]
                assert stamps.dtype == np.int64
                np.testing.assert_array_equal(stamps, np.stack([
                    signal.indices, signal.times_ns, signal.left_ns, signal.oldest_ns, signal.newest_ns], 1))
            mine = [event for event in recording.events if event.trial == trial]
            assert [row[0] for row in streams["events"]["time_series"]] == [
                f"{event.where}: {event.status}: {event.detail}" for event in mine]


def test_channels_are_described_as_the_wiki_asks(tmp_path):
    node = Node("imus", BLOCK, {"gyr": ("rad/s", (2, 3)), "orientation": ("1", (2, 4)),
                                "fingertips": ("m", (1, 3))})
    node.add(times(5), {"gyr": np.zeros((5, 2, 3)), "orientation": np.zeros((5, 2, 4)),
                        "fingertips": np.zeros((5, 1, 3))})
    run = write_run(tmp_path / "run.h5", [node], parameters={"imus": {"sites": ["hand", "F2p"]}})
    streams, header = read(export(run, "xdf", tmp_path / "run.xdf").path)
    assert header["info"]["version"] == ["1.0"]
    gyr, orientation = streams["imus.gyr"], streams["imus.orientation"]
    assert told(gyr, "label")[3:] == ["gyr.F2p.x", "gyr.F2p.y", "gyr.F2p.z"]
    assert told(gyr, "unit") == ["rad/s"] * 6
    assert told(orientation, "type")[:4] == [f"Orientation{part}" for part in "ABCD"]
    assert told(orientation, "unit")[0] == "quaternion"
    assert told(streams["imus.fingertips"], "type") == ["PositionX", "PositionY", "PositionZ"]
    assert told(streams["imus.fingertips"], "unit") == ["meters"] * 3
    assert orientation["info"]["type"] == ["MoCap"]
    assert streams["events"]["info"]["type"] == ["Markers"]
    assert float(gyr["info"]["nominal_srate"][0]) == 100.0
    assert gyr["footer"]["info"]["sample_count"] == ["5"]


def test_a_file_of_many_pieces_has_its_streams_interleaved(tmp_path):
    rows = 60_000
    values = np.random.default_rng(1).normal(size=(rows, 5))
    nodes = [Node(name, kind, {"y": ("1", (5,))}).add(times(rows), {"y": values + number})
             for number, (name, kind) in enumerate((("one", BLOCK), ("two", PLANT)))]
    path = export(write_run(tmp_path / "run.h5", nodes), "xdf", tmp_path / "run.xdf").path
    content = path.read_bytes()
    assert content.count(bytes.fromhex("43a546dccbf5410fb30ed5467383cbe4")) > 8
    streams, _ = read(path)
    same(streams["one.y"]["time_series"], values)
    same(streams["two.y"]["time_series"], values + 1)
    for name in ("one.stamps", "two.stamps"):
        np.testing.assert_array_equal(streams[name]["time_series"][:, 0], np.arange(rows))
    ends = []
    for stream in streams.values():
        if stream["info"]["name"][0] in ("one.y", "two.y"):
            sample = stream["time_series"][rows // 2].tobytes()
            ends.append(content.index(sample))
    assert abs(ends[0] - ends[1]) < len(content) / 4


def test_headers_are_xml_whatever_a_node_is_called(tmp_path):
    name = 'a<b>&"c"\x0b'
    node = Node(name, BLOCK, {"y": ("1", ())}).add(times(1), {"y": np.ones(1)})
    path = export(write_run(tmp_path / "run.h5", [node]), "xdf", tmp_path / "run.xdf").path
    content = path.read_bytes()
    start = content.index(b"<?xml", content.index(b"<?xml") + 1)
    header = content[start:content.index(b"</info>", start) + len(b"</info>")]
    assert ElementTree.fromstring(header).findtext("name") == 'a<b>&"c"?.y'
