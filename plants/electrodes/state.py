"""What `electrodes` remembers: the field of its elements, and the pulses whose axons still count."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.muscles import MUSCLES
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER
from plants.electrodes.kernels import fill_rows, fire, recruit_muscles

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


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
