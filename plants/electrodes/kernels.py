"""The field of electrode elements at axons, and which axons fire under it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

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
