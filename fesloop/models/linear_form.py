"""Linear forms of blocks and plants, from which the theory of a loop is built.

Deviations from rest are what counts; constants and limits (`offset`, `least`, `greatest`) tell where a loop
rests, and whether it is linear there.
A signal of stimulation (channels, 2) counts as one number a channel: the drive, where `curves` turn drives
into pulses and a plant's own turn them back, else the pulse width in s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Port
from fesloop.models.linear_model import LinearModel, Recruitment

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledForm:
    """x[k+1] = a x[k] + b u[k], y[k] = c x[k] + d u[k] + noise w[k] at the ticks, w white, standard normal.

    Attributes
    ----------
    inputs: names of the ports that u stacks; what comes to others makes no difference at rest.
    output: name of the port that y is.
    a, b, c, d: (n, n), (n, inputs), (outputs, n), (outputs, inputs); n may be 0.
    noise: (outputs, noises); may have no columns.
    curves: recruitment that the block inverts to make pulses of drives.
    passes_pulses: whether it puts out the pulses that it reads, as they are.
    offset: (outputs,), a constant added to y; None for none.
    least, greatest: (outputs,), limits that y is cut to; None for none.
    """

    inputs: tuple[str, ...]
    output: str
    a: Array
    b: Array
    c: Array
    d: Array
    noise: Array
    curves: Recruitment | None = None
    passes_pulses: bool = False
    offset: Array | None = None
    least: Array | None = None
    greatest: Array | None = None

    def to_control(self, period_s: float) -> control.StateSpace:
        """Deviations from rest without noise, as a discrete-time `control.StateSpace`."""
        import control

        return control.ss(self.a, self.b, self.c, self.d, period_s)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContinuousForm:
    """x' = a x + b u(t - delay), y = c x, time in s.

    Attributes
    ----------
    input, output: names of the ports.
    a, b, c: (n, n), (n, inputs), (outputs, n).
    delay_ns: of the input.
    curves: recruitment that turns pulses into u.
    offset: (outputs,), y at u = 0; None for zero.
    """

    input: str
    output: str
    a: Array
    b: Array
    c: Array
    delay_ns: int = 0
    curves: Recruitment | None = None
    offset: Array | None = None

    def to_control(self, rate: str | int | float | None = None, pade_order: int = 0) -> control.StateSpace:
        """Deviations from rest as a `control.StateSpace`; parameters as of `LinearModel.to_control`."""
        model = LinearModel(a=self.a, b=self.b, c=self.c, offset=np.zeros(len(self.c)),
                            delay_ns=self.delay_ns)
        return model.to_control(rate, pade_order)

    @classmethod
    def of(cls, model: LinearModel, input: str, output: str, per_unit: float = 1.0) -> ContinuousForm:
        """The form of a model whose drive is `per_unit` times what the input carries."""
        return cls(input=input, output=output, a=model.a, b=per_unit * model.b, c=model.c,
                   delay_ns=model.delay_ns, curves=model.recruitment, offset=model.offset)


@runtime_checkable
class LinearBlock(Protocol):
    """A sampled block that is linear, or can be."""

    def linear_form(self, context: Context) -> SampledForm:
        """Raises InputError, named by a parameter, for what is not linear."""


@runtime_checkable
class LinearPlant(Protocol):
    """A plant that is linear, or can be."""

    def linear_form(self, output: Any) -> ContinuousForm:
        """With one of its outputs; raises InputError, named by a parameter, for what is not linear."""


class BlockToControl:
    """Adds `to_control` to a sampled block with a linear form."""

    __slots__ = ()

    def to_control(self: LinearBlock, rate: str | int | float) -> control.StateSpace:
        """The block at a rate in hertz, around rest and within its limits, as a `control.StateSpace`.

        Its inputs are those of `linear_form(...).inputs`, one after the other. A block that makes pulses is
        described from its inputs to drives (with linear recruitment: to pulse widths, s).
        """
        clock = RateClock.from_rate(rate)
        return self.linear_form(Context(type(self).__name__, clock=clock)).to_control(clock.period_s)


class PlantToControl:
    """Adds `to_control` to a plant with a linear form."""

    __slots__ = ()

    def to_control(self: LinearPlant, output: Any, rate: str | int | float | None = None,
                   pade_order: int = 0) -> control.StateSpace:
        """The plant around rest, to one of its outputs, as a `control.StateSpace`.

        A plant that takes pulses is described from drives (with linear recruitment: from pulse widths, s).
        `rate` and `pade_order` are as of `LinearModel.to_control`.
        """
        return self.linear_form(output).to_control(rate, pade_order)


def memoryless(inputs: tuple[str, ...], output: str, gain: Array, noise: Array | None = None,
               passes_pulses: bool = False) -> SampledForm:
    """y = gain u + noise w; `gain` is (outputs, inputs)."""
    outputs, given = gain.shape
    return SampledForm(
        inputs=inputs, output=output, a=np.zeros((0, 0)), b=np.zeros((0, given)), c=np.zeros((outputs, 0)),
        d=gain, noise=np.zeros((outputs, 0)) if noise is None else noise, passes_pulses=passes_pulses)


def uncovered(where: str, found: str, allowed: str) -> InputError:
    """Error for a part that is not linear, or beyond the theory."""
    return InputError(where, found, f"{allowed}, for the theory of a linear loop")


def numbers_of(port: Port) -> int:
    """Number of values that a port carries in a form."""
    sizes = [size for size in port.shape if size is not None]
    return sizes[0] if port.unit == "A,s" else int(np.prod(sizes, initial=1.0))
