"""Some elements of a vector, such as the one joint of many that a controller is to move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Port, Sample, Value
from fesloop.models.linear_form import BlockToControl, SampledForm, memoryless


@dataclass(frozen=True, slots=True, kw_only=True)
class Select(BlockToControl):
    """Picks elements of a vector.

    Input `vector` (size,), output `elements` (len(indices),), both in `unit`.

    Attributes
    ----------
    indices: of the elements, from 0, in the order of the output.
    unit: of both ports.
    size: of the vector; 0 takes it from the wire.
    """

    indices: tuple[int, ...]
    unit: str = "rad"
    size: int = 0

    def __post_init__(self) -> None:
        if not self.indices:
            raise InputError("indices", "no index", "one or more")
        if self.size < 0:
            raise InputError("size", f"{self.size}", "1 or more, or 0 for the size of the wire")
        most = self.size - 1 if self.size else None
        for index in self.indices:
            if index < 0 or (most is not None and index > most):
                raise InputError("indices", f"{index}", "0 or more" if most is None else f"0 to {most}")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`vector`."""
        return (Port("vector", (self.size or None,), self.unit),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`elements`."""
        return (Port("elements", (len(self.indices),), self.unit),)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Select:
        """The block for the wired size; raises InputError where an index is beyond it or it is no vector."""
        shape = shapes["vector"]
        if len(shape) != 1:
            raise InputError("vector", f"a signal of shape {shape} is wired in", "a vector: shape (size,)")
        return replace(self, size=shape[0])

    def linear_form(self, context: Context) -> SampledForm:
        """Selection matrix."""
        return memoryless(("vector",), "elements", np.eye(self.size)[list(self.indices)])

    def init(self, context: Context) -> None:
        """No state."""

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The elements of the newest vector; no output before the first."""
        vector = inputs[0]
        return (np.asarray(vector.value)[list(self.indices)],) if vector.present else ()
