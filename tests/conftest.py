"""Fixtures for real recordings and the peers' scripts, and how all tests run beside each other."""

import gc
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Tests run side by side, one a core, and threads of BLAS would only wait for each other. NumPy reads this
# when it is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Neither of these limits is a claim about the library, and a busy machine exceeds both.
settings.register_profile("fesloop", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("fesloop")

ROOT = Path(__file__).resolve().parent.parent
ORDER = {**dict.fromkeys(("conformance", "controllers", "estimators", "hand", "loop", "models", "plants"), 0),
         **dict.fromkeys(("experiment", "picture", "tracker_error"), 2)}
"""Tests that compile what they are about come first, tests of what is made of it last: of two processes that
begin with the first and the second half, one compiles for both."""


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
    """Mark tests that use a browser, and order all."""
    items.sort(key=lambda item: ORDER.get(item.path.relative_to(ROOT).parts[1], 1))
    for item in items:
        if "chromium" in item.fixturenames:
            item.add_marker(pytest.mark.browser)


def pytest_collection_finish():
    """Spare the collector all that importing has left."""
    collect_and_freeze()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item, nextitem):
    """Spare the collector what a module leaves: passes over a whole session cost more than most tests."""
    if nextitem is not None and nextitem.path != item.path:
        collect_and_freeze()


def collect_and_freeze():
    """Collect what nothing refers to, and leave all else out of later collections."""
    gc.collect()
    gc.freeze()
