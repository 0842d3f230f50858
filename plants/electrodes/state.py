"""State of `electrodes`: the field of the elements, and the recent pulses with the axons that they fired."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand.movements import MUSCLES
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER
from plants.electrodes.arrays import ALONG, AROUND, DEPTH, SIZE, THRESHOLD, TURN

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
CURRENT, WIDTH, FREQUENCY = range(3)
"""Columns of pulses: current, A, pulse width, s, and stimulation frequency, Hz."""


@compiled
def find_active(pulses: Array, active: Flags) -> tuple[int, float]:
    """Fill `active` (elements,) from pulses (elements, 3); first faulty element, -1 for none, and frequency.

    An active element has current and width; a pulse is faulty if it is negative, not finite or without a
    frequency.
    """
    hertz = 0.0
    for e in range(pulses.shape[0]):
        active[e] = pulses[e, CURRENT] != 0.0 and pulses[e, WIDTH] != 0.0
        if active[e]:
            for k in range(3):
                if not 0.0 < pulses[e, k] < math.inf:
                    return e, 0.0
            hertz = max(hertz, pulses[e, FREQUENCY])
    return -1, hertz


@compiled
def field_row(
    element: Array, axons: Array, turn: float, circumference_mm: float, reference_mm: float, row: Array
) -> None:
    """Fill `row` (axons,): effective current at each axon, relative to its threshold, for 1 mA of an element.

    The field is ((d0^2 + a^2) / (d^2 + r^2 + a^2))^1.5 at depth d and distance r on the unrolled skin, with
    the pad's size a; it is 1 directly under a pad at the reference depth d0. `element` (3,), `axons`
    (axons, 5): see `plants.electrodes.arrays`; `turn`: forearm rotation, rad.
    """
    pad = element[SIZE] * element[SIZE]
    unit = reference_mm * reference_mm + pad
    for i in range(axons.shape[0]):
        around = abs(axons[i, AROUND] + turn * axons[i, TURN] - element[AROUND]) % circumference_mm
        around = min(around, circumference_mm - around)
        along = axons[i, ALONG] - element[ALONG]
        share = unit / (axons[i, DEPTH] * axons[i, DEPTH] + around * around + along * along + pad)
        row[i] = share * math.sqrt(share) / axons[i, THRESHOLD]


@compiled
def fill_rows(
    active: Flags, known: Flags, places: Array, axons: Array, turn: float, circumference_mm: float,
    reference_mm: float, field: Array
) -> None:
    """Fill the unknown rows of `field` (elements, axons) of active elements."""
    for e in range(places.shape[0]):
        if active[e] and not known[e]:
            field_row(places[e], axons, turn, circumference_mm, reference_mm, field[e])
            known[e] = True


@compiled
def fire(pulses: Array, skin: Array, active: Flags, field: Array, chronaxie_s: float, fired: Flags) -> None:
    """Fill `fired` (axons,): whether simultaneous `pulses` (elements, 3) excite each axon.

    An element's effective current is I / (1 + chronaxie / pulse width), times the `skin` gain (elements,).
    """
    drive = np.zeros(field.shape[1])
    for e in range(pulses.shape[0]):
        if active[e]:
            effective = 1e3 * skin[e] * pulses[e, CURRENT] / (1.0 + chronaxie_s / pulses[e, WIDTH])
            row = field[e]
            for i in range(drive.size):
                drive[i] += effective * row[i]
    for i in range(drive.size):
        fired[i] = drive[i] >= 1.0


@compiled
def recruit_muscles(
    fired: Flags, hertz: Array, muscles: NDArray[np.int64], recruitment: Array, frequency: Array
) -> None:
    """Fill `recruitment` and `frequency` of the `muscles` that have axons, from the groups that count.

    `fired` (groups, axons), `hertz` (groups,), 0 for a group that no longer counts. Recruitment is the
    fraction of a muscle's axons that any group fires; frequency is their mean rate, where an axon fired by
    several groups has the sum of their rates.
    """
    rate = np.zeros(fired.shape[1])
    for g in range(hertz.size):
        if hertz[g] > 0.0:
            row, share = fired[g], hertz[g]
            for i in range(rate.size):
                rate[i] += share * row[i]
    count = rate.size // muscles.size
    for m in range(muscles.size):
        recruited, total = 0, 0.0
        for i in range(m * count, (m + 1) * count):
            recruited += rate[i] > 0.0
            total += rate[i]
        if recruited > 0:
            recruitment[muscles[m]] = recruited / count
            frequency[muscles[m]] = total / recruited


class Forearm(NamedTuple):
    """Constants of a forearm; never written to.

    Attributes
    ----------
    axons: (axons, 5), in the order of muscles, in neutral rotation; columns as in `plants.electrodes.arrays`.
    muscles: numbers of the muscles that have axons.
    circumference_mm: circumference of the forearm.
    reference_mm: depth at which the field under a pad is 1.
    chronaxie_s: chronaxie of the axons.
    """

    axons: Array
    muscles: NDArray[np.int64]
    circumference_mm: float
    reference_mm: float
    chronaxie_s: float


@dataclass(slots=True, eq=False)
class ElectrodesState:
    """State of the electrodes: cached field and recent pulses.

    Attributes
    ----------
    forearm: constants of the forearm.
    period_ns: period of the block's clock.
    places: (elements, 3), around the forearm, along it, size, mm; never written to.
    shift: (2,), m, displacement of the arrays around and along; never written to.
    gains: (elements,), fraction of the current that passes the skin; never written to.
    fields: (elements, axons), rows of `field_row`, computed when an element is first active.
    known: (elements,), whether each row is computed.
    active: (elements,), buffer for the active elements of the newest pulses.
    fired: (groups, axons), axons that each group of simultaneous pulses fired.
    until_ns: (groups,), instant until which each group counts.
    hertz: (groups,), stimulation frequency of each group.
    rotation: steps of forearm rotation to which the field applies.
    newest_ns, skin_ns, shift_ns: arrival of the newest pulses, skin factors, and shift.
    """

    forearm: Forearm
    period_ns: float
    places: Array
    gains: Array
    fields: Array
    known: Flags
    active: Flags
    fired: Flags
    until_ns: list[float]
    hertz: list[float]
    shift: Array = field(default_factory=lambda: np.zeros(2))
    rotation: int = 0
    newest_ns: int = NEVER
    skin_ns: int = NEVER
    shift_ns: int = NEVER
    latch: StatusLatch = field(default_factory=StatusLatch)

    @classmethod
    def of(cls, forearm: Forearm, period_s: float, places: Array, gains: Array) -> ElectrodesState:
        """State before the first pulse."""
        elements, axons = len(places), len(forearm.axons)
        return cls(
            forearm, period_s * NS_PER_S, places, gains, np.empty((elements, axons)),
            np.zeros(elements, np.bool_), np.zeros(elements, np.bool_), np.zeros((1, axons), np.bool_),
            [NEVER], [0.0])

    def excite(self, pulses: Array, hertz: float, turn: float, now_ns: int) -> None:
        """Fire axons by simultaneous pulses (elements, 3) of the active elements; `turn` in rad.

        They count until the next pulse of their train is due, less half a tick, as that pulse may come 1 ns
        early or late.
        """
        forearm = self.forearm
        fill_rows(self.active, self.known, self.places, forearm.axons, turn, forearm.circumference_mm,
                  forearm.reference_mm, self.fields)
        group = self._free_group(now_ns)
        fire(pulses, self.gains, self.active, self.fields, forearm.chronaxie_s, self.fired[group])
        self.until_ns[group] = now_ns + max(NS_PER_S / hertz, self.period_ns) - 0.5 * self.period_ns
        self.hertz[group] = hertz

    def _free_group(self, now_ns: int) -> int:
        """Index of a group that no longer counts, or of a new one."""
        for group, until_ns in enumerate(self.until_ns):
            if until_ns <= now_ns:
                return group
        self.fired = np.concatenate((self.fired, np.zeros_like(self.fired[:1])))
        self.until_ns.append(NEVER)
        self.hertz.append(0.0)
        return len(self.hertz) - 1

    def recruited(self, now_ns: int) -> tuple[Array, Array]:
        """Recruitment and frequency, Hz, of all muscles, (muscles,) each."""
        hertz = np.array([hertz if until > now_ns else 0.0
                          for hertz, until in zip(self.hertz, self.until_ns, strict=True)])
        recruitment, frequency = np.zeros(len(MUSCLES)), np.zeros(len(MUSCLES))
        recruit_muscles(self.fired, hertz, self.forearm.muscles, recruitment, frequency)
        return recruitment, frequency
