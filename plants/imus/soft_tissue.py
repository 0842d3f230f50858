"""A sensor on skin: it wobbles on the tissue over the bone, a damped oscillator in each direction.

    th'' + 2 z w th' + w^2 th = -share alpha - compliance w^2 (e x f)

th is the small rotation of the sensor against the bone, alpha the bone's angular acceleration, f the
specific force, e the direction in which the sensor stands out. Its inertia leaves it behind (share), its
weight pulls it over (compliance, at rest the sag). Solved exactly from tick to tick, with f and the
angular velocity linear in between.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand.motion import STANDARD_GRAVITY
from plants.checks import require_not_negative, require_positive, require_shape

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class SoftTissue:
    """Elastic mount of every sensor.

    The sensor turns against its bone; that it also shifts a little is left out. The default numbers are
    medians of fits to five sensors on foam (recording chain5, first half of trial 1), where the model
    explains half of what foam adds to gyroscopes in the second half; that skin is like foam is chosen.

    Attributes
    ----------
    natural_hz, damping: of the oscillation; damping ratio above 0 and below 1.
    share: of the bone's angular acceleration that tissue does not pass on at once: 1 for a sensor held by
        tissue alone, less for one that tape ties to the skin around, more for one whose weight lies off
        its middle.
    sag_deg: turned by 1 g of specific force along the skin, at rest, deg.
    outwards: direction out of the skin in the segments' frames, a unit vector (right hand: -x is dorsal;
        left hand: +x).
    """

    natural_hz: float = 11.0
    damping: float = 0.1
    share: float = 1.2
    sag_deg: float = 3.0
    outwards: tuple[float, float, float] = (-1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        require_positive("soft_tissue", self, "natural_hz")
        require_not_negative("soft_tissue", self, "share", "sag_deg")
        require_shape("soft_tissue", self, (3,), "x, y, z", "outwards")
        if not 0.0 < self.damping < 1.0:
            raise InputError("soft_tissue.damping", f"{self.damping}", "above 0 and below 1")
        if abs(math.hypot(*self.outwards) - 1.0) > 1e-6:
            raise InputError("soft_tissue.outwards", f"{self.outwards}", "a vector of length 1")

    def numbers(self) -> Array:
        """As the kernel takes it, (7,): natural frequency, rad/s, damping, share, rad per m/s^2, outwards."""
        return np.array([2.0 * math.pi * self.natural_hz, self.damping, self.share,
                         math.radians(self.sag_deg) / STANDARD_GRAVITY, *self.outwards])


@compiled(inline="always")
def _leaning(tissue: Array, force: Array, axis: int) -> float:
    """Rotation about an axis at which a held specific force (3,) is balanced, rad."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    turned: float = -tissue[3] * (tissue[4 + b] * force[c] - tissue[4 + c] * force[b])
    return turned


@compiled
def wobble(tissue: Array, rate: Array, force: Array, elapsed_s: float, motion: Array) -> None:
    """Bring `motion` (4, 3) on by `elapsed_s`: rotation, rad, its rate, bone's rate and force before.

    `rate` (3,), rad/s, and `force` (3,), m/s^2, are the bone's now. With 0 s elapsed the sensor is put at
    rest where the force balances it: the start of a trial.
    """
    w, z = tissue[0], tissue[1]
    for i in range(3):
        now = _leaning(tissue, force, i)
        if elapsed_s <= 0.0:
            motion[0, i], motion[1, i] = now, 0.0
            continue
        before = _leaning(tissue, motion[3], i)
        slope = (now - before) / elapsed_s
        inertial = -tissue[2] * (rate[i] - motion[2, i]) / (elapsed_s * w * w)
        # y_p = u - 2 z u' / w solves the equation for u linear in time; what is left rings down.
        offset = before + inertial - 2.0 * z * slope / w
        left, speed = motion[0, i] - offset, motion[1, i] - slope
        damped = w * math.sqrt(1.0 - z * z)
        decay = math.exp(-z * w * elapsed_s)
        cosine, sine = math.cos(damped * elapsed_s), math.sin(damped * elapsed_s) / damped
        motion[0, i] = offset + slope * elapsed_s + decay * (left * (cosine + z * w * sine) + speed * sine)
        motion[1, i] = slope + decay * (speed * (cosine - z * w * sine) - left * w * w * sine)
    motion[2] = rate
    motion[3] = force


@compiled
def turn_back(rotation: Array, vector: Array) -> None:
    """Coordinates (3,) in the bone's frame to those in a frame turned by a rotation vector (3,), in place."""
    x, y, z = rotation[0], rotation[1], rotation[2]
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    first = math.sin(angle) / angle if square > 1e-12 else 1.0 - square / 6.0
    # 1 - cos a without cancellation
    second = 2.0 * (math.sin(0.5 * angle) / angle) ** 2 if square > 1e-12 else 0.5 - square / 24.0
    a, b, c = vector[0], vector[1], vector[2]
    p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
    vector[0] = a - first * p + second * (y * r - z * q)
    vector[1] = b - first * q + second * (z * p - x * r)
    vector[2] = c - first * r + second * (x * q - y * p)


@compiled
def own_rate(rotation: Array, speed: Array, vector: Array) -> None:
    """Add to `vector` (3,), rad/s, what a rotation vector (3,) that changes at `speed` (3,) turns by.

    In the turned frame: the right Jacobian of the rotation times its rate.
    """
    x, y, z = rotation[0], rotation[1], rotation[2]
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    first = 2.0 * (math.sin(0.5 * angle) / angle) ** 2 if square > 1e-6 else 0.5 - square / 24.0
    second = (angle - math.sin(angle)) / (square * angle) if square > 1e-6 else 1.0 / 6.0 - square / 120.0
    a, b, c = speed[0], speed[1], speed[2]
    p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
    vector[0] += a - first * p + second * (y * r - z * q)
    vector[1] += b - first * q + second * (z * p - x * r)
    vector[2] += c - first * r + second * (x * q - y * p)
