"""The reader process: what others' decoders give comes back whole; what makes them crash, hang or fill the
memory is refused in one line, and the next file is read."""

import os
import struct
import subprocess
import sys
import zlib

import h5py
import numpy as np
import pytest
import scipy.sparse
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from fesloop.errors import InputError
from fesloop.streams import reading
from fesloop.streams.reading import read_container

LEAVES = st.one_of(
    st.integers(-5, 5).map(float), st.text("abc", min_size=1, max_size=4),
    st.sampled_from(["f8", "f4", "i2", "u1", "c16"]).map(lambda kind: np.ones((2, 3), kind)))
VALUES = st.recursive(LEAVES, lambda inner: st.dictionaries(
    st.sampled_from(["a", "bc", "def"]), inner, min_size=1, max_size=3), max_leaves=6)


def same(read, written):
    if isinstance(written, dict):
        return read.keys() == written.keys() and all(same(read[key], written[key]) for key in written)
    if isinstance(written, list):
        return len(read) == len(written) and all(map(same, read, written))
    return np.array_equal(read, written)


@given(content=st.dictionaries(st.sampled_from(["x", "y", "z"]), VALUES, min_size=1),
       compressed=st.booleans())
@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_numbers_text_and_structures_come_back_as_they_were_written(tmp_path, content, compressed):
    savemat(tmp_path / "m.mat", content, do_compression=compressed)
    assert same(read_container(tmp_path / "m.mat"), content)


@pytest.mark.parametrize("kind", ["<f8", ">f8", "f4", "i1", "<i8", "u2", "?", "c16"])
def test_arrays_of_every_type_and_shape_come_back_bit_for_bit(tmp_path, kind):
    rng = np.random.default_rng(3)
    content = {f"{shape}": rng.integers(0, 2, shape).astype(kind) for shape in ((), (0, 3), (4,), (2, 3, 5))}
    np.savez(tmp_path / "a.npz", **content, names=["x", "ö"])
    read = read_container(tmp_path / "a.npz")
    assert read.pop("names") == ["x", "ö"]
    for key, array in content.items():
        assert read[key].dtype == array.dtype
        assert read[key].shape == array.shape
        assert read[key].tobytes() == array.tobytes()


def test_sparse_matrices_are_left_out(tmp_path):
    savemat(tmp_path / "m.mat", {"sparse": scipy.sparse.eye_array(3, format="csc"), "gyr": np.ones((4, 3))})
    assert list(read_container(tmp_path / "m.mat")) == ["gyr"]


def matrix(flags, shape, *elements):
    """A matrix named x, of elements (type, bytes)."""
    body = b""
    for kind, content in ((6, struct.pack("<II", flags, 0)),
                          (5, struct.pack(f"<{len(shape)}i", *shape)), (1, b"x"), *elements):
        body += struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)
    return struct.pack("<II", 14, len(body)) + body


HEADER = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
DOUBLES, CELL, STRUCTURE, TEXT = 6, 1, 2, 4
BAD = {
    "a type that is none": matrix(DOUBLES, (2, 1), (225, bytes(16))),
    "fewer numbers than its shape": matrix(DOUBLES, (1000, 1000), (9, bytes(16))),
    "a billion empty cells": matrix(CELL, (1 << 15, 1 << 15)),
    "a billion blanks": matrix(TEXT, (1, 1 << 30), (4, b"")),
    "a structure of a billion": matrix(STRUCTURE, (1 << 30, 1), (5, struct.pack("<i", 2)), (1, b"a\0")),
    "fields of width 0": matrix(STRUCTURE, (1, 1), (5, struct.pack("<i", 0)), (1, b"a\0")),
    "negative extents": matrix(DOUBLES, (-1, -2), (9, bytes(16))),
    "an element beyond the end": matrix(DOUBLES, (2, 1), (9, bytes(16)))[:-8],
    "an imaginary part that is missing": matrix(DOUBLES | 0x800, (2, 1), (9, bytes(16))),
    "no matrix": struct.pack("<II", 9, 8) + bytes(8),
    "no compressed content": struct.pack("<II", 15, 8) + bytes(8),
}


