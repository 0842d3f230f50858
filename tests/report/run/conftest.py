"""Recordings to report."""

from pathlib import Path

import pytest

from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """Run a shipped experiment with settings; the recording's path."""
    def record(name, *settings):
        return Path(run(load(name, settings), tmp_path_factory.mktemp("runs")).recording)

    return record


@pytest.fixture(scope="session")
def learning(recorded):
    """The recording of a finger that learns, three trials of it."""
    return recorded("finger_ilc", "trials=3")
