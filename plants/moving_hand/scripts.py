"""Named scripts: movements of the experiments of two papers, and of an hour of use.

K14 is Kortier et al. 2014 (doi 10.1186/1743-0003-11-70), S19 Salchow-Hoemmen et al. 2019 (doi
10.3390/s19010208). Repetitions, durations and distances are as stated there; amplitudes and movements of the
arm are chosen, within the stated rates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fesloop.errors import InputError, did_you_mean
from plants.moving_hand.script import ArmSway, Contact, Phase

Posture = dict[str, float]
_FINGERS = ("F2", "F3", "F4", "F5")


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionScript:
    """Phases, and the posture at their start (deg, by freedom)."""

    phases: tuple[Phase, ...]
    rest_deg: Posture


_MOULD_REST: Posture = {"F1_cmc_abduction": -45.0}
"""S19, section 3.1.1: wrist and fingers straight, the thumb abducted at a fixed angle (here 45 deg)."""
_FLAT: Posture = {}
"""K14: flat on the table, the thumb beside the fingers."""
_OPPOSED: Posture = {"F1_cmc_flexion": 30.0, "F1_cmc_abduction": -30.0, "F1_cmc_pronation": 70.0,
                     "F1_mcp_flexion": 20.0, "F1_ip_flexion": 20.0}
_PINCH: Posture = {**_OPPOSED, "F2_mcp_flexion": 50.0, "F2_pip_flexion": 40.0, "F2_dip_flexion": 20.0}
_ANYWHERE = ArmSway(turn_deg=(40.0, 15.0, 50.0), shift_m=(0.15, 0.10, 0.15), offset_m=(0.0, 0.1, 0.3),
                    period_s=5.0)
"""S19, section 3.2.2: translation and rotation in all directions, away from the table of the initial pose."""


def _finger(name: str, mcp: float, pip: float, dip: float, abduction: float = 0.0) -> Posture:
    posture = {f"{name}_mcp_flexion": mcp, f"{name}_pip_flexion": pip, f"{name}_dip_flexion": dip}
    return posture | ({f"{name}_mcp_abduction": abduction} if abduction else {})


def _fist(mcp: float, pip: float, dip: float) -> Posture:
    posture: Posture = {}
    for name in _FINGERS:
        posture |= _finger(name, mcp, pip, dip)
    return posture


_THUMB_BENT: Posture = {"F1_cmc_flexion": 20.0, "F1_mcp_flexion": 40.0, "F1_ip_flexion": 50.0}


def _alone(posture: Posture) -> Callable[[], MotionScript]:
    """S19, setting 1: initial pose, then 12 repetitions in 40 s (10-15 in 30-50 s, below 2 rad/s)."""
    return lambda: MotionScript(rest_deg=_MOULD_REST, phases=(
        Phase(name="pose", duration_s=5.0),
        Phase(name="task", duration_s=40.0 / 12.0, cycles=12, vary=0.1, posture_deg=posture)))


def _held(contacts: tuple[Contact, ...], posture: Posture, play_deg: float) -> Callable[[], MotionScript]:
    """S19, setting 2: initial pose, then a contact held for 25 s (15-35) while the hand moves anywhere."""
    return lambda: MotionScript(rest_deg=_MOULD_REST, phases=(
        Phase(name="pose", duration_s=5.0),
        Phase(name="task", duration_s=25.0, approach_s=2.0, contacts=contacts, posture_deg=posture,
              play_deg=play_deg, arm=_ANYWHERE)))


def _pinched_twice() -> MotionScript:
    """S19, P3: closed and opened twice."""
    touch = Contact(first="F1 distal", second="F2 distal")
    return MotionScript(rest_deg=_MOULD_REST, phases=(
        Phase(name="pose", duration_s=5.0),
        Phase(name="task", duration_s=9.0, approach_s=1.5, cycles=2, contacts=(touch,), posture_deg=_PINCH,
              play_deg=5.0, arm=_ANYWHERE)))


_BLOCK = (Contact(first="F1 bottom", second="F2 bottom", distance_mm=53.0),
          Contact(first="F1 bottom", second="F3 bottom", distance_mm=46.0),
          Contact(first="F2 bottom", second="F3 bottom", distance_mm=25.0))
_SPACER = Contact(first="F1 bottom", second="F2 bottom", distance_mm=30.0, facing=True)
_SIDE_SPACER = Contact(first="F2 left", second="F3 right", distance_mm=30.0, facing=True)
"""Contact of a left hand, as in S19: F2's left side faces F3."""
_GRASP: Posture = {**_PINCH, **_finger("F3", 50.0, 40.0, 20.0)}
_CALIBRATION = (
    Phase(name="flat", duration_s=4.0),
    Phase(name="flexion", duration_s=2.0, cycles=2,
          posture_deg={**_fist(60.0, 70.0, 45.0), **_THUMB_BENT, "wrist_flexion": 45.0}))
"""K14, sensor-to-segment calibration: flat hand, then flexion without abduction, of wrist and thumb as well,
whose sensors need an axis like the others."""


def _from_flat(*phases: Phase) -> Callable[[], MotionScript]:
    """K14: calibration, flat on the table, the movement, flat on the table."""
    return lambda: MotionScript(rest_deg=_FLAT, phases=(
        *_CALIBRATION, Phase(name="start", duration_s=2.0), *phases,
        Phase(name="end", duration_s=1.0, to_rest=True), Phase(duration_s=1.0)))


_CMC_STILL: Posture = {"F1_cmc_flexion": 38.8, "F1_cmc_abduction": -23.0, "F1_cmc_pronation": 68.0,
                      "F2_mcp_abduction": -4.5}
