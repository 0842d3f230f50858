"""Trying an FMU out in a process of its own, so that one that crashes takes nothing with it."""

from __future__ import annotations

import json
import pickle
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from fesloop.errors import InputError, RunError
from plants.fmu.internal_step import InternalStep, continuous
from plants.fmu.process import START, STEP, TRY, TRY_FINER, FmuDiedError, FmuProcess, Isolation
from plants.fmu.running import FmuSetup


@dataclass(frozen=True, slots=True)
class Probed:
    """What a probe found out.

    Attributes
    ----------
    internal: the FMU's own fixed step.
    tells: whether it says which instant it has reached.
    coarse: part of what outputs move by which they differ with substeps half as long (model exchange).
    replays: whether a saved and restored state gave identical outputs.
    why_not: why not, "" if it does.
    """

    internal: InternalStep = field(default_factory=InternalStep)
    tells: bool = False
    coarse: float = 0.0
    replays: bool = False
    why_not: str = ""


def probe(setup: FmuSetup, folder: Path, path: Path, isolation: Isolation) -> Probed:
    """Try the FMU out.

    Raises InputError if it crashes, refuses, or takes too long before it can be stepped.
    """
    process, began, timeout_s = FmuProcess(isolation.memory_mb), time.monotonic(), isolation.start_timeout_s

    def call(request: bytes) -> bytes:
        process.limit(timeout_s, 1.0 - (time.monotonic() - began) / timeout_s)
        return process.call(request)

    stage = "initialisation"
    try:
        call(START + pickle.dumps((setup, folder, "probe")))
        stage = "its first step"
        call(STEP)
        return _tried(call, setup)
    except FmuDiedError as fault:
        raise InputError("path", f"{path}: in {stage} it {fault}", "an FMU that runs",
                         "have the FMU's maker mend it, or give it longer with probe_timeout_s") from None
    except RunError as fault:
        raise InputError("path", f"{path}: {str(fault).removeprefix('probe: ')}",
                         "an FMU that can be initialised", "check its start values and memory_mb") from None
    finally:
        process.end()


def _tried(call: Callable[[bytes], bytes], setup: FmuSetup) -> Probed:
    """What an FMU shows that has done its first step."""
    try:
        probed = Probed(**_answer(call(TRY)))
    except RunError as fault:
        unchecked = () if setup.description.internal_step_s else continuous(setup)
        why = f"with made-up inputs, when it was tried out at load, it {fault}"
        return Probed(InternalStep(0.0, (), unchecked, why), why_not=why)
    if probed.internal.length_s == 0.0:
        try:
            finer = _answer(call(TRY_FINER)).get("internal", InternalStep())
        except RunError:
            return probed
        return replace(probed, internal=finer) if finer.length_s else probed
    return probed


def _answer(content: bytes) -> dict[str, Any]:
    """Fields of `Probed`."""
    found: dict[str, Any] = json.loads(content)
    if "internal" in found:
        length_s, outputs, unchecked, why = found["internal"]
        found["internal"] = InternalStep(length_s, tuple(outputs), tuple(unchecked), why)
    return found
