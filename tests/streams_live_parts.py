"""Sources of samples that go by a plan, and a tick to step a block with."""

from collections import deque
from threading import Event

import numpy as np

from fesloop.loop.abilities import Present
from fesloop.loop.block import Tick
from fesloop.streams.live.source import Pulled, StreamLost


class PlannedSource:
    """Gives what it was told to: samples, None for silence, a StreamLost for a loss."""

    def __init__(self, plan=(), reopenings=()):
        self.plan, self.reopenings = deque(plan), deque(reopenings)
        self.closed = 0

    def pull(self, wait_s):
        if not self.plan:
            return None
        what = self.plan.popleft()
        if isinstance(what, StreamLost):
            raise what
        return what

    def reopen(self):
        found = self.reopenings.popleft() if self.reopenings else ""
        if found is not None:
            raise StreamLost(found)

    def close(self):
        self.closed += 1


def pulled(stamp_ns, *values):
    return Pulled(np.array(values, dtype=np.float64), stamp_ns)


def present(origin_ns):
    return Present(origin_ns, Event())


def tick_at(time_ns, index=0):
    tick = Tick()
    tick.time_ns, tick.index = time_ns, index
    return tick
