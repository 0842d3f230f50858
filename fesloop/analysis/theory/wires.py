"""What of a wire the theory needs: its least and greatest transport, and how likely a message has arrived."""

from __future__ import annotations

from collections.abc import Sequence

from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Connection
from fesloop.loop.wire import odds
from fesloop.models.linear_form import uncovered


def require_theory(connections: Sequence[Connection]) -> None:
    """Raise InputError for the first wire that the theory does not cover."""
    for connection in connections:
        wire, where = connection.wire, f"wire {connection.wire.name}"
        if connection.clock is not None and not isinstance(connection.clock, RateClock):
            raise uncovered(where, "is sampled at given stamps", "a rate")
        if varies(connection):
            if connection.target.is_plant:
                raise uncovered(f"{where}: jitter", "into a plant", "zero or fixed")
            if wire.late == "in-order":
                raise uncovered(f"{where}: late", "in-order under jitter", "keep-newest")
            if bursts(connection):
                raise uncovered(f"{where}: burst_messages", "bursts of losses under jitter", "one of the two")
    packets: dict[str, Connection] = {}
    for connection in connections:
        if connection.wire.link is not None and connection.wire.random:
            other = packets.setdefault(connection.wire.link, connection)
            if other is not connection:
                raise uncovered(f"wire {connection.wire.name}",
                                f"shares losses or jitter with {other.wire.name} (link "
                                f"{connection.wire.link!r})", "one random wire of a link in the loop")
    chained = [c for c in connections if varies(c) or bursts(c)]
    if len(chained) > 1:
        raise uncovered(f"wire {chained[1].wire.name}", f"jitter or bursts, as on {chained[0].wire.name}",
                        "one such wire")


def bursts(connection: Connection) -> bool:
    """Whether the fate of a message depends on that of the one before."""
    begins, stays = odds(connection.wire.loss, connection.wire.burst_messages)
    return begins != stays


def clock_of(connection: Connection) -> RateClock:
    """When messages are made: ticks of the source, or samples of a plant."""
    clock = connection.clock or connection.source.clock
    assert isinstance(clock, RateClock)
    return clock


def varies(connection: Connection) -> bool:
    """Whether the transport differs from message to message."""
    return connection.wire.jitter.random


def latency_ns(connection: Connection) -> int:
    """From the source's tick to arrival, without random jitter."""
    fixed = 0 if varies(connection) else connection.wire.jitter.least_ns
    return connection.wire.latency_ns + fixed + connection.source.execution.least_ns


def most_ns(connection: Connection) -> int:
    """The longest transport of a message that is not lost."""
    jitter = connection.wire.jitter
    return latency_ns(connection) + ((jitter.most_ns or 0) if varies(connection) else 0)


def arrived(connection: Connection, age_ns: int) -> float:
    """Probability that a message has arrived by an age."""
    wire, late_ns = connection.wire, age_ns - latency_ns(connection)
    kept = 1.0 - wire.loss
    return kept * (wire.jitter.share_within(late_ns) if varies(connection) else float(late_ns >= 0))
