"""Wires: their declaration (`Wire`), their losses, and a wire in operation (`Link`)."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, Literal

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, RateClock, duration_ns
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.signals import Sample, Value


class Losses:
    """Losses by a two-state Markov chain (Gilbert 1960, doi 10.1002/j.1538-7305.1960.tb03959.x).

    Every message in the bad state is lost, and none in the good one. The chain starts in its stationary
    distribution.

        P(lost | the one before was not) = begins = share (1 - stays) / (1 - share)
        P(lost | the one before was too) = stays = 1 - 1 / burst, or share where losses are independent

    With u(k) uniform, message k is lost if u(k) is below both probabilities and kept if it is above both.
    Otherwise it has the fate of message k - 1, or the opposite if stays < begins. `lost` therefore searches
    back to the last message that u alone decides: a fate is a function of seed, wire, trial and tick, and is
    no part of a snapshot.

    Parameters
    ----------
    share: of the messages, lost in the long run, in [0, 1).
    burst: mean number of messages lost in a row; 0: each is lost or not by itself.
    noise: row k begins with u(k).
    """

    __slots__ = ("_correlated", "_kept_from", "_known", "_lost_below", "_noise", "_share", "_was_lost")

    def __init__(self, share: float, burst: float, noise: NoiseStream) -> None:
        begins, stays = transition_probabilities(share, burst)
        self._lost_below, self._kept_from = min(begins, stays), max(begins, stays)
        self._correlated = stays >= begins
        self._share, self._noise = share, noise
        self._known, self._was_lost = -1, False

    def lost(self, index: int, chance: float) -> bool:
        """True if the message of tick `index` is lost; `chance` is its u."""
        decided, u = index, chance
        while decided and decided != self._known and self._lost_below <= u < self._kept_from:
            decided -= 1
            u = float(self._noise.row(decided)[0])
        limit = self._lost_below if decided else self._share
        lost = self._was_lost if decided == self._known else u < limit
        if not self._correlated and (index - decided) % 2:
            lost = not lost
        self._known, self._was_lost = index, lost
        return lost


def transition_probabilities(share: float, burst: float) -> tuple[float, float]:
    """Probabilities that a message is lost after one that was not, and after one that was."""
    if not burst:
        return share, share
    stays = 1.0 - 1.0 / burst
    return min(1.0, share * (1.0 - stays) / (1.0 - share)), stays


def least_burst(share: float) -> float:
    """Least mean number of messages lost in a row that a share of lost messages allows, but for round-off."""
    return max(1.0, (1.0 - 1e-9) * share / (1.0 - share))


Late = Literal["keep-newest", "in-order"]
Message = tuple[Value, int, int, int]
"""(value, oldest capture, newest capture, arrival), as in Sample."""


TRANSPORT = ("latency_ms", "jitter", "loss", "burst_messages", "late")
"""Fields of a wire that are equal on all wires of a link."""


@dataclass(frozen=True, slots=True)
class Wire:
    """A wire from an output port to an input port.

    Attributes
    ----------
    source, target: "node.port".
    latency_ms: transport time, taken by its decimal text, to the nearest ns.
    jitter: added to the latency, a new value for each message; the sum is never negative.
    loss: share of the messages that is lost in the long run, in [0, 1).
    late: treatment of a message that a newer one has overtaken. "keep-newest" drops and counts it;
        "in-order" lets no message overtake: each waits for its predecessor. What was sent later counts
        as newer, also where two messages carry the same capture.
    rate, offset_ms: when a plant's output is sampled into the wire, Hz and ms; by default at the reader's
        ticks. A wire from plant to plant must give its communication rate. A block's output is sent when
        the block steps, so there is no rate to give.
    burst_messages: mean number of messages lost in a row (`Losses`); 0: every message is lost or not by
        itself.
    link: name of the transport that several wires share, such as a radio; None for a wire of its own. What
        the sources of these wires send at one tick is one packet: it is lost or arrives as a whole, with
        one jitter. Wires of one link have equal transport, and sources on one clock (see `link_faults`).
    """

    source: str
    target: str
    latency_ms: float = 0.0
    jitter: Duration = ZERO
    loss: float = 0.0
    late: Late = "keep-newest"
    rate: str | int | float | None = None
    offset_ms: float = 0.0
    burst_messages: float = 0.0
    link: str | None = None

    def __post_init__(self) -> None:
        for end in (self.source, self.target):
            if not isinstance(end, str) or end.count(".") != 1 or not all(end.split(".")):
                raise InputError(f"wire {self.name}", f"{end!r} is not a port", '"node.port"')
        where = f"wire {self.name}"
        latency = duration_ns(self.latency_ms, NS_PER_MS, f"{where}: latency_ms")
        if self.jitter.kind in ("measured", "recorded"):
            raise InputError(f"{where}: jitter.kind", f"{self.jitter.kind!r}",
                             "zero, fixed, uniform, normal, exponential")
        if latency + self.jitter.least_ns < 0:
            raise InputError(f"{where}: jitter",
                             f"latency {self.latency_ms:g} ms plus jitter can be "
                             f"{(latency + self.jitter.least_ns) / NS_PER_MS:g} ms",
                             "a sum of at least 0", "raise latency_ms or jitter.low_ms")
        if isinstance(self.loss, bool) or not (math.isfinite(self.loss) and 0.0 <= self.loss < 1.0):
            raise InputError(f"{where}: loss", f"{self.loss!r}", "a probability in [0, 1)")
        self._require_burst(where)
        if self.late not in ("keep-newest", "in-order"):
            raise InputError(f"{where}: late", f"{self.late!r}", "keep-newest, in-order")
        duration_ns(self.offset_ms, NS_PER_MS, f"{where}: offset_ms")
        if self.rate is None and self.offset_ms:
            raise InputError(f"{where}: offset_ms", "given without a rate", "a rate beside it")
        if self.link == "":
            raise InputError(f"{where}: link", "is empty", "the name of a link", "leave it out")

    def _require_burst(self, where: str) -> None:
        burst, least = self.burst_messages, least_burst(self.loss)
        if isinstance(burst, bool) or not (math.isfinite(burst) and (burst == 0.0 or burst >= least)):
            raise InputError(f"{where}: burst_messages", f"{burst!r}",
                             f"{least:g} or more with this loss, or 0 for messages lost one by one")

    @property
    def name(self) -> str:
        """Name in errors, reports and recordings; unique, since an input has one wire."""
        return f"{self.source}->{self.target}"

    @property
    def latency_ns(self) -> int:
        """Transport time without jitter."""
        return duration_ns(self.latency_ms, NS_PER_MS, self.name)

    @property
    def least_ns(self) -> int:
        """The least transport time."""
        return self.latency_ns + self.jitter.least_ns

    @property
    def clock(self) -> RateClock | None:
        """Clock at which a plant's output is sampled into it; None for the reader's ticks."""
        if self.rate is None:
            return None
        offset = duration_ns(self.offset_ms, NS_PER_MS, self.name)
        return RateClock.from_rate(self.rate, offset, f"wire {self.name}: rate")

    def noise(self, seed: int, trial: int) -> NoiseStream:
        """Row k: the uniform numbers that decide loss and jitter of the source's tick k."""
        sender = f"wire/{self.name}" if self.link is None else f"link/{self.link}"
        return NoiseStream(stream_key(seed, sender, trial), 2, "uniform")

    @property
    def random(self) -> bool:
        """True if messages can be lost or differ in their transport time."""
        return bool(self.loss) or self.jitter.random

    def losses(self, noise: NoiseStream) -> Losses:
        """Losses by the numbers of `noise`."""
        return Losses(self.loss, self.burst_messages, noise)


