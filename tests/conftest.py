"""Fixtures for what lies outside the project: real recordings and the peers' scripts."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def outside(variable, default):
    """A folder named by an environment variable; the test skips where it is absent."""
    folder = Path(os.environ.get(variable, ROOT.parent / "shared" / default))
    if not folder.is_dir():
        pytest.skip(f"{variable}: no folder {folder}")
    return folder


@pytest.fixture(scope="session")
def recordings():
    """Folder of real recordings."""
    return outside("FESLOOP_RECORDINGS", "data")


@pytest.fixture(scope="session")
def peers():
    """Folder of scripts that measure what a user would pick instead."""
    return outside("FESLOOP_PEERS", "peers")


def pytest_collection_modifyitems(items):
    """Tests that need a browser say so by what they use."""
    for item in items:
        if "chromium" in item.fixturenames:
            item.add_marker(pytest.mark.browser)