@pytest.mark.parametrize("what", list(BAD))
def test_a_matlab_file_that_is_not_what_it_says_is_refused(tmp_path, what):
    path = tmp_path / "m.mat"
    path.write_bytes(HEADER + BAD[what])
    with pytest.raises(InputError) as caught:
        read_container(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_a_crash_of_a_decoder_is_one_line_and_the_next_file_is_read(tmp_path):
    (tmp_path / "m.mat").write_bytes(HEADER + BAD["a type that is none"])
    done = subprocess.run([sys.executable, "-c", "import sys; from scipy.io import loadmat; "
                           f"loadmat({str(tmp_path / 'm.mat')!r})"], capture_output=True, check=False)
    assert done.returncode != 0
    with pytest.raises(InputError, match=r"crashes its reader \(SIG|truncated or corrupt"):
        read_container(tmp_path / "m.mat")
    np.savez(tmp_path / "sound.npz", x=np.ones(3))
    assert read_container(tmp_path / "sound.npz")["x"].tolist() == [1.0, 1.0, 1.0]


def test_what_would_take_too_much_memory_is_refused(tmp_path):
    path = tmp_path / "m.mat"
    deflating = zlib.compressobj(1)
    head = matrix(DOUBLES, (10**8, 1), (9, b""))[:-8] + struct.pack("<II", 9, 8 * 10**8)
    head = struct.pack("<II", 14, 8 * 10**8 + len(head) - 8) + head[8:]
    deflated = deflating.compress(head) + b"".join(deflating.compress(bytes(10**7)) for _ in range(80))
    deflated += deflating.flush()
    path.write_bytes(HEADER + struct.pack("<II", 15, len(deflated)) + deflated)
    assert path.stat().st_size < 10**7
    with pytest.raises(InputError, match=r"would take more than \d+ MB of memory"):
        read_container(path)


def test_what_takes_too_long_is_refused_and_the_next_file_is_read(tmp_path):
    """Forty cells of two references each to the next one: two to the power of forty in all."""
    path = tmp_path / "long.mat"
    with h5py.File(path, "w") as file:
        after = file.create_dataset("last", data=np.ones(2))
        for number in range(40):
            cell = file.create_dataset(f"c{number}", (2,), dtype=h5py.ref_dtype)
            cell[:] = [after.ref, after.ref]
            after = cell
    reader = reading._Reader()
    reader.seconds = 0
    with pytest.raises(InputError, match=r"long.mat: is not read within 1 s"):
        reader.ask("hdf5", path, {})
    np.savez(tmp_path / "sound.npz", x=np.ones(3))
    assert reader.ask("npz", tmp_path / "sound.npz", {})["x"].sum() == 3.0
    reader.close()


def test_a_process_that_ended_since_the_last_file_is_started_again(tmp_path):
    np.savez(tmp_path / "sound.npz", x=np.ones(3))
    reader = reading._Reader()
    for _ in range(2):
        assert reader.ask("npz", tmp_path / "sound.npz", {})["x"].sum() == 3.0
        reader.close()
        code = f"import os, sys; sys.stdin.readline(); os._exit({reading.IDLE})"
        reader._process = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE,
                                           stdout=subprocess.PIPE)
    reader.close()


def test_a_process_without_files_ends_after_a_while():
    code = "from fesloop.streams import decoders; decoders.IDLE_S = 0.2; decoders.serve()"
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE) as process:
        assert process.wait(60) == reading.IDLE


def test_pickles_in_a_file_are_not_run(tmp_path):
    class Spoils:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "spoilt"),)

    np.savez(tmp_path / "p.npz", x=np.array([Spoils()], dtype=object))
    with pytest.raises(InputError, match="pickled object"):
        read_container(tmp_path / "p.npz")
    assert not (tmp_path / "spoilt").exists()
