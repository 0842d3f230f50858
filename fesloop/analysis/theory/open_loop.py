"""Open-loop transfer of a linear loop, for the design methods of python-control."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.theory.linear_loop import linear_loop, within_floats
from fesloop.analysis.theory.loop import LinearLoop
from fesloop.analysis.theory.period_map import PeriodRun
from fesloop.analysis.theory.schedule import Delivery, schedule
from fesloop.errors import InputError
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.nodes import Connection

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]


@within_floats("the open loop")
def open_loop(loop: LinearLoop | Experiment, wire: str = "") -> control.StateSpace:
    """Transfer around the loop, cut at one wire, with the sign of negative feedback.

    It is a discrete-time system over the period after which the loop repeats itself: from what the wire's
    target reads to what then arrives at the same place, times -1, with every latency and hold between. The
    closed loop is its unit negative feedback, so that `control.margin` and `control.feedback` apply.

    Parameters
    ----------
    loop: a linear loop, or an experiment that is one.
    wire: name of the wire to cut, such as "finger.angles->pid.measured"; "": the first that delivers once a
        period, on a loop that is a single ring.

    Raises InputError for a loop that is not linear, for jitter or loss, for a loop with branches where no
    wire is named, and for a wire that delivers more than once in a period.
    """
    linear = loop if isinstance(loop, LinearLoop) else linear_loop(loop)
    if linear.random:
        raise InputError(linear.name, "has jitter or loss on the loop", "fixed latencies",
                         "set them to zero to cut the loop")
    if wire:
        return _CutPeriod(linear, linear.wire(wire)).system()
    if len(linear.connections) != len(linear.blocks) + 1:
        raise InputError("wire", "the loop is no single ring: it matters where it is cut",
                         ", ".join(each.wire.name for each in linear.connections), "name one")
    fault = None
    for connection in linear.connections:
        try:
            return _CutPeriod(linear, connection).system()
        except InputError as refused:
            fault = refused
    assert fault is not None
    raise fault


class _CutPeriod(PeriodRun):
    """A period in which the target of one wire reads an input from outside."""

    def __init__(self, loop: LinearLoop, cut: Connection) -> None:
        super().__init__(loop, schedule(loop, False), "")
        self.cut = cut
        self.returned: Array | None = None

    def system(self) -> control.StateSpace:
        """The transfer from the outside input to what the wire delivers, times -1."""
        import control

        steps, _ = self.run()
        assert len(steps) == 1
        if self.returned is None:
            raise InputError(self.cut.wire.name, "delivers nothing in a period", "a wire that delivers once")
        a, b, c = self.a, self.b, self.returned[:, :self.rows.total]
        return control.ss(a, b, -c, np.zeros((len(c), b.shape[1])), self.plan.period_ns / NS_PER_S)

    def _deliver(self, delivery: Delivery) -> None:
        """Deliver as in the closed loop, but from outside at the cut."""
        super()._deliver(delivery)
        if delivery.connection is not self.cut:
            return
        if self.returned is not None:
            raise InputError(self.cut.wire.name, "delivers more than once in the "
                             f"{1e-6 * self.plan.period_ns:g} ms after which the loop repeats itself",
                             "one delivery", "cut another wire, or give all blocks one rate")
        number = 0 if self.cut.target is self.loop.plant else self.cut.target_port
        port = self.rows.port[self.cut.target.name, number]
        self.returned = self.z[port].copy()
        self.entry = slice(self.z.shape[1], self.z.shape[1] + port.stop - port.start)
        self.z = np.hstack([self.z, np.zeros((len(self.z), port.stop - port.start))])
        self.z[port] = 0.0
        self.z[port, self.entry] = np.eye(port.stop - port.start)

    def _end(self) -> None:
        """Keep the matrices before the rows are used up."""
        self.a = self.z[:, :self.rows.total]
        self.b = self.z[:, self.entry] if self.returned is not None else self.z[:, :0]
        super()._end()
