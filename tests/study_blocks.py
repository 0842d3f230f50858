"""A block that does harm, for tests of what a study makes of that; worker processes find its kind, too."""

import os
import time
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from fesloop.analysis.study.engine.preparing import Prepared
from fesloop.analysis.study.store.versions import version_text
from fesloop.loop.block import Context
from fesloop.loop.signals import Port


@dataclass(slots=True)
class Harm:
    """Of a harmful block: nothing to remember."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Harmful:
    """Does its deed at its first step, after a while: raise (`unless` there is a marker), exit, full."""

    deed: str = "none"
    marker: str = ""
    wait_s: float = 0.0
    inputs = ()

    @property
    def outputs(self):
        return (Port("y"),)

    def init(self, context: Context) -> Harm:
        return Harm()

    def step(self, state, inputs, tick):
        if tick.index == 0:
            time.sleep(self.wait_s)
            if self.deed == "raise" or (self.deed == "unless" and not Path(self.marker).exists()):
                raise ValueError("harm is done")
            if self.deed == "exit":
                os._exit(7)
            if self.deed == "full":
                raise OSError(28, "No space left on device")
        return (1.0,)


def slowly(value):
    """What a worker gives back after a while."""
    time.sleep(0.5)
    return value


def waited(value, wait_s):
    """The value, in a tuple, after a while."""
    time.sleep(wait_s)
    return (value,)


def prepared_or_not(id, document, seed, code):
    """A shipped model, unless a folder says no: for `fesloop.analysis.study.engine.preparing.prepare_one`."""
    folder = Path(os.environ["STUDY_BLOCKS"])
    (folder / f"{id}-{time.monotonic_ns()}.prepared").touch()
    if (folder / "fails").exists():
        return Prepared(id, "failed", "no force was seen", "", "here", version_text())
    model = resources.files("fesloop.models") / "shipped" / "grasp_finger.toml"
    return Prepared(id, "done", "", model.read_text(encoding="utf-8"), "here", version_text())
