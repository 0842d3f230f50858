"""One tick of a Kortier tracker in one kernel: samples, hand, chains, posture."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.body.body import Body
from estimators.kortier.chain import Filters, Gates, track_chains
from estimators.kortier.navigation import HandFilter, HandGates, track_hands
from estimators.kortier.posture import put_angles, put_fingertips, put_orientations
from estimators.kortier.samples import Moment, Trust, take
from estimators.kortier.tree import Chains, chains_of
from fesloop.compiled import compiled
from fesloop.loop.block import Tick

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


class Worn(NamedTuple):
    """Who wears the sensors, as kernels read it; read-only.

    Attributes
    ----------
    layout, geometry: of the tree. sensors, tips: as of Body.
    magnetometers: (n,), those that are read: of each chain's base and tip, and of what is held.
    held_sensors: (parts,), of the segments that `chains` holds.
    base: the part whose position and velocity are put out.
    """

    layout: Numbers
    geometry: Array
    sensors: Numbers
    tips: Numbers
    magnetometers: NDArray[np.bool_]
    held_sensors: Numbers
    base: int
    chains: Chains


class Settings(NamedTuple):
    """What the filters suppose."""

    trust: Trust
    gates: Gates
    own: HandGates


class Posture(NamedTuple):
    """What is put out: orientation (n, 4); angles, fingertips and their sd: (2, freedoms), (2, t, 3)."""

    orientation: Array
    angles: Array
    fingertips: Array


def worn_by(body: Body, base: int) -> Worn:
    """The sensors of a body whose segment `base` is to be held."""
    chains = chains_of(body, base)
    number = np.arange(len(chains.first) - 1)
    read = np.zeros(len(body.sensed), dtype=np.bool_)
    for places in (chains.first[:-1] + number, chains.first[1:] + number):
        read[chains.sensors[places]] = True
    held = body.sensors[chains.held]
    read[held] = True
    for array in (read, held):
        array.flags.writeable = False
    return Worn(body.tree.layout, body.tree.geometry, body.sensors, body.tips, read, held,
                int(chains.part_of[base]), chains)


@compiled
def track(
    gyr: Any, acc: Any, mag: Any, codes: Any, elapsed: Any, period: float, worn: Worn, settings: Settings,
    hands: HandFilter, filters: Filters, moment: Moment, posture: Posture
) -> Any:
    """Whether there is news of which joints are seen; fills `posture`.

    Parameters
    ----------
    gyr, acc, mag: (n, 3), rad/s, m/s^2, T. codes, elapsed, period: as of `kortier.samples.take`.
    """
    trust, gates, own = settings
    take(gyr, acc, mag, codes, elapsed, period, trust, moment)
    track_hands(hands, worn.held_sensors, moment, elapsed, gates, own)
    joints = track_chains(worn.chains, filters, moment, elapsed, gates)
    relative = np.empty((worn.layout.shape[0], 4))
    put_orientations(worn.layout, worn.sensors, worn.chains, filters, hands.q, relative, posture.orientation)
    put_angles(worn.chains, filters, posture.angles[0], posture.angles[1])
    put_fingertips(worn.layout, worn.geometry, worn.tips, worn.chains, filters, relative,
                   posture.fingertips[0], posture.fingertips[1])
    return joints


def report_unseen(
    before: tuple[str, ...], body: Body, chains: Chains, seen: NDArray[np.bool_], tick: Tick
) -> tuple[str, ...]:
    """Say which joints have been lost and which are seen again; give those that are not seen.

    Parameters
    ----------
    before: what was given the last time. seen: (joints,), of those of the chains.
    """
    joint_of, freedoms = chains.joint_of, body.tree.layout[:, 1]
    unseen = tuple(body.joints[k] for k in np.flatnonzero(freedoms)
                   if joint_of[k] < 0 or not seen[joint_of[k]])
    for status, now, other in (("unseen", unseen, before), ("seen", before, unseen)):
        changed = [joint for joint in now if joint not in other]
        if changed:
            tick.report(status, "joint " + ", ".join(changed))
    return unseen
