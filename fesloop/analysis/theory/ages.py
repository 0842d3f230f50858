"""The age of what a reader holds behind a wire with jitter and loss: a Markov chain.

Under keep-newest, a reader that holds message m has not got any newer one: each of those is, independently
of all others, still under way or lost. Whether message j > m comes between two ticks of the reader then has
the probability (F(t2) - F(t1)) / (1 - F(t1)), where F is the probability that j has arrived by an instant.
So the number of the newest message that has arrived, counted back from the newest that was sent (the age in
messages), is a Markov chain. What is older than any message that can still come counts as one age, "old":
nothing is cut off, however long a run of losses is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.theory import wires
from fesloop.loop.clock import RateClock
from fesloop.loop.wiring import Connection

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """One tick of the reader.

    Attributes
    ----------
    time_ns, before_ns: this tick and the one before.
    sent, sent_before: how many messages had been sent when they read.
    """

    time_ns: int
    before_ns: int
    sent: int
    sent_before: int


def oldest_age(connection: Connection, looks: list[Look]) -> int:
    """How many of the newest messages can come between two looks: what is as old or older is "old"."""
    clock, most = wires.clock_of(connection), wires.most_ns(connection)
    return max(look.sent - clock.first_at_or_after(look.before_ns - most + 1) for look in looks)


def transition(connection: Connection, look: Look, oldest: int) -> Array:
    """Probabilities of age j at this look after age i at the one before, (oldest + 1, oldest + 1)."""
    hazards = [_hazard(connection, look, age) for age in range(oldest)]
    chances = np.zeros((oldest + 1, oldest + 1))
    for before in range(oldest + 1):
        aged = min(before + look.sent - look.sent_before, oldest)
        nothing_newer = 1.0
        for age in range(aged):
            chances[before, age] = nothing_newer * hazards[age]
            nothing_newer *= 1.0 - hazards[age]
        chances[before, aged] += nothing_newer
    return chances


def _hazard(connection: Connection, look: Look, age: int) -> float:
    """Probability that the message of that age comes at this look, not having come before."""
    clock: RateClock = wires.clock_of(connection)
    made_ns = clock.tick(look.sent - 1 - age)
    by_then = wires.arrived(connection, look.before_ns - made_ns)
    by_now = wires.arrived(connection, look.time_ns - made_ns)
    return (by_now - by_then) / (1.0 - by_then) if by_then < 1.0 else 0.0


def stationary(transitions: list[Array]) -> Array:
    """Probabilities of the ages before the first of a cycle of transitions, (ages,)."""
    cycle = np.linalg.multi_dot(transitions) if len(transitions) > 1 else transitions[0]
    ages = len(cycle)
    # pi (cycle - 1) = 0 and the sum is 1: as many equations as unknowns and one more, all consistent.
    equations = np.vstack([(cycle - np.eye(ages)).T, np.ones(ages)])
    wanted = np.zeros(ages + 1)
    wanted[-1] = 1.0
    found = np.linalg.lstsq(equations, wanted, rcond=None)[0]
    return np.asarray(np.maximum(found, 0.0) / np.maximum(found, 0.0).sum())
