"""One specimen of every registered kind, and inputs to feed it, for the conformance tests.

Run as a script it prints what every block puts out, so that compiled and uncompiled kernels can be compared.
"""

from __future__ import annotations

import json
import shutil
import sys
from importlib.metadata import entry_points
from importlib.util import find_spec

import numpy as np

from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.signals import Sample

CURVES = {"threshold_ma": (12.0, 10.0, 10.0, 8.0), "spread": (0.35,) * 4}
NOT_WITHOUT_FILES = {"playback", "recorded", "replay",
                     "lsl_inlet", "lsl_outlet", "lsl_events", "stimulator_device",
                     *([] if shutil.which("gcc") or shutil.which("cc") else ["fmu"]),
                     *([] if find_spec("myo_sim") else ["myohand"])}
"""Kinds whose specimens need a file, a device, or a compiler or package that is missing; they have their own
tests."""


def specimens():
    """{kind: block} for every registered kind, open shapes resolved."""
    from fesloop.models.linear_model import Recruitment

    finger = load("finger")()
    curves = Recruitment(**CURVES)
    model = finger.linear_model()
    joints = {"kp": (1.0,) * 3, "ki": (5.0,) * 3, "kd": (0.02,) * 3,
              "mixing": ((0.4, -0.5, 2.5), (-0.4, 1.8, -3.0), (-1.0, 0.2, -0.3), (1.5, -1.2, 0.4))}
    current = {"current_ma": (40.0,) * 4}
    felt = ("palm", "F1d", "F2d", "F3d")
    parameters = {
        "arm": {},
        "state_space": {"a": ((0.0, 1.0), (-30.0, -4.0)), "b": ((0.0,), (30.0,)), "c": ((1.0, 0.0),)},
        "finger": {}, "finger_imus": {}, "moving_hand": {"phases": wave()}, "hand": {"forearm_moves": True},
        "myohand": {"forearm_moves": True},
        "vqf": {"initial_angles_deg": (20.0, 25.0, 15.0), "align_s": 0.1},
        "vqf9": {}, "seel_ruppin": {}, "constrained": {"sensed": ("hand", "F2p", "F2m", "F2d")},
        "kortier": {"sensed": ("hand", "F2p", "F2m", "F2d")},
        **{kind: {"sensed": ("hand", "F2p", "F2m", "F2d"), **any_initial_pose(kind)}
           for kind in ("salchow_b", "salchow_m1", "salchow_m2")},
        "intention": someone_who_tries(), "emg_effort": {"rest_s": (0.0, 0.2), "contraction_s": (0.2, 0.25)},
        "triggered_phases": {"phases": a_triggered_grasp(), "hold_ms": 0.0, "refractory_s": 0.0,
                             "preview": 3},
        "proportional_posture": {"active_deg": {"finger_flexion": 60.0}, "preview": 3},
        "ideal": {"noise_deg": 0.3, "walk_deg": 0.1}, "error_replay": {"process": an_error_process()},
        "segment_calibration": {"method": "poses", "flat_s": (0.0, 0.1), "flexion_s": (0.1, 0.2),
                                "assumed": (0,), "limits": any_pose()},
        "minimum_jerk": {"times_s": (0.1, 0.4), "angles_deg": ((20.0, 25.0, 15.0), (40.0, 50.0, 25.0)),
                         "preview": 5},
        "grasp_phases": {"phases": a_quick_grasp(), "preview": 3},
        "fingertip_path": {"points": a_short_reach(), "preview": 2},
        "cyclic": {"period_s": 0.1, "mean_deg": {"finger_flexion": 40.0}, "rows": ("finger_flexion",),
                   "amplitude_deg": {"finger_flexion": 30.0}, "shape": "open_close", "preview": 2},
        "programme": {"times_s": (0.1, 0.3), "current_ma": ((20.0, 10.0),), "cycle_s": 0.35,
                      "width_us": ((0.0, 100.0), (300.0, 50.0))},
        "element_sweep": {"count": 6, "stair_s": 0.01, "rest_s": 0.02, "enough_deg": 40.0},
        "point_search": a_hasty_search(),
        "select": {"indices": (2, 0)}, "join": {"unit": "T"},
        "synergies": {},
        "excitation": {"current_ma": (8.0, 10.0), "width_us": ((0.0, 300.0),) * 2, "lead_s": 0.05,
                       "stairs": 2, "stair_s": 0.02, "rest_s": 0.02, "prbs_s": 0.1, "bit_s": 0.02},
        "imus": every_imu_error(), "force_sensors": {}, "muscles": a_tired_patient(),
        "fmu": {"path": "shipped:finger", "step_rate": "100"},
        "pid": {**joints, **current, "recruitment": curves}, "safety": {},
        "stimulator": {}, "electrodes": {},
        "ilc": {"model": model, "places": felt, "duration_s": 0.5, "sd_max_deg": 60.0, "reject_share": 1.0,
                **current},
        "mpc": {"model": model, "places": felt, "grasping_outputs": (1, 2), "grasping_channels": (0, 2),
                **current, **tiring_muscles()},
        "tuned_pid": {"model": model, "rule": "amigo", **current},
        "grip_force": {"places": felt, "target_n": 3.0, "closing": (0, 2)},
    }
    registered = {entry.name for entry in entry_points(group="fesloop.blocks")}
    made = {}
    for kind in sorted(registered - NOT_WITHOUT_FILES):
        block = load(kind)(**parameters[kind])
        shapes = {p.name: tuple(4 if size is None and p.name != "angles" else size or 3 for size in p.shape)
                  for p in block.inputs}
        made[kind] = block.resolve(shapes) if any(not p.resolved for p in block.inputs) else block
    return made


