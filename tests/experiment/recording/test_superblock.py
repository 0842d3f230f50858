"""The superblock as HDF5 reads it; files that were cut before their writer was done are refused at once."""

import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.rescue import checksum, mark_closed
from fesloop.experiment.running import run

_AT_ONCE_S = 120.0
READ = """
import sys
from pathlib import Path
from fesloop.errors import InputError
from fesloop.show.report.run.opening import readable
try:
    with readable(Path(sys.argv[1])) as (recording, notices):
        print("shown", len(notices))
except InputError:
    print("refused")
"""


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    settings = ["experiment.duration_s=1", "score.after_s=0"]
    return Path(run(load("finger_control", settings), tmp_path_factory.mktemp("runs")).recording)


@pytest.fixture
def unclosed(sound, tmp_path):
    """A recording as a killed writer leaves it: HDF5 says that it is open for writing."""
    path, copy = tmp_path / "open.h5", tmp_path / "unclosed.h5"
    shutil.copy(sound, path)
    with h5py.File(path, "r+", libver="latest") as file:
        file["status"][()] = b"running"
        file.swmr_mode = True
        file.flush()
        shutil.copy(path, copy)
    with pytest.raises(OSError, match="already open for"):
        h5py.File(copy, "r")
    return copy


def test_the_checksum_is_the_one_that_hdf5_wrote(sound, unclosed):
    for path in (sound, unclosed):
        block = path.read_bytes()[:48]
        assert checksum(block[:44]) == block[44:]


def test_the_checksum_is_that_of_its_author_s_own_example():
    assert checksum(b"Four score and seven years ago")[::-1].hex() == "17770551"


def test_a_file_that_is_marked_closed_opens_as_any_other(unclosed):
    mark_closed(unclosed)
    with h5py.File(unclosed, "r") as file:
        assert file["status"][()] == b"running"


@pytest.mark.parametrize("size", [0, 20, 47])
def test_nothing_is_done_to_a_superblock_that_is_not_whole(unclosed, size):
    unclosed.write_bytes(unclosed.read_bytes()[:size])
    mark_closed(unclosed)
    assert unclosed.stat().st_size == size


@pytest.mark.slow
@pytest.mark.parametrize(("share", "found"), [
    (0.00003, "refused"), (0.005, "refused"), (0.05, ""), (0.5, "shown"), (1.0, "shown 0")])
@pytest.mark.parametrize("which", ["sound", "unclosed"])
def test_what_was_cut_is_read_or_refused_at_once(request, tmp_path, which, share, found):
    """HDF5 reads what is damaged of a file that has a writer again and again, for hours."""
    whole = request.getfixturevalue(which).read_bytes()
    path = tmp_path / "cut.h5"
    path.write_bytes(whole[:int(share * len(whole))])
    done = subprocess.run([sys.executable, "-c", READ, str(path)], capture_output=True, text=True,
                          timeout=_AT_ONCE_S, check=True)
    assert done.stdout.startswith(found)
