"""`fesloop import`: any known format into a motion file, one line or one JSON object, and nothing over."""

import json

import numpy as np
import pytest
import xdf_files
from recording_files import write

from fesloop.apps.cli import main
from fesloop.streams.files import import_recording, open_recording


def test_an_xdf_file_becomes_a_motion_file_that_opens_as_the_same(tmp_path, capsys):
    source, target = tmp_path / "lab.xdf", tmp_path / "motion.h5"
    source.write_bytes(xdf_files.motion_file())
    assert main(["import", str(source), str(target), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["source"] == "lab.xdf"
    assert told["sensors"] == ["imu"]
    assert told["samples"] == 400
    assert told["source_units"]["gyr"] == "deg/s"
    np.testing.assert_array_equal(open_recording(target).gyr, open_recording(source).gyr)
    assert main(["import", str(source), str(target)]) == 2
    assert "exists" in capsys.readouterr().err


def test_channels_that_are_left_out_are_told(tmp_path, capsys):
    (tmp_path / "lab.xdf").write_bytes(xdf_files.motion_file(labels=[*xdf_files.MOTION_LABELS[:6], *"abc"]))
    assert main(["import", str(tmp_path / "lab.xdf"), str(tmp_path / "motion.h5"), "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["left_out"] == ["a", "b", "c"]
    assert "lab.xdf: channels left out, not understood: 'a', 'b', 'c'" in err


def test_a_motion_file_is_imported_anew_with_its_first_source(tmp_path):
    import_recording(write(tmp_path, "wrist"), tmp_path / "one.h5")
    again = import_recording(tmp_path / "one.h5", tmp_path / "two.h5")
    assert again.source == "trial.dat"
    assert again.source_format == "wrist"


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04" + bytes(30), b"XDF:\x01"])
def test_what_cannot_be_read_leaves_nothing_behind(tmp_path, capsys, content):
    (tmp_path / "lab").write_bytes(content)
    assert main(["import", str(tmp_path / "lab"), str(tmp_path / "motion.h5")]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["lab"]
