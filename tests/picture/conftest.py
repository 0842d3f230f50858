"""Recordings to draw."""

from pathlib import Path

import pytest

from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run

GRASP = str(Path(__file__).parent / "grasp.toml")


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """Run the grasp with settings; the recording's path."""
    def record(*settings):
        return Path(run(load(GRASP, settings), tmp_path_factory.mktemp("runs")).recording)

    return record


@pytest.fixture(scope="session")
def grasp(recorded):
    """The recording of the grasp as it is written."""
    return recorded()
