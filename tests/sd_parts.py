"""Errors of trackers on random persons, beside the sds that the trackers give.

    python tests/sd_parts.py [PERSONS]

prints for each tracker and kind of joint the share of errors within two sds, and the medians over all samples
of sd and rms error.
"""

from __future__ import annotations

import functools
import sys
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from estimators.constrained import ConstrainedTracker
from estimators.kortier import KortierTracker
from estimators.salchow import SalchowB, SalchowM1, SalchowM2
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.imus import Imus
from plants.imus.disturbances import Dipole, MagneticField, SoftTissue
from plants.moving_hand import MovingHand
from plants.moving_hand.script import ArmSway, Phase
from plants.patients.files import load
from plants.patients.sections import CohortSpread, DaySpread

STANDARD = {"F1_cmc_abduction": -45.0}
POSE_S = 5.0
COHORT = CohortSpread(hand_mm=9.8, joint_mm=3.0, axis_deg=7.6, length=0.03, width_mm=4.5)
DAY = DaySpread(mounting_deg=7.6, sag_deg=1.0, pose_deg=5.0, ruler_mm=2.0)
"""Tilts and mounting of 5 to 10 deg, lengths of a few per cent: doi 10.3390/s19010208, section 5. The rest is
chosen."""
KINDS = ("angles", "wrist", "cmc", "mcp_flexion", "mcp_abduction", "ip", "tips")
REACH = ArmSway(turn_deg=(30.0, 10.0, 35.0), shift_m=(0.12, 0.08, 0.10), period_s=6.0)


class Errors(NamedTuple):
    """Errors and sds of a tracker with a person: angles (t, 23), deg, and fingertips (t, 5, 3), mm.

    The random sd is that of what is not constant in the trial.
    """

    angles: np.ndarray
    angle_sd: np.ndarray
    random_sd: np.ndarray
    tips: np.ndarray
    tip_sd: np.ndarray


def trackers(size):
    """Trackers of a hand with sensors on all segments, by name, with the parameters they come with."""
    posed = {"hand": size, "initial_angles_deg": STANDARD, "initial_pose_s": 4.0}
    return {
        "salchow_b": SalchowB(hand=size), "salchow_m1": SalchowM1(**posed), "salchow_m2": SalchowM2(**posed),
        "constrained": ConstrainedTracker(**posed), "constrained_alone": ConstrainedTracker(hand=size),
        "kortier": KortierTracker(hand=size, initial_angles_deg=STANDARD),
        "kortier_no_mag": KortierTracker(hand=size, initial_angles_deg=STANDARD, magnetometers=False)}


def person(number):
    """One person on one day."""
    kind = replace(load("able_bodied"), cohort=COHORT, day=DAY)
    return replace(kind.member(cohort=1, number=number), day=DAY).on_day(number)


def room(number):
    """Earth's field with a dipole of .1 to 3 A m^2, 20 to 50 cm from the hand (log-uniform, chosen)."""
    rng = np.random.default_rng(number)
    away, moment = rng.standard_normal((2, 3))
    place = 0.2 * 2.5 ** rng.uniform() * away / np.linalg.norm(away)
    strength = 0.1 * 30.0 ** rng.uniform() * moment / np.linalg.norm(moment)
    return MagneticField(dipoles=(Dipole(position=tuple(place), moment=tuple(strength)),))


def movement():
    """The standard pose as it is held, a fist, a pinch, single fingers spread and bent, a rest; 32 s."""
    def fist(mcp, pip, dip):
        return {f"F{i}_{name}_flexion": angle for i in (2, 3, 4, 5)
                for name, angle in (("mcp", mcp), ("pip", pip), ("dip", dip))}

    opposed = {"F1_cmc_flexion": 30.0, "F1_cmc_abduction": -30.0, "F1_cmc_pronation": 70.0,
               "F1_mcp_flexion": 20.0, "F1_ip_flexion": 20.0}
    pinch = {**opposed, "F2_mcp_flexion": 50.0, "F2_pip_flexion": 40.0, "F2_dip_flexion": 20.0}
    spread = {"F2_mcp_abduction": -12.0, "F4_mcp_abduction": 8.0, "F5_mcp_abduction": 14.0}
    return (
        Phase(name="pose", duration_s=POSE_S),
        Phase(duration_s=2.5, cycles=3, vary=0.1, posture_deg={**fist(55.0, 70.0, 40.0), **opposed},
              arm=REACH),
        Phase(duration_s=2.5, cycles=2, vary=0.1, posture_deg=spread, arm=REACH),
        Phase(duration_s=2.5, cycles=2, vary=0.1, posture_deg={**pinch, "wrist_flexion": -25.0}, arm=REACH),
        Phase(duration_s=1.5, posture_deg=fist(25.0, 30.0, 15.0)), Phase(duration_s=5.0),
        Phase(duration_s=1.5, cycles=1, posture_deg=fist(60.0, 60.0, 30.0)))