def tiring_muscles():
    """Parameters of `mpc` that follows its muscles' strengths and keeps limits of angle and charge."""
    from controllers.mpc.strength_adaptation import StrengthAdaptation

    return {"adaptation": StrengthAdaptation(speeds=(0.8, 1.0), delays_ms=(0.0, 10.0)),
            "angle_max_deg": (60.0, 90.0, 60.0), "horizon_charge_max_uc": 900.0}


def a_quick_grasp():
    """A hand that opens and closes."""
    from controllers.reference.phases import GraspPhase

    rest = {"wrist_extension": -20.0, "finger_flexion": 30.0, "thumb_flexion": 10.0}
    return (GraspPhase(name="rest", duration_s=0.05, deg=rest),
            GraspPhase(name="open", duration_s=0.15, move_s=0.1, deg={"wrist_extension": 20.0}),
            GraspPhase(name="close", duration_s=0.1, deg={"finger_flexion": 60.0}))


def a_triggered_grasp():
    """A hand that opens and closes at will."""
    from controllers.reference.triggered import TriggeredPhase

    return (TriggeredPhase(name="rest"),
            TriggeredPhase(name="open", move_s=0.05, deg={"wrist_extension": 20.0}),
            TriggeredPhase(name="close", move_s=0.05, deg={"finger_flexion": 60.0}))


def someone_who_tries():
    """Parameters of `intention` with two attempts, and no artefact, so that there is no input."""
    from plants.intention.emg import EmgElectrode
    from plants.intention.script import Attempt

    return {"attempts": (Attempt(at_s=0.0, duration_s=0.1, action="extend_wrist"),
                         Attempt(at_s=0.3, duration_s=0.1, muscles=("FCR", "shoulder"))),
            "emg": (EmgElectrode(muscle="ECRL"), EmgElectrode(muscle="shoulder")),
            "elsewhere": {"shoulder": 1.0}, "reaction_s": 0.05, "jitter_s": 0.01, "rise_s": 0.05}


def a_short_reach():
    """An index finger that goes there and back."""
    from controllers.reference.fingertips import FingertipPoint

    return (FingertipPoint(at_s=0.05), FingertipPoint(at_s=0.2, by_mm={"F2": (0.0, 8.0, 0.0)}),
            FingertipPoint(at_s=0.35, by_mm={"F2": (0.0, -8.0, 0.0)}))


def wave():
    """A finger that bends once."""
    from plants.moving_hand.script import Phase

    return (Phase(duration_s=0.2, posture_deg={"F2_pip_flexion": 60.0}),)


def any_initial_pose(kind):
    """An initial pose that samples which are none keep, of the kinds that take one."""
    from estimators.calibration.initial_pose import InitialPoseLimits

    limits = InitialPoseLimits(rate_deg_s=1e4, rate_sd_deg_s=1e4, bias_deg_s=1e4, turned_deg=180.0,
                               gravity=1e3)
    pose = {"initial_pose_s": 0.1, "pose_limits": limits, "pose_sd_deg": 1e3}
    return {} if kind == "salchow_b" else pose


