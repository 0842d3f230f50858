"""How long trackers hold on a hand that moves, rests, and lies still: fingertips and angles, by minutes.

Run as a script for the whole hour: `python tests/worn_hour.py [SEED]...`.
"""

from __future__ import annotations

import sys

import numpy as np
from tracker_parts import sample
from worn_parts import Worn, WornHand

from estimators.constrained import ConstrainedTracker
from estimators.vqf_bank import VqfBank
from fesloop.hand import quaternion
from fesloop.hand.kinematics import joint_angles, segment_poses
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock

RATE = 100
STILL = (1200.0, 1800.0)
"""Ten minutes without motion, s."""
ALIGNED_S = 3.0


class Drifting:
    """What salchow_m2 does at its best: VQF without magnetometer, headings exact at `ALIGNED_S`.

    Angles that joints do not have are zeroed; nothing corrects the headings after that.
    """

    def __init__(self, hand):
        self.hand, self.bank, self.offset = hand, VqfBank(17, 1.0 / hand.rate, False), None
        self.parents = np.maximum(hand.nominal.layout[:, 0], 0)

    def chunk(self, first, gyr, acc, true):
        """Fingertips, (count, 5, 3), from sample `first` on; `true` (count, 23), rad, about the real axes."""
        q = np.empty((len(gyr), 17, 4))
        for i in range(len(gyr)):
            self.bank.update(gyr[i], acc[i], None)
            q[i] = self.bank.orientation()
        aligned = int(ALIGNED_S * self.hand.rate) - first
        if aligned >= 0:
            reference = segment_poses(self.hand.tree, true[aligned]).orientation
            # What turns each segment's heading away from that of the forearm followed by the true posture.
            error = quaternion.multiply(
                q[aligned], quaternion.conjugate(quaternion.multiply(q[aligned, 0], reference)))
            self.offset = quaternion.about_z(-quaternion.twist_z(error))
        q = quaternion.multiply(self.offset, q)
        found = joint_angles(self.hand.nominal, quaternion.relative(q[:, self.parents], q))
        return segment_poses(self.hand.nominal, found).position[:, self.hand.tips]


def followed(hand, minutes, drifting=True, **parameters):
    """One entry a minute of {"tips", "tip_inside", "angles", "inside", "sd", "drifting"}, and the reports.

    tips, drifting: rms error of each fingertip's place, (5,), m; angles: rms of each angle's error, (23,),
    rad; tip_inside, inside: share within +-1.96 sd of what is put out, (5,) and (23,); sd: mean of the sd of
    the angles, (23,). Reports: (seconds, status, detail).
    """
    tracker = ConstrainedTracker(sensors=17, **parameters)
    clock = RateClock.from_rate(hand.rate)
    state, tick = tracker.init(Context("tracker", clock=clock)), Tick()
    beside = Drifting(hand) if drifting else None
    rows, reports, count = [], [], 60 * hand.rate
    for minute in range(minutes):
        gyr, acc, angles, tips = hand.chunk(minute * count, count)
        true = hand.script((minute * count + np.arange(count)) / hand.rate)[0][:, 6:]
        found = []
        for i in range(count):
            k = minute * count + i
            tick.index, tick.time_ns = k, clock.tick(k)
            tick.reports.clear()
            inputs = [sample(kind[i], tick.time_ns) for kind in (gyr, acc)]
            found.append(tracker.step(state, inputs, tick)[1:])
            reports += [(k / hand.rate, *report) for report in tick.reports]
        others = beside.chunk(minute * count, gyr, acc, true) if beside else None
        rows.append(_compared([np.array(port) for port in zip(*found, strict=True)], angles, tips, others))
    return rows, reports


def _compared(found, angles, tips, others):
    values, sd, places, tip_sd = found
    error = np.angle(np.exp(1j * (values - angles)))
    away = places - tips
    row = {"tips": np.sqrt(np.mean(np.sum(away ** 2, axis=2), axis=0)),
           "tip_inside": np.mean(np.abs(away) < 1.96 * tip_sd, axis=(0, 2)),
           "angles": np.sqrt(np.mean(error ** 2, axis=0)),
           "inside": np.mean(np.abs(error) < 1.96 * sd, axis=0),
           "sd": sd.mean(axis=0), "tip_sd": np.sqrt(np.mean(np.sum(tip_sd ** 2, axis=2), axis=0))}
    if others is not None:
        row["drifting"] = np.sqrt(np.mean(np.sum((others - tips) ** 2, axis=2), axis=0))
    return row


def rms(rows, key, fingers=slice(1, 5)):
    """Of several minutes and fingers (F2 to F5)."""
    return float(np.sqrt(np.mean([row[key][fingers] ** 2 for row in rows])))


def told(seed, minutes=60, still=STILL):
    """Follow a hand, print a row for each ten minutes and what must hold; give whether it holds."""
    rows, reports = followed(WornHand(seed, Worn(), long_rest=still), minutes)
    print(f"seed {seed}: fingertips cm, F2-F5 constrained / without constraints, thumb")
    for start in range(0, minutes, 10):
        part = rows[start:start + 10]
        cm = [100 * rms(part, key, fingers) for fingers in (slice(1, 5), 0) for key in ("tips", "drifting")]
        inside = [np.mean([row[key] for row in part]) for key in ("tip_inside", "inside")]
        print(f"  {start:2d}-{start + 10:2d} min: {cm[0]:.2f} / {cm[1]:.2f}, {cm[2]:.2f} / {cm[3]:.2f}; sd"
              f" {100 * rms(part, 'tip_sd'):.2f}; inside: tips {inside[0]:.3f}, angles {inside[1]:.3f}")
    last, first = rms(rows[-10:], "tips"), rms(rows[:1], "drifting")
    a, b = (int(t // 60) for t in still)
    growth = rows[b - 1]["sd"] / rows[a - 1]["sd"]
    raised = [each for each in reports if still[0] < each[0] < still[1]]
    print(f"  last ten minutes {100 * last:.2f} cm, bar {100 * max(1.2 * first, 0.015):.2f}; sd of angles"
          f" over the still minutes x{growth.min():.2f} to x{growth.max():.2f}, reports {raised}")
    return rows, reports


if __name__ == "__main__":
    for chosen in [int(word) for word in sys.argv[1:]] or [0]:
        told(chosen)
