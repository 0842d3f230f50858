"""MATLAB 5: names as SciPy finds them, and what SciPy would crash on or allocate is refused before."""

import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
import scipy.sparse
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat, whosmat

from fesloop.errors import InputError
from fesloop.streams.containers.matlab import Mat5Error, sound_variables
from fesloop.streams.containers.reading import read_container
from fesloop.streams.room import Room

LEAVES = st.one_of(
    st.integers(-5, 5).map(float), st.text("abc ", max_size=4), st.just(np.zeros((0, 0))),
    st.sampled_from(["f8", "f4", "i2", "u1", "c16", "?"]).map(lambda kind: np.ones((2, 3), kind)))
VALUES = st.recursive(LEAVES, lambda inner: st.one_of(
    st.dictionaries(st.sampled_from(["a", "bc", "def"]), inner, min_size=1, max_size=3),
    st.lists(inner, min_size=1, max_size=3).map(lambda items: np.array([*items, None], dtype=object)[:-1])),
    max_leaves=6)


def write(path, content, compressed=False):
    savemat(path, content, do_compression=compressed)
    return path


@pytest.mark.slow
@given(content=st.dictionaries(st.sampled_from(["x", "y", "z"]), VALUES, min_size=1),
       compressed=st.booleans())
@settings(max_examples=60, deadline=None)
def test_whatever_scipy_writes_is_sound(tmp_path_factory, content, compressed):
    path = write(tmp_path_factory.mktemp("mat") / "m.mat", content, compressed)
    assert sound_variables(path, Room(path)) == [name for name, _, _ in whosmat(path)]


def test_sparse_matrices_are_left_out(tmp_path):
    content = {"sparse": scipy.sparse.eye_array(3, format="csc"), "gyr": np.ones((4, 3))}
    path = write(tmp_path / "m.mat", content)
    assert list(read_container(path)) == ["gyr"]


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
def test_what_is_not_what_it_says_is_refused(tmp_path, what):
    path = tmp_path / "m.mat"
    path.write_bytes(HEADER + BAD[what])
    with pytest.raises(Mat5Error):
        sound_variables(path, Room(path))
    with pytest.raises(InputError, match="truncated or corrupt"):
        read_container(path)


def test_scipy_crashes_on_a_type_that_is_none(tmp_path):
    """The reason for all this: should SciPy ever refuse it itself, less of it is needed."""
    path = tmp_path / "m.mat"
    path.write_bytes(HEADER + BAD["a type that is none"])
    done = subprocess.run([sys.executable, "-c", f"from scipy.io import loadmat; loadmat({str(path)!r})"],
                          capture_output=True, check=False, timeout=60)
    assert done.returncode != 0


@pytest.mark.slow
def test_what_would_not_fit_is_not_inflated(tmp_path):
    path = tmp_path / "m.mat"
    deflating = zlib.compressobj(1)
    deflated = b"".join(deflating.compress(bytes(10**6)) for _ in range(300)) + deflating.flush()
    path.write_bytes(HEADER + struct.pack("<II", 15, len(deflated)) + deflated)
    assert path.stat().st_size < 2 * 10**6
    with pytest.raises(InputError, match="not to unpack to more than"):
        read_container(path)