class Link:
    """A wire in operation: messages on their way, in the order of delivery.

    Attributes
    ----------
    queue: messages under way, by arrival, then sequence: the fields of a Sample as a bare tuple, for most
        are overwritten before anyone reads them.
    plain: True if every message takes `latency_ns` and none is lost: the sender may then append to `queue` by
        itself, and counts what it sends.
    sent, lost, late: counts of messages sent (unless plain), lost on the way, dropped because a newer one
        was there.
    """

    __slots__ = ("_held", "_in_order", "_last_arrival", "_losses", "_noise", "_order", "_wire", "late",
                 "latency_ns", "lost", "plain", "queue", "sent", "wire_name")

    def __init__(self, wire: Wire, seed: int, trial: int) -> None:
        self.wire_name = wire.name
        self.queue: deque[Message] = deque()
        self.sent = self.lost = self.late = 0
        self._wire = wire
        self.latency_ns = wire.latency_ns if wire.random else wire.least_ns
        self._in_order = wire.late == "in-order"
        self._last_arrival = 0
        self._order: deque[int] = deque()
        self._held = -1
        self._noise = wire.noise(seed, trial)
        self._losses = wire.losses(self._noise)
        self.plain = not wire.random

    def send(self, index: int, value: Value, oldest: int, newest: int, left: int) -> None:
        """Send a message, with jitter and loss by the numbers of the source's tick `index`."""
        number = self.sent
        self.sent += 1
        chance, shape = self._noise.row(index)
        if self._losses.lost(index, float(chance)):
            self.lost += 1
            return
        arrival = left + self.latency_ns + self._wire.jitter.draw_ns(float(shape))
        if self._in_order:
            arrival = self._last_arrival = max(arrival, self._last_arrival)
        queue = self.queue
        at = len(queue)
        while at and queue[at - 1][3] > arrival:
            at -= 1
        queue.insert(at, (value, oldest, newest, arrival))
        self._order.insert(at, number)

    def take_due(self, time_ns: int, held: Sample) -> Sample:
        """Sample of the port at `time_ns`, after every message due by then has been delivered."""
        queue = self.queue
        while queue and queue[0][3] <= time_ns:
            held = self.take(held)
        return held

    def take(self, held: Sample) -> Sample:
        """Deliver the next message; return its sample, or `held` if that was sent later."""
        message = self.queue.popleft()
        if not self.plain:
            number = self._order.popleft()
            if number < self._held:
                self.late += 1
                return held
            self._held = number
        return Sample(*message)

    def save(self) -> tuple[Any, ...]:
        """Return everything that changes, for a snapshot."""
        return (list(self.queue), list(self._order), self._held, self.sent, self.lost, self.late,
                self._last_arrival)

    def restore(self, saved: tuple[Any, ...]) -> None:
        """Restore what `save` returned."""
        queue, order, self._held, self.sent, self.lost, self.late, self._last_arrival = saved
        self.queue.clear()
        self.queue.extend(queue)
        self._order.clear()
        self._order.extend(order)
