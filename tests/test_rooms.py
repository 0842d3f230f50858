"""Rooms of the block packages: what is meant for use is found there, and not loaded before it is used."""

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
ROOMS = sorted(".".join(init.parent.relative_to(ROOT).parts)
               for package in ("plants", "controllers", "estimators")
               for init in (ROOT / package).glob("*/__init__.py") if "found_in" in init.read_text())


def test_there_are_rooms():
    assert {"plants.hand", "controllers.mpc", "estimators.kortier"} <= set(ROOMS)


@pytest.mark.parametrize("room", ROOMS)
def test_what_a_room_names_lives_in_it(room):
    module = import_module(room)
    assert module.__all__
    for name in module.__all__:
        found = getattr(module, name)
        assert found.__qualname__ == name
        assert found.__module__.startswith(f"{room}.")
    with pytest.raises(AttributeError, match=f"module '{room}' has no attribute 'Nothing'"):
        _ = module.Nothing


def test_a_room_loads_nothing_before_it_is_used():
    """The keeper of a device, a process that is to be small and quick, takes a part of such a room."""
    within = tuple(f"{room}." for room in ROOMS)
    script = (f"import sys, {', '.join(ROOMS)}\n"
              f"print([name for name in sys.modules if name.startswith({within})], 'numpy' in sys.modules)")
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True, stdout=subprocess.PIPE,
                          text=True)
    assert done.stdout == "[] False\n"