@functools.cache
def errors(number):
    """Errors of all trackers with a person, ten a second, from a second after the pose."""
    who, tree = person(number), hand_tree(person(number).hand_size)
    limits = dict(zip(tree.freedoms, np.degrees(tree.ranges).tolist(), strict=True))
    rest = {name: float(np.clip(STANDARD.get(name, 0.0) + error, *limits[name]))
            for name, error in who.calibration.pose_error_deg.items()}
    hand = MovingHand(hand=who.hand_size, rest_deg=rest, phases=movement())
    worn = who.parameters("imus", {})
    imus = Imus(preset="salchow2019", sites=tree.names, mag_sites=tree.names,
                mounting_deg={name: tuple(turn) for name, turn in worn["mounting_deg"].items()},
                soft_tissue=SoftTissue(**worn["soft_tissue"]), magnetic_field=room(number))
    named = trackers(who.measured_hand)
    nodes = [Node("hand", hand), Node("imus", imus, rate="100"),
             *(Node(name, tracker, rate="100") for name, tracker in named.items())]
    ports = ("site_orientation", "site_position", "site_rate", "site_force")
    wires = [Wire(f"hand.{port}", f"imus.{port}") for port in ports]
    for name, tracker in named.items():
        resolved = tracker.resolve({"gyr": (17, 3)})
        wires += [Wire(f"imus.{port.name}", f"{name}.{port.name}") for port in resolved.inputs]
    recorder = Recorder()
    Loop(Wiring(nodes, wires, seed=number), recorder=recorder).run_until(round(hand.length_s * 1e9))
    found = {}
    state = hand.init(Context("hand", seed=number))
    for name in named:
        rows = [row for row in recorder.blocks[name] if row[4] > (POSE_S + 1.0) * 1e9][::10]
        truth = hand.observe(state, (), 0, tuple(int(row[4]) for row in rows))
        names = [port.name for port in named[name].resolve({"gyr": (17, 3)}).outputs]
        angles, sd, random_sd, tips, tip_sd = (
            np.array([row[5][names.index(port)] for row in rows])
            for port in ("angles", "angle_sd", "angle_random_sd", "fingertips", "fingertip_sd"))
        found[name] = Errors(np.degrees(angles - truth[0]), np.degrees(sd), np.degrees(random_sd),
                             1e3 * (tips - truth[3]), 1e3 * tip_sd)
    return found


def random_errors(tracker, persons):
    """Share of angles' errors, less their means in a trial, within two random sds; median sd; rms, deg."""
    error = np.concatenate([(each := errors(number)[tracker].angles) - each.mean(axis=0)
                            for number in persons])
    sd = np.concatenate([errors(number)[tracker].random_sd for number in persons])
    return float((np.abs(error) <= 2.0 * sd).mean()), float(np.median(sd)), float(np.sqrt(np.mean(error**2)))


def by_kind(tracker, persons):
    """{kind of joint: (share within two sds, median sd, rms error)} of a tracker over persons."""
    freedoms = hand_tree(person(1).hand_size).freedoms
    kinds = np.array([_kind(name) for name in freedoms])
    found = {}
    for kind in KINDS:
        pairs, chosen = [], (kinds == kind) | (kind == "angles")
        for number in persons:
            each = errors(number)[tracker]
            pairs.append((each.tips.ravel(), each.tip_sd.ravel()) if kind == "tips" else
                         (each.angles[:, chosen].ravel(), each.angle_sd[:, chosen].ravel()))
        error, sd = (np.concatenate(part) for part in zip(*pairs, strict=True))
        found[kind] = (float((np.abs(error) <= 2.0 * sd).mean()), float(np.median(sd)),
                       float(np.sqrt(np.mean(error ** 2))))
    return found


def _kind(freedom):
    if freedom.startswith("wrist"):
        return "wrist"
    if "_cmc_" in freedom:
        return "cmc"
    if "mcp_abduction" in freedom:
        return "mcp_abduction"
    return "mcp_flexion" if "_mcp_" in freedom else "ip"


def print_study(persons):
    """Print a line for each tracker."""
    for name in trackers(person(1).measured_hand):
        row = (f"{kind} {100 * share:.0f} % {sd:.1f}/{rms:.1f}"
               for kind, (share, sd, rms) in by_kind(name, persons).items())
        print(f"{name:18s}", "  ".join(row), flush=True)


if __name__ == "__main__":
    print_study(range(1, int(sys.argv[1] if len(sys.argv) > 1 else 10) + 1))