def an_error_process():
    from fesloop.loop.duration import Duration
    from fesloop.models.error_process import ErrorProcess, ErrorSeries

    every = {"bias_deg": 1.0, "slope": 0.05, "lead_s": -0.01, "fast_deg": 0.5, "fast_s": 0.2,
             "quick_deg": 0.1}
    return ErrorProcess(
        series=(ErrorSeries(name="a", slow_deg=1.0, slow_s=5.0, speed_s=0.5, **every),
                ErrorSeries(name="b", slow_deg=1.0, slow_s=0.5, smooth=True, quick_s=0.02, **every)),
        correlation=((1.0, 0.4), (0.4, 1.0)), age_ms=5.0, loss=0.2, burst_messages=2.0,
        jitter=Duration(kind="exponential", mean_ms=5.0, high_ms=20.0))


def any_pose():
    """Limits of calibration that samples which are no pose keep."""
    from estimators.calibration.poses import PoseLimits

    return PoseLimits(least_samples=5, still_deg_s=1e4, spread_m_s2=1e3, gravity_m_s2=1e3,
                      least_flexion_deg=0.01, wobble_deg=90.0, skew_deg=89.0)


def every_imu_error():
    """Parameters of `imus` with every source of error but loss, whose NaN equals nothing."""
    from plants.imus.disturbances import Dipole, MagneticField, PulseArtefacts, SoftTissue, Tremor

    field = MagneticField(dipoles=(Dipole(position=(1.0, 0.0, 0.0), moment=(0.5, 0.0, 0.0)),
                                   Dipole(position=(0.0, 0.05, 0.0), moment=(0.0, 0.1, 0.0), carrier="hand")))
    return {"soft_tissue": SoftTissue(), "tremor": Tremor(), "artefacts": PulseArtefacts(),
            "magnetic_field": field}


def a_tired_patient():
    """Parameters of `muscles` with pulses, fatigue, spasticity and tremor."""
    from plants.muscles.lags import MuscleFatigue
    from plants.muscles.patient_drive import MuscleTremor, StretchReflex

    return {"model": "ding2007", "fatigue": MuscleFatigue(), "reflex": StretchReflex(),
            "tremor": MuscleTremor()}


def a_hasty_search():
    """Parameters of `point_search` with some queries in a third of a second."""
    from controllers.point_search.space import SearchSpace
    from controllers.point_search.state import Timetable

    return {"space": SearchSpace(elements=(3, 4)),
            "timetable": Timetable(begin_s=0.02, rest_s=0.03, ramp_s=0.02, settle_s=0.01, measure_s=0.01)}


def load(kind):
    """The class of a kind."""
    (entry,) = (e for e in entry_points(group="fesloop.blocks") if e.name == kind)
    return entry.load()


def context(kind):
    """A place in time."""
    return Context(kind, 5, 0, RateClock.from_rate("100"))


def value(port, rng):
    """A plausible value of a port."""
    if port.unit == "A,s":
        return rng.uniform((0.0, 0.0), (0.04, 4e-4), port.shape)
    if port.unit == "A,s,Hz":
        return rng.uniform((0.0, 5e-5, 20.0), (6e-3, 4e-4, 50.0), port.shape)
    scale, mean = {"m/s^2": (1.0, 5.0), "T": (1e-5, 3e-5), "Hz": (5.0, 30.0)}.get(port.unit, (0.3, 0.4))
    drawn = mean + scale * rng.standard_normal(port.shape)
    return float(drawn) if port.shape == () else drawn


def feed(block, ticks, seed=1):
    """Inputs for some ticks: lists of Samples."""
    rng = np.random.default_rng(seed)
    return [[Sample(value(port, rng), k * 10 * NS_PER_MS, k * 10 * NS_PER_MS, k * 10 * NS_PER_MS)
             for port in block.inputs] for k in range(ticks)]


def step_through(kind, block, state, feeds, first=0):
    """[(outputs, reports)] of consecutive ticks, or of consecutive 10 ms of a plant."""
    seen = []
    for k, samples in enumerate(feeds, first):
        tick = Tick()
        tick.index, tick.time_ns = k, k * 10 * NS_PER_MS
        if hasattr(block, "advance"):
            inputs = [sample.value for sample in samples]
            block.advance(state, inputs, tick.time_ns, tick.time_ns + 10 * NS_PER_MS)
            outputs = block.read(state, inputs)
        else:
            outputs = block.step(state, samples, tick)
        seen.append((outputs, list(tick.reports)))
    return seen


def flat(seen):
    """Outputs of all ticks as nested lists, reports after them; None for NaN, which equals nothing."""
    return [([np.where(np.isnan(v), None, v).tolist() for v in outputs], reports)
            for outputs, reports in seen]


if __name__ == "__main__":
    results = {}
    for name, specimen in specimens().items():
        results[name] = flat(step_through(name, specimen, specimen.init(context(name)), feed(specimen, 30)))
    json.dump(results, sys.stdout)
