"""A planar finger in closed form, and samples as a loop would hand them to a tracker."""

from __future__ import annotations

import numpy as np

from fesloop.hand import quaternion
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Sample

RATE = 100
LENGTHS = np.array([0.0, 0.045, 0.026, 0.017])
GRAVITY = 9.81


def swing(times, start, depth, still_s=0.6, hertz=0.8):
    """(angles, rates, accelerations), (n, joints): at `start` for `still_s`, then swinging by `depth` rad."""
    phase = 2 * np.pi * hertz * np.maximum(times - still_s, 0.0)[:, np.newaxis]
    w = 2 * np.pi * hertz
    moving = (times > still_s)[:, np.newaxis]
    return (start + 0.5 * depth * (1 - np.cos(phase)), 0.5 * depth * w * np.sin(phase) * moving,
            0.5 * depth * w * w * np.cos(phase) * moving)


def planar_finger(times, start, depth, base):
    """Gyr and acc (n, 4, 3) of hand, proximal, middle and distal sensors, and true joint angles (n, 3).

    Flexion is about z of every segment, bones run along -y, the hand stands still at `base` (segment to
    earth). Sensors sit in the middle of their segments.
    """
    angle, rate, acceleration = (np.cumsum(np.hstack([np.zeros((len(times), 1)), part]), axis=1)
                                 for part in swing(times, start, depth))
    gyr = np.zeros((len(times), 4, 3))
    gyr[:, :, 2] = rate
    up = quaternion.rotate(quaternion.conjugate(base), [0.0, 0.0, GRAVITY])
    along = np.zeros((len(times), 2))
    acc = np.empty((len(times), 4, 3))
    for i, length in enumerate(LENGTHS):
        # second derivative of length (sin a, -cos a)
        sine, cosine = np.sin(angle[:, i]), np.cos(angle[:, i])
        forward, inward = acceleration[:, i], rate[:, i] ** 2
        bone = length * np.stack([cosine * forward - sine * inward, sine * forward + cosine * inward], axis=1)
        in_hand = np.zeros((len(times), 3))
        in_hand[:, :2] = along + 0.5 * bone
        acc[:, i] = quaternion.rotate(quaternion.about_z(-angle[:, i]), in_hand + up)
        along = along + bone
    return gyr, acc, swing(times, start, depth)[0]


def sample(value, time_ns):
    """A sample captured and arrived now."""
    return Sample(value, time_ns, time_ns, time_ns)


def run_tracker(tracker, *kinds, rate=RATE, state=None, first=0, last=None):
    """Step a tracker over samples (n, ...) of each kind; (outputs by port, reports, state)."""
    clock = RateClock.from_rate(rate)
    state = tracker.init(Context("tracker", clock=clock)) if state is None else state
    tick = Tick()
    outputs = []
    for k in range(first, len(kinds[0]) if last is None else last):
        tick.index, tick.time_ns = k, clock.tick(k)
        outputs.append(tracker.step(state, [sample(kind[k], tick.time_ns) for kind in kinds], tick))
    return [np.array(port) for port in zip(*outputs, strict=True)], tick.reports, state
