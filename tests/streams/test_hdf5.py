"""HDF5 of others: what would hang HDF5 itself, leads elsewhere or takes more than there is, is refused."""

import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from mat73_files import write_mat73

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.streams.files import open_recording
from fesloop.streams.hdf5 import require_sound_heaps
from fesloop.streams.reading import read_container


def with_text(path, **attributes):
    with h5py.File(path, "w", libver="latest") as file:
        file.attrs.update(attributes or {"format": "fesloop motion 1", "source": "lab.xdf"})
    return path


def with_an_endless_heap(path):
    """The first free object of the global heap gets the size 0, so that walking it never ends."""
    with_text(path)
    content = bytearray(path.read_bytes())
    heap = content.index(b"GCOL")
    at = heap + 16
    while int.from_bytes(content[at:at + 2], "little"):
        at += 16 + -(-int.from_bytes(content[at + 8:at + 16], "little") // 8) * 8
    content[at + 8:at + 16] = bytes(8)
    path.write_bytes(bytes(content))
    return path


@pytest.mark.slow
def test_a_heap_without_end_is_refused_at_once_though_hdf5_hangs_on_it(tmp_path):
    path = with_an_endless_heap(tmp_path / "m.h5")
    with pytest.raises(subprocess.TimeoutExpired):
        subprocess.run([sys.executable, "-c", f"import h5py; dict(h5py.File({str(path)!r}).attrs)"],
                       timeout=3.0, check=False)
    began = time.process_time()
    for read in (open_recording, Recording, read_container):
        with pytest.raises(InputError, match="heap of texts at byte"):
            read(path)
    assert time.process_time() - began < 1.0


def test_sound_heaps_pass_and_text_that_looks_like_one_does_no_harm(tmp_path):
    path = with_text(tmp_path / "m.h5", **{f"key{k}": "GCOL" * k for k in range(60)})
    require_sound_heaps(path)
    with h5py.File(path) as file:
        assert file.attrs["key59"] == "GCOL" * 59


def test_links_and_data_that_lie_elsewhere_are_not_followed(tmp_path):
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["imu_gyr"] = np.ones((4, 3))
    (tmp_path / "raw").write_bytes(np.ones(12).tobytes())
    for name, make in {
            "link": lambda file: file.__setitem__("imu_gyr", h5py.ExternalLink("secret.h5", "imu_gyr")),
            "soft": lambda file: file.__setitem__("imu_gyr", h5py.SoftLink("/imu_acc")),
            "external": lambda file: file.create_dataset("imu_gyr", (4, 3), "f8",
                                                         external=[(str(tmp_path / "raw"), 0, 96)])}.items():
        with h5py.File(tmp_path / name, "w") as file:
            make(file)
        with pytest.raises(InputError, match=r"imu_gyr: (is a link|lies in another file)"):
            read_container(tmp_path / name)


def test_what_a_small_file_declares_is_not_allocated(tmp_path):
    with h5py.File(tmp_path / "big", "w") as file:
        file.create_dataset("imu_gyr", (10**9, 3), "f8", chunks=(1000, 3), compression="gzip")
    with pytest.raises(InputError, match=r"imu_gyr: cannot be read: .*22.4 GiB"):
        read_container(tmp_path / "big")


def test_cells_structures_and_text_of_matlab(tmp_path):
    content = {"s": {"name": "größer", "deep": {"m": np.arange(6.0).reshape(2, 3)}},
               "cells": ["one", np.arange(3.0), {"x": 1.0}], "v": np.arange(4.0), "scalar": 5.0}
    read = read_container(write_mat73(tmp_path / "m.mat", content))
    assert read["s"]["name"] == "größer"
    np.testing.assert_array_equal(read["s"]["deep"]["m"], content["s"]["deep"]["m"])
    assert read["cells"][0] == "one"
    np.testing.assert_array_equal(read["cells"][1], np.arange(3.0))
    assert read["cells"][2]["x"] == 1.0
    np.testing.assert_array_equal(read["v"], content["v"])
    assert read["scalar"] == 5.0
    assert "#refs#" not in read


def test_cells_in_a_ring_come_to_an_end(tmp_path):
    path = write_mat73(tmp_path / "m.mat", {"cells": ["one"]})
    with h5py.File(path, "a") as file:
        file["cells"][0, 0] = file["cells"].ref
    with pytest.raises(InputError, match="maximum recursion depth"):
        read_container(path)
