"""`kortier`: the error-state filters of Kortier et al. 2014, one for each finger and one for the hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimators.kortier_chain import UNSEEN_SD, ChainFilter, Gates, new_chain, track_chain
from estimators.kortier_navigation import HandFilter, HandGates, new_hand, track_hand
from estimators.kortier_samples import Arrivals, Moment, Trust, no_moment, take
from estimators.kortier_tree import FORBIDDEN, HAND, Chain, require_tree
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock, StampClock
from fesloop.loop.signals import Port, Sample, Value

_UNKNOWN = 9.81
"""Sd of an acceleration whose sample is missing, m/s^2 (chosen: a hand in motion, upright or not)."""

@dataclass(slots=True, eq=False)
class KortierState:
    """Memory of a KortierTracker.

    Attributes
    ----------
    hand, chains: the filters.
    moment, arrivals: the samples.
    settings: of the filters, as the kernels read them.
    angles: how many are put out.
    unseen: joints, as "parent-child", that have been reported as not seen.
    """

    hand: HandFilter
    chains: tuple[ChainFilter, ...]
    moment: Moment
    arrivals: Arrivals
    settings: tuple[Trust, Gates, HandGates]
    angles: int
    unseen: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KortierTracker:
    """Joint angles, attitude and position of the hand by Kortier et al. 2014 (doi 10.1186/1743-0003-11-70).

    Each chain has an error-state filter (`estimators.kortier_finger`) of the relative rotations of its
    segments and of all gyroscope biases; neighbours' accelerometers, the magnetometers of base and tip and
    what joints cannot do correct it. The base of the first chain, the hand, has a filter of attitude,
    velocity and position (`estimators.kortier_hand`), which drifts within seconds unless the hand stands
    still now and then.

    Inputs `gyr` (n, 3) rad/s, `acc` (n, 3) m/s^2 and `mag` (n, 3) T, sensor frames equal to segment frames
    (z: flexion, x: abduction). They may have rates of their own: give the tracker that of the gyroscopes.
    Magnetometers other than those of bases and tips are not read; `mag` may be left without a wire
    (`sensors` is to be given then), and headings rest on the gyroscopes and the joints.

    Outputs `orientation` (n, 4), segment to earth (z up; with magnetometers y to magnetic north, else the
    heading is zero at the start); `angles` (a,), rad, chain by chain and joint by joint: flexion (hinge),
    abduction too (saddle), pronation too (ball), z-x-y Euler; `angle_sd` (a,), rad; `position` (3,), m, and
    `velocity` (3,), m/s, of the hand since the start.

    A lost rate is taken as the last one, a clipped one as read, with an uncertainty that says so. A joint is
    reported as "unseen" once a gyroscope of it has given nothing for `gap_ms` (so is a strip that was left
    off): its angle stands still and its sd is pi, until "seen".

    Attributes
    ----------
    sensors: n; 0 takes it from what is wired to `gyr`.
    chains: every sensor but the first base is in one chain beyond its base; empty: those of a hand, `HAND`.
    gyr_sd, acc_sd: of a sample, rad/s, m/s^2 (K14, Table 1).
    mag_sd_ut: of a sample with what the field differs within a hand, uT (chosen: Table 1 prints 1e-4).
    bias_walk: of the gyroscopes, rad/s after a second (K14, Table 1, taken as a density).
    bias_sd_deg_s, angle_sd_deg: at the start, of biases and of joints and the hand's attitude (chosen).
    constraint_sd_deg: of a joint's forbidden angles (Table 1 has 1e-5, which no joint holds; S19, doi
        10.3390/s19010208, names 5 to 10 for the neglected axes of joints).
    error_time_s: how long the errors of constraint_sd_deg, lever_m and motion_sd last: so often are they
        measured again (chosen); 0: errors are white.
    acc_difference, mag_difference_ut, rate_limit: gates (eq. 27, 28) in m/s^2, uT, rad/s; the paper leaves
        them to the user (chosen).
    lever_m: at which rotation adds to the accelerometers' variance (chosen: half a phalanx and a joint).
    motion_sd: of the hand's acceleration where its vertical is read, m/s^2 (chosen).
    still_window: samples of the zero-velocity detector; still_rate, still_acc: rms of rate and acceleration
        below which the hand stands, rad/s, m/s^2; still_sd: of its velocity then, m/s (chosen).
    lost_rate_deg_s, clipped_rate_deg_s: sd of a rate without sample, and of a clipped one (chosen).
    gap_ms: how long a gyroscope may be silent (chosen: ten samples of 100 Hz).
    gyr_range_deg_s, acc_range_g: from which magnitude on samples count as clipped, as of VqfTracker.
    """

    sensors: int = 0
    chains: tuple[Chain, ...] = ()
    gyr_sd: float = 5e-4
    acc_sd: float = 4e-2
    mag_sd_ut: float = 1.0
    bias_walk: float = 1e-4
    bias_sd_deg_s: float = 0.6
    angle_sd_deg: float = 10.0
    constraint_sd_deg: float = 5.0
    error_time_s: float = 0.2
    acc_difference: float = 0.5
    mag_difference_ut: float = 5.0
    rate_limit: float = 3.0
    lever_m: float = 0.03
    motion_sd: float = 0.3
    still_window: int = 25
    still_rate: float = 0.1
    still_acc: float = 0.2
    still_sd: float = 0.01
    lost_rate_deg_s: float = 120.0
    clipped_rate_deg_s: float = 500.0
    gap_ms: float = 100.0
    gyr_range_deg_s: float = 2000.0
    acc_range_g: float = 16.0

    def __post_init__(self) -> None:
        if self.sensors < 0:
            raise InputError("sensors", f"{self.sensors}", "1 or more, or 0 to take it from the wire")
        if not 2 <= self.still_window <= 1000:
            raise InputError("still_window", f"{self.still_window}", "2 to 1000 samples")
        for name in ("gyr_sd", "acc_sd", "mag_sd_ut", "bias_walk", "bias_sd_deg_s", "angle_sd_deg",
                     "constraint_sd_deg", "acc_difference", "mag_difference_ut", "rate_limit", "still_rate",
                     "still_acc", "still_sd", "lost_rate_deg_s", "clipped_rate_deg_s", "gap_ms",
                     "gyr_range_deg_s", "acc_range_g"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(name, f"{value} is not positive", "a finite number above 0")
        for name in ("error_time_s", "lever_m", "motion_sd"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(name, f"{value}", "a finite number, zero or more")
        if self.sensors:
            require_tree(self.chains or HAND, self.sensors)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """gyr, acc and mag."""
        shape = (self.sensors or None, 3)
        return (Port("gyr", shape, "rad/s"), Port("acc", shape, "m/s^2"),
                Port("mag", shape, "T", optional=True))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """orientation, angles, angle_sd, position and velocity."""
        shape = (self._angles() if self.sensors else None,)
        return (Port("orientation", (self.sensors or None, 4), "1"), Port("angles", shape, "rad"),
                Port("angle_sd", shape, "rad", UNSEEN_SD), Port("position", (3,), "m"),
                Port("velocity", (3,), "m/s"))

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> KortierTracker:
        """The same tracker for the number of sensors wired to it."""
        return replace(self, sensors=shapes["gyr"][0])

    def init(self, context: Context) -> KortierState:
        """Filters at their initial pose, the hand's attitude unknown."""
        if not isinstance(context.clock, (RateClock, StampClock)):
            raise InputError(f"{context.name}.rate", "is missing", "the rate of the gyroscopes")
        chains = self.chains or HAND
        angle_sd, bias_sd = math.radians(self.angle_sd_deg), math.radians(self.bias_sd_deg_s)
        magnetometers = np.zeros(self.sensors, dtype=np.bool_)
        filters = []
        for chain in chains:
            magnetometers[[chain.sensors[0], chain.sensors[-1]]] = True
            start = quaternion.about_z(np.radians(chain.initial_angles_deg or (0.0,) * len(chain.joints)))
            kinds = tuple(FORBIDDEN[kind] for kind in chain.joints)
            filters.append(new_chain(chain.sensors, kinds, start, angle_sd, bias_sd))
        return KortierState(new_hand(self.still_window), tuple(filters), no_moment(self.sensors),
                            Arrivals(context.clock.period_s, magnetometers), self._settings(), self._angles())

    def step(self, state: KortierState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """What is new at this tick."""
        limits = (math.radians(self.gyr_range_deg_s), 9.81 * self.acc_range_g, math.inf)
        arrivals, moment, hand = state.arrivals, state.moment, state.hand
        trust, gates, own = state.settings
        arrivals.note(inputs, limits, moment.codes, tick)
        elapsed = np.array(arrivals.elapsed_s)
        take(inputs[0].value, inputs[1].value, inputs[2].value, elapsed, arrivals.period_s, trust, moment)
        root = (self.chains or HAND)[0].sensors[0]
        track_hand(hand, root, moment, elapsed, gates, own)
        orientation = np.empty((self.sensors, 4))
        orientation[root] = hand.q
        angles, first = np.empty((2, state.angles)), 0
        for chain in state.chains:
            first = track_chain(chain, moment, elapsed, gates, orientation, first, angles[0], angles[1])
        if state.unseen or moment.missing.max() > gates.gap_s:
            _report_unseen(state, tick)
        return orientation, angles[0], angles[1], hand.motion[1].copy(), hand.motion[0].copy()

    def _angles(self) -> int:
        return sum(3 - FORBIDDEN[kind] for chain in self.chains or HAND for kind in chain.joints)

    def _settings(self) -> tuple[Trust, Gates, HandGates]:
        radians = math.radians
        trust = Trust(self.gyr_sd, self.acc_sd, 1e-6 * self.mag_sd_ut, radians(self.lost_rate_deg_s),
                      radians(self.clipped_rate_deg_s), self.lever_m, self.error_time_s)
        gates = Gates(self.acc_difference, 1e-6 * self.mag_difference_ut, self.rate_limit,
                      radians(self.constraint_sd_deg), self.error_time_s, self.bias_walk,
                      1e-3 * self.gap_ms)
        own = HandGates(self.motion_sd, self.still_rate, self.still_acc, self.still_sd, _UNKNOWN,
                        radians(self.angle_sd_deg), radians(self.bias_sd_deg_s))
        return trust, gates, own


def _report_unseen(state: KortierState, tick: Tick) -> None:
    unseen = tuple(f"{chain.sensors[k]}-{chain.sensors[k + 1]}" for chain in state.chains
                   for k in np.flatnonzero(~chain.seen))
    for status, now, before in (("unseen", unseen, state.unseen), ("seen", state.unseen, unseen)):
        changed = [joint for joint in now if joint not in before]
        if changed:
            tick.report(status, "joint " + ", ".join(changed))
    state.unseen = unseen
