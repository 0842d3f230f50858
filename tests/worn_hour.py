"""How long trackers hold on a hand that moves, rests, and lies still: fingertips and angles, by minutes.

Run as a script for the whole hour: `python tests/worn_hour.py [SEED]...`.
"""

from __future__ import annotations

import sys

import numpy as np
from tracker_parts import sample
from worn_parts import Worn, WornHand

from estimators.constrained import ConstrainedTracker
from estimators.salchow import SalchowM2
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock

RATE = 100
STILL = (1200.0, 1800.0)
"""Ten minutes without motion, s."""


def drifting_tracker(hand):
    """salchow_m2 (doi 10.3390/s19010208), told the true posture of the rest at the start."""
    posture = np.degrees(hand.script(np.zeros(1))[0][0, 6:])
    pose = dict(zip(hand.nominal.freedoms, posture.tolist(), strict=True))
    return SalchowM2(sensors=17, initial_angles_deg=pose)


class Stepped:
    """A tracker and its state, fed in chunks."""

    def __init__(self, tracker, rate):
        self.tracker, self.clock, self.tick, self.reports = tracker, RateClock.from_rate(rate), Tick(), []
        self.state = tracker.init(Context("tracker", clock=self.clock))

    def chunk(self, first, gyr, acc):
        """angles, angle_sd, fingertips, fingertip_sd, aligned, each (count, ...), from sample `first` on."""
        found = []
        for i in range(len(gyr)):
            now = self.clock.tick(first + i)
            self.tick.index, self.tick.time_ns = first + i, now
            self.tick.reports.clear()
            inputs = [sample(kind[i], now) for kind in (gyr, acc)]
            found.append(self.tracker.step(self.state, inputs, self.tick)[1:])
            self.reports += [(1e-9 * now, *report) for report in self.tick.reports]
        return [np.array(port) for port in zip(*found, strict=True)]


def followed(hand, minutes, drifting=True, **parameters):
    """One entry a minute of {"tips", "tip_inside", "angles", "inside", "sd", "drifting"}, and the reports.

    tips, drifting: rms error of each fingertip's place, (5,), m; angles: rms of each angle's error, (23,),
    rad; tip_inside, inside: share within +-1.96 sd of what is put out, (5,) and (23,); sd: mean of the sd of
    the angles, (23,). Reports: (seconds, status, detail).
    """
    ours = Stepped(ConstrainedTracker(sensors=17, **parameters), hand.rate)
    beside = Stepped(drifting_tracker(hand), hand.rate) if drifting else None
    rows, count = [], 60 * hand.rate
    for minute in range(minutes):
        first = minute * count
        gyr, acc, angles, tips = hand.chunk(first, count)
        others = beside.chunk(first, gyr, acc)[2] if beside else None
        rows.append(_compared(ours.chunk(first, gyr, acc), angles, tips, others))
    return rows, ours.reports


def _compared(found, angles, tips, others):
    values, sd, places, tip_sd, *_ = found
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
    print(f"seed {seed}: fingertips cm, F2-F5 constrained / salchow_m2, thumb")
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
          f" over the still minutes x{growth.min():.2f} to x{growth.max():.2f}, reports {raised}", flush=True)
    return rows


def main(seeds):
    """Each hand's hour, then all of them together."""
    hands = [told(seed) for seed in seeds]
    last = [row for rows in hands for row in rows[-10:]]
    first = [rows[0] for rows in hands]
    inside = [np.mean([row[key] for row in last]) for key in ("tip_inside", "inside")]
    bar = max(1.2 * rms(first, "drifting"), 0.015)
    print(f"{len(seeds)} hands, last ten minutes: {100 * rms(last, 'tips'):.2f} cm, bar {100 * bar:.2f},"
          f" thumb {100 * rms(last, 'tips', 0):.2f}; inside: tips {inside[0]:.3f}, angles {inside[1]:.3f}")


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [0])
