"""The state of an FMU plant: a live instance, which pickles where its FMU really replays."""

from __future__ import annotations

import os
import weakref
from collections.abc import Sequence
from contextlib import suppress
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError, SnapshotError
from fesloop.loop.signals import Value
from plants.fmu.archive import ExtractedFmu
from plants.fmu.ports import BoundPort, limits
from plants.fmu.process import IsolatedFmu, Isolation
from plants.fmu.running import FmuSetup, RunningFmu


class FmuState:
    """A live FMU: native code keeps its state, and saving it asks the FMU.

    Pickling or copying makes a second instance that goes on from the same state; SnapshotError where the
    FMU does not really replay. Freed by `end`, or when nobody holds it any more.
    """

    __slots__ = ("__weakref__", "_end", "_isolation", "_limits", "_outside", "_owner", "_reports", "_scales",
                 "extracted", "inputs", "read_plan", "running", "seen", "why_not")

    def __init__(self, setup: FmuSetup, extracted: ExtractedFmu, name: str, why_not: str,
                 isolation: Isolation | None) -> None:
        self.extracted, self.why_not, self._isolation = extracted, why_not, isolation
        self.running: RunningFmu | IsolatedFmu
        if isolation is None:
            self.running = RunningFmu(setup, extracted.folder, name)
        else:
            self.running = IsolatedFmu(setup, extracted.folder, name, extracted.path.name, isolation)
        self._owner = os.getpid()
        self._end = weakref.finalize(self, _end_unseen, self.running, extracted, self._owner)
        scales = [_scales([bound], bound.shape) for bound in setup.inputs]
        self.inputs = list(zip(_views(self.running.inputs.values, setup.inputs), scales, strict=True))
        self.seen: list[Value | None] = [None] * len(setup.inputs)
        self._limits = limits(setup.inputs)
        self._outside = np.zeros(self._limits[0].size, bool)
        self._reports: list[tuple[str, str]] = []
        self.read_plan, self._scales = _read_plan(setup.outputs), _scales(setup.outputs, (-1,))

    def step(self, inputs: Sequence[Value]) -> None:
        """One communication step; the FMU is given what differs from what it has."""
        changed = False
        seen = self.seen
        for i, value in enumerate(inputs):
            if value is not seen[i]:
                seen[i] = value
                view, scales = self.inputs[i]
                scaled = value if scales is None else value * scales[0] + scales[1]
                if (view != scaled).any():
                    view[...] = scaled
                    changed = True
        if changed:
            self._look_for_range()
        self.running.step(changed)
        values = self.running.outputs.values
        if not isfinite(np.vdot(values, values)) and not np.isfinite(values).all():
            self._refuse()

    def _look_for_range(self) -> None:
        """Report the inputs that go beyond the FMU's min and max, which are given to it all the same."""
        (low, high), values = self._limits, self.running.inputs.values
        outside = (values < low) | (values > high)
        fresh = np.flatnonzero(outside & ~self._outside)
        self._outside = outside
        ports = self.running.setup.inputs
        names = [v.name for bound in ports for v in bound.variables for _ in range(v.size)]
        latched_ms = 1e3 * self.running.setup.instant_s(self.running.tick)
        self._reports.extend(("out_of_range", f"{names[i]!r}, latched at {latched_ms:.6f} ms, is "
                           f"{values[i]:g} in the FMU's unit, outside "
                           f"its min and max, {low[i]:g} to {high[i]:g}") for i in fresh.tolist())

    def _refuse(self) -> None:
        """Raise RunError naming the first output that is not finite, whenever anybody looks at it next."""
        setup, values = self.running.setup, self.running.outputs.values
        elements = [(bound.port.name, v.name) for bound in setup.outputs for v in bound.variables
                    for _ in range(v.size)]
        first = int(np.argmin(np.isfinite(values)))
        port, variable = elements[first]
        time_ms = 1e3 * setup.instant_s(self.running.tick)
        hint = ("; if its integration diverges, raise substeps or step_rate"
                if setup.description.interface == "model_exchange" else "")
        raise RunError(f"{self.running.name}.{port} is not finite at {time_ms:.6f} ms: "
                       f"the FMU puts out {values[first]:g} for {variable!r}{hint}")

    def reports(self) -> list[tuple[str, str]]:
        """What there is to report, and what the FMU has said, since the last call."""
        told, self._reports = self._reports, []
        return told + [("fmu_warning", f"the FMU says: {text}") for text in self.running.take_messages()]

    def read(self) -> tuple[Value, ...]:
        """Fresh values of the outputs."""
        values = self.running.outputs.values
        values = (values.copy() if self._scales is None
                  else (values - self._scales[1]) / self._scales[0])
        return tuple([values.item(place) if isinstance(place, int) else values[place] if shape is None
                      else values[place].reshape(shape) for place, shape in self.read_plan])

    def end(self) -> None:
        """Terminate the FMU and free it; RunError where it crashes there."""
        if self._end.detach() is not None and os.getpid() == self._owner:
            self.running.end()

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        if self.why_not:
            raise SnapshotError(f"{self.running.name}: the state of {self.extracted.path.name} "
                                f"cannot be saved: {self.why_not}")
        try:
            saved = self.running.save()
        except RunError as fault:
            raise SnapshotError(str(fault)) from fault
        return _resumed, (self.running.setup, self.extracted, self.running.name,
                          self._isolation, saved, self._outside)


def _resumed(setup: FmuSetup, extracted: ExtractedFmu, name: str, isolation: Isolation | None,
             saved: Any, outside: NDArray[np.bool_]) -> FmuState:
    """A new instance in a saved state."""
    state = FmuState(setup, extracted, name, "", isolation)
    state.running.restore(saved)
    state._outside = outside
    return state


def _end_unseen(running: RunningFmu | IsolatedFmu, extracted: ExtractedFmu, owner: int) -> None:
    """Free an instance that nobody holds; its files may go only now. A forked child leaves its parent's."""
    if os.getpid() == owner:
        with suppress(RunError):
            running.end()
    del extracted


def _slices(ports: Sequence[BoundPort]) -> list[slice]:
    stops = np.cumsum([sum(v.size for v in bound.variables) for bound in ports], dtype=int).tolist()
    return [slice(start, stop) for start, stop in zip([0, *stops], stops, strict=False)]


def _views(values: Any, ports: Sequence[BoundPort]) -> list[Any]:
    """The part of a flat vector that belongs to each port, in the port's shape."""
    return [values[part].reshape(bound.shape) for part, bound in zip(_slices(ports), ports, strict=True)]


def _read_plan(ports: Sequence[BoundPort]) -> list[tuple[int | slice, tuple[int, ...] | None]]:
    """Of each output its place, and its shape where that is not simply flat."""
    plan: list[tuple[int | slice, tuple[int, ...] | None]] = []
    for part, bound in zip(_slices(ports), ports, strict=True):
        flat = len(bound.shape) == 1
        plan.append((part, None if flat else bound.shape) if bound.shape else (int(part.start), None))
    return plan


def _scales(ports: Sequence[BoundPort],
            shape: tuple[int, ...]) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Scale and offset of every element, in a shape; None where nothing is converted."""
    scales = np.array([scale for bound in ports for scale in bound.scales])
    offsets = np.array([offset for bound in ports for offset in bound.offsets])
    same = (scales == 1.0).all() and (offsets == 0.0).all()
    return None if same else (scales.reshape(shape), offsets.reshape(shape))