_TIPS_TOUCH: Posture = {**_CMC_STILL, "F1_mcp_flexion": 22.8, "F1_ip_flexion": 20.0,
                        **_finger("F2", 55.7, 47.5, 24.1)}
_TIPS_OPEN: Posture = {**_CMC_STILL, "F1_mcp_flexion": 13.9, "F1_ip_flexion": 12.2,
                       **_finger("F2", 27.3, 23.3, 11.8)}
"""K14's pinch, for a hand of 190 mm: index and thumb tips travel 66 and 16 mm (65.6 and 15.7 there), without
rotation of the CMC joint. The tips cannot be farther apart than 81 mm then; the 176 mm of which 6.5 mm are
3.7 % are those of the extended hand with its thumb abducted (here 178)."""
_TIPS = Contact(first="F1 distal", second="F2 distal")
_KORTIER: dict[str, Callable[[], MotionScript]] = {
    "kortier_flexion": _from_flat(Phase(
        name="task", duration_s=1.0, cycles=5, vary=0.05, posture_deg=_finger("F2", 75.0, 90.0, 55.0))),
    "kortier_circles": _from_flat(Phase(
        name="task", duration_s=1.0, cycles=5, circle=True,
        posture_deg={"F2_mcp_flexion": 20.0, "F2_mcp_abduction": 18.0})),
    "kortier_pinch": _from_flat(
        Phase(name="widest", duration_s=2.0, posture_deg={"F1_cmc_abduction": -75.0}),
        Phase(duration_s=1.5, posture_deg=_TIPS_OPEN),
        Phase(name="task", duration_s=1.0, approach_s=0.75, cycles=10, contacts=(_TIPS,),
              posture_deg=_TIPS_TOUCH,
              arm=ArmSway(turn_deg=(25.0, 10.0, 30.0), shift_m=(0.08, 0.05, 0.08)))),
    "kortier_rapid": _from_flat(Phase(
        name="task", duration_s=60.0 / 116.0, cycles=30, posture_deg=_fist(60.0, 80.0, 45.0))),
    "kortier_flat": _from_flat(Phase(
        name="task", duration_s=14.0, stay_s=6.0, cycles=10,
        posture_deg={**_fist(65.0, 80.0, 50.0), **_THUMB_BENT})),
    "kortier_mould": _from_flat(Phase(
        name="task", duration_s=14.0, stay_s=6.0, cycles=10,
        posture_deg={**_fist(45.0, 50.0, 30.0), **_OPPOSED},
        arm=ArmSway(turn_deg=(25.0, 10.0, 30.0), shift_m=(0.08, 0.05, 0.08), period_s=20.0))),
}
_SALCHOW: dict[str, Callable[[], MotionScript]] = {
    "A-F1": _alone({"F1_cmc_abduction": 0.0}),
    "A-F2": _alone({"F2_mcp_abduction": -20.0}),
    "A-F3": _alone({"F3_mcp_abduction": 15.0}),
    "AF-F1": _alone({**_OPPOSED, "F1_cmc_pronation": 55.0}),
    "AF-F2": _alone(_finger("F2", 50.0, 50.0, 30.0, -15.0)),
    "AF-F3": _alone(_finger("F3", 50.0, 50.0, 30.0, 10.0)),
    "F-F2": _alone(_finger("F2", 55.0, 60.0, 35.0)),
    "F-F3": _alone(_finger("F3", 55.0, 60.0, 35.0)),
    "P1": _held((_SPACER,), _PINCH, 5.0),
    "P2": _held((_SIDE_SPACER,), {"F2_mcp_abduction": -12.0, "F3_mcp_abduction": 12.0}, 3.0),
    "P3": _pinched_twice,
    "P4": _held(_BLOCK, _GRASP, 0.0),
}
_REACH = ArmSway(turn_deg=(30.0, 10.0, 35.0), shift_m=(0.12, 0.08, 0.10), period_s=6.0)


def _active_minute() -> tuple[Phase, ...]:
    """A minute of use: grasps, single fingers, pinches, and 20 s of rest."""
    one = tuple(Phase(duration_s=1.5, cycles=2, vary=0.1, posture_deg=_finger(name, 50.0, 60.0, 35.0, side))
                for name, side in zip(_FINGERS, (-10.0, 5.0, 8.0, 12.0), strict=True))
    return (Phase(duration_s=2.5, cycles=6, vary=0.1, posture_deg={**_fist(55.0, 70.0, 40.0), **_OPPOSED},
                  arm=_REACH), *one,
            Phase(duration_s=2.6, cycles=5, vary=0.1, posture_deg=_PINCH, arm=_REACH), Phase(duration_s=20.0))


def _hour() -> MotionScript:
    """An hour of use: 35 active minutes, 10 at rest, 15 active; the initial pose is in the first rest."""
    active = _active_minute()
    return MotionScript(rest_deg=_MOULD_REST, phases=(
        Phase(name="pose", duration_s=5.0), Phase(duration_s=15.0), *active[:-1],
        *(phase for _ in range(34) for phase in (active[-1], *active[:-1])),
        Phase(name="still", duration_s=600.0),
        *(phase for _ in range(15) for phase in (*active[:-1], active[-1]))))


SCRIPTS: dict[str, Callable[[], MotionScript]] = {**_SALCHOW, **_KORTIER, "hour": _hour}


def script(name: str) -> MotionScript:
    """Make a script by name; InputError for an unknown one."""
    if name not in SCRIPTS:
        raise InputError("script", f"no script is named {name!r}", ", ".join(SCRIPTS),
                         did_you_mean(name, SCRIPTS))
    return SCRIPTS[name]()
