"""What `electrodes` remembers: the field of its elements, and the pulses whose axons still count."""

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

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@compiled
def find_active(pulses: Array, active: Flags) -> tuple[int, float]:
    """Fill `active` (elements,) from pulses (elements, 3); first faulty element, -1 for none, and frequency.

    A pulse has current and width; one that is negative, not finite or without a frequency is faulty.
    """
    hertz = 0.0
    for e in range(pulses.shape[0]):
        active[e] = pulses[e, 0] != 0.0 and pulses[e, 1] != 0.0
        if active[e]:
            for k in range(3):
                if not 0.0 < pulses[e, k] < math.inf:
                    return e, 0.0
            hertz = max(hertz, pulses[e, 2])
    return -1, hertz


@compiled
def field_row(
    element: Array, axons: Array, turn: float, circumference_mm: float, reference_mm: float, row: Array
) -> None:
    """Fill `row` (axons,): effective mA at an axon, over its threshold, for 1 mA through an element.

    The field is ((d0^2 + a^2) / (d^2 + r^2 + a^2))^1.5 at depth d and distance r on the unrolled skin, with
    the pad's size a; it is 1 straight under a pad at the reference depth d0. `element` (3,): around the
    forearm, along it, size, mm; `axons` (axons, 5): around, along, depth, mm, threshold, mA, and mm by which
    it moves around for each rad of the forearm's `turn`.
    """
    pad = element[2] * element[2]
    unit = reference_mm * reference_mm + pad
    for i in range(axons.shape[0]):
        around = abs(axons[i, 0] + turn * axons[i, 4] - element[0]) % circumference_mm
        around = min(around, circumference_mm - around)
        along = axons[i, 1] - element[1]
        share = unit / (axons[i, 2] * axons[i, 2] + around * around + along * along + pad)
        row[i] = share * math.sqrt(share) / axons[i, 3]


@compiled
def fill_rows(
    active: Flags, known: Flags, places: Array, axons: Array, turn: float, circumference_mm: float,
    reference_mm: float, field: Array
) -> None:
    """Fill the rows of `field` (elements, axons) that active elements need and that are not known."""
    for e in range(places.shape[0]):
        if active[e] and not known[e]:
            field_row(places[e], axons, turn, circumference_mm, reference_mm, field[e])
            known[e] = True


@compiled
def fire(pulses: Array, skin: Array, active: Flags, field: Array, chronaxie_s: float, fired: Flags) -> None:
    """Fill `fired` (axons,) with the axons that simultaneous `pulses` (elements, 3) excite.

    An element's effective current is I / (1 + chronaxie / pulse width), times the `skin` gain (elements,).
    """
    drive = np.zeros(field.shape[1])
    for e in range(pulses.shape[0]):
        if active[e]:
            effective = 1e3 * skin[e] * pulses[e, 0] / (1.0 + chronaxie_s / pulses[e, 1])
            row = field[e]
            for i in range(drive.size):
                drive[i] += effective * row[i]
    for i in range(drive.size):
        fired[i] = drive[i] >= 1.0


@compiled
def recruit_muscles(
    fired: Flags, hertz: Array, muscles: NDArray[np.int64], recruitment: Array, frequency: Array
) -> None:
    """Fill `recruitment` and `frequency` of the `muscles` that have axons, from the groups that count now.

    `fired` (groups, axons), `hertz` (groups,), 0 for a group that does not count. A muscle is recruited by
    the share of its axons that any group fires; its frequency is the mean rate of those, where an axon that
    several groups fire has the sum of their rates.
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
    """Constants of a forearm with arrays on it; never written to.

    Attributes
    ----------
    axons: (axons, 5), muscle after muscle, in neutral rotation: around, along, depth, mm, threshold, mA, and
        mm by which it moves around for each rad of rotation.
    muscles: numbers of the muscles that have axons.
    circumference_mm: of the forearm.
    reference_mm: depth at which the field under a pad is 1.
    chronaxie_s: of the axons.
    """

    axons: Array
    muscles: NDArray[np.int64]
    circumference_mm: float
    reference_mm: float
    chronaxie_s: float


@dataclass(slots=True, eq=False)
class ElectrodesState:
    """The cached field, and what fired.

    Attributes
    ----------
    forearm: constants.
    period_ns: of the block's clock.
    places: (elements, 3), of the elements: around the forearm, along it, size, mm; never written to.
    slip: (2,), m, around and along, of the arrays from where they were put on; never written to.
    gains: (elements,), share of the current that passes the skin; never written to.
    fields: (elements, axons), of `field_row`; a row is made when its element is first active.
    known: (elements,), whose rows are made.
    active: (elements,), room for those of the newest pulse.
    fired: (groups, axons), what each remembered pulse excited.
    until_ns: (groups,), instant at which it ceases to count.
    hertz: (groups,), its stimulation frequency.
    rotation: steps of forearm rotation for which the field is.
    newest_ns, skin_ns, shift_ns: arrival of the newest message of pulses, of skin factors, and of a shift.
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
    slip: Array = field(default_factory=lambda: np.zeros(2))
    rotation: int = 0
    newest_ns: int = NEVER
    skin_ns: int = NEVER
    shift_ns: int = NEVER
    latch: StatusLatch = field(default_factory=StatusLatch)

    @classmethod
    def of(cls, forearm: Forearm, period_s: float, places: Array, gains: Array) -> ElectrodesState:
        """Nothing fired yet, no field known."""
        elements, axons = len(places), len(forearm.axons)
        return cls(
            forearm, period_s * NS_PER_S, places, gains, np.empty((elements, axons)),
            np.zeros(elements, np.bool_), np.zeros(elements, np.bool_), np.zeros((1, axons), np.bool_),
            [NEVER], [0.0])

    def excite(self, pulses: Array, hertz: float, turn: float, now_ns: int) -> None:
        """Let simultaneous pulses (elements, 3) of the active elements fire axons; `turn` in rad.

        They count until the next pulse of their train is due, less half a tick: the pulse that takes their
        place may come 1 ns early or late.
        """
        forearm = self.forearm
        fill_rows(self.active, self.known, self.places, forearm.axons, turn, forearm.circumference_mm,
                  forearm.reference_mm, self.fields)
        group = self._free_group(now_ns)
        fire(pulses, self.gains, self.active, self.fields, forearm.chronaxie_s, self.fired[group])
        self.until_ns[group] = now_ns + max(NS_PER_S / hertz, self.period_ns) - 0.5 * self.period_ns
        self.hertz[group] = hertz

    def _free_group(self, now_ns: int) -> int:
        """A group that no longer counts; a new one where all do."""
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
