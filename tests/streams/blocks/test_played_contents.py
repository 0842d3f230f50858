"""What is played is identified by its contents: whatever changes in a file makes another experiment of it."""

import json
import shutil

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_files import CONTENTS, write

import fesloop
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, load
from fesloop.experiment.playback import Playback
from fesloop.streams.blocks.replay import Replay, replay_of
from fesloop.streams.recording import content_hash


def experiment(kind, path, **more):
    return from_document({
        "experiment": {"name": "played", "duration_s": 0.05},
        "blocks": {"recording": {"kind": kind, "recording": str(path), **more}}, "wires": []})


def bent(kind, array):
    """The contents of a kind of file with one row of one array changed."""
    content = {key: np.array(value) if isinstance(value, np.ndarray) else value
               for key, value in CONTENTS[kind]().items()}
    content[array][20] = [0.0, 1.0, 0.0, 0.0] if array == "opt_quat" else content[array][20] + 0.25
    return content


@pytest.mark.parametrize("array", ["imu_gyr", "imu_acc", "imu_mag", "opt_quat"])
def test_another_recording_at_the_same_path_is_another_experiment(tmp_path, array):
    path = write(tmp_path, "broad")
    one, same = experiment("replay", path), experiment("replay", path)
    write(tmp_path, "broad", bent("broad", array))
    other = experiment("replay", path)
    assert one.fingerprint() == same.fingerprint() != other.fingerprint()
    with pytest.raises(InputError, match=r"has changed, its fingerprint is .*bring the file back") as refused:
        from_document(json.loads(one.as_json()))
    assert "\n" not in str(refused.value)
    with pytest.raises(InputError, match="has changed"):
        replay_of(one.document()["blocks"]["recording"])
    assert from_document(json.loads(other.as_json())) == other


def test_a_copy_elsewhere_has_the_same_fingerprint(tmp_path):
    path = write(tmp_path, "broad")
    copied = shutil.copy(path, tmp_path / f"copied{path.suffix}")
    assert Replay(recording=str(path)).fingerprint == Replay(recording=str(copied)).fingerprint


def test_another_run_at_the_same_path_is_another_experiment(tmp_path):
    made, another = (fesloop.load("finger_control", ["experiment.duration_s=0.6", f"experiment.seed={seed}"])
                     .run(tmp_path / str(seed)).recording for seed in (1, 2))
    path = tmp_path / "run.h5"
    shutil.copy(made, path)
    one = experiment("playback", path, signal="safety.stimulation")
    recording = one.run(tmp_path / "played").recording
    assert load(recording).fingerprint() == one.fingerprint()
    shutil.copy(another, path)
    other = experiment("playback", path, signal="safety.stimulation")
    assert other.fingerprint() != one.fingerprint()
    with pytest.raises(InputError, match="has changed"):
        load(recording)
    assert Playback(recording=str(path), signal="safety.stimulation").fingerprint


@given(values=st.lists(st.floats(allow_nan=False), min_size=1, max_size=12), at=st.integers(0, 11))
def test_any_number_any_shape_and_any_name_counts(values, at):
    array = np.array(values)
    changed = array.copy()
    number = changed[at % array.size]
    changed[at % array.size] = np.nextafter(number, 0.0) if number else 1.0
    hashes = [content_hash(["a"], [array]), content_hash(["b"], [array]), content_hash(["a"], [changed]),
              content_hash(["a"], [array[None]]), content_hash(["a"], [array, None])]
    assert len(set(hashes)) == len(hashes)
    assert hashes[0] == content_hash(["a"], [array.copy()])
