"""Files that a user names: whatever the name, and whatever is there, a reader ends with an InputError."""

import os
import signal

import pytest

from fesloop import load
from fesloop.analysis.study import load as load_results
from fesloop.analysis.study.design.study_file import read_study
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.angle_courses import read_courses
from fesloop.experiment.export import export
from fesloop.experiment.export.target import published
from fesloop.experiment.recording.reading import Recording
from fesloop.show.report.run.opening import readable
from fesloop.show.view import sources
from fesloop.streams.files import open_recording
from fesloop.streams.formats.layout import read_layout
from fesloop.streams.hdf5 import open_hdf5
from plants.patients.files import load as load_patient

NAMES = ["x" * 300, "x" * 5000, "a\0b", "\ud800", "no/such"]
ENDINGS = ["", ".toml", ".h5", ".sqlite", ".xdf", "_motion.tsv"]


def readably(path):
    with readable(path):
        pass


READERS = {
    "load": load, "read_study": read_study, "patient": load_patient, "recording": Recording,
    "readable": readably, "view": sources.open_recording, "motion": open_recording, "layout": read_layout,
    "results": load_results, "courses": lambda path: read_courses(str(path), "", 0),
    "hdf5": lambda path: open_hdf5(path, "HDF5"), "export": lambda path: export(path, "csv")}


@pytest.fixture
def alarm():
    """A reader that waits for the writer of a pipe fails in place of holding the tests up."""
    def ring(*_):
        pytest.fail("it waits for the writer of a pipe")  # no OSError, which a reader would take for its own

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def refusal(reader, path):
    with pytest.raises(InputError) as raised:
        READERS[reader](path)
    lines = str(raised.value).splitlines()
    assert len(lines) == 1
    assert lines[0].isprintable()
    return lines[0]


@pytest.mark.parametrize("reader", READERS)
def test_a_name_that_no_file_has_is_refused(tmp_path, reader):
    for name in NAMES:
        for ending in ENDINGS:
            assert refusal(reader, tmp_path / f"{name}{ending}")


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("ending", [".toml", ".h5", ".sqlite"])
def test_a_pipe_is_refused_and_not_waited_for(tmp_path, reader, ending, alarm):
    os.mkfifo(tmp_path / f"pipe{ending}")
    assert refusal(reader, tmp_path / f"pipe{ending}")


@pytest.mark.parametrize("command", ["check", "run", "report", "picture", "identify", "study", "patient"])
@pytest.mark.parametrize("ending", [".toml", ".h5", ".sqlite"])
def test_a_name_that_is_too_long_is_refused_by_every_command(capsys, command, ending):
    assert main(["--traceback", command, "x" * 5000 + ending]) == 2
    line, = capsys.readouterr().err.splitlines()
    assert line.startswith("fesloop: xxx")


def test_a_target_that_no_file_can_have_is_refused(tmp_path):
    target = tmp_path / ("x" * 5000)
    with pytest.raises(InputError, match="nothing can be made there"), published(target, single=False):
        pass
