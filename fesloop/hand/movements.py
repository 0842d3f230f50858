"""Target movements of the hand, and the quality of a movement that stimulation causes.

For a movement m from rest, rad, by freedom:

    wanted    W = mean over the wanted freedoms of  min(max(m / t, -1), 1)
    unwanted  U = root of the mean over wrist, thumb and fingers of  u^2
              u = greatest of min(|m| / a, 1) over the other freedoms there
    quality   Q = W - U / 2

with t the whole movement of a freedom and a what is wholly unwanted of another. The whole movement without
any other is 1, rest 0, the opposite of what is wanted -1 or less. Which freedoms move how far, and the half,
are chosen: cost functions of the literature differ, and weigh what is wanted against what is not as this one
does (doi 10.1186/s12984-018-0460-1).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.forms.toml import TomlError, tables_of
from fesloop.given_files import read_whole
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree

Array = NDArray[np.float64]
MovementName = Literal["wrist_extension", "finger_opening", "pinch", "key_pinch", "power_grasp"]
_TREE = hand_tree(HandSize())
FREEDOMS, SEGMENTS = _TREE.freedoms, _TREE.names
UNWANTED_DEG = {"wrist": 30.0, "F1": 40.0, "F2": 40.0, "F3": 40.0, "F4": 40.0, "F5": 40.0}
"""Movement that counts as wholly unwanted, by part of the hand (chosen: half of a usual range)."""
UNWANTED_WEIGHT = 0.5
_FINGERS = ("F2", "F3", "F4", "F5")


class Verdict(NamedTuple):
    """Quality Q of a movement, with its wanted and unwanted parts."""

    quality: float
    wanted: float
    unwanted: float

    @property
    def selectivity(self) -> float:
        """Share of the wanted movement in the whole, 0 to 1; 0 without any wanted movement."""
        wanted = max(self.wanted, 0.0)
        return wanted / (wanted + self.unwanted) if wanted else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Movement:
    """A movement by what it wants of single freedoms.

    Attributes
    ----------
    wanted_deg: the whole movement of each wanted freedom, flexion, ulnar deviation and pronation positive.
    left_alone: freedoms that count as neither.
    name: in reports; that of the file for one from a file.
    """

    wanted_deg: dict[str, float]
    left_alone: tuple[str, ...] = ()
    name: str = ""

    def __post_init__(self) -> None:
        for key, names in (("wanted_deg", self.wanted_deg), ("left_alone", self.left_alone)):
            for name in names:
                if name not in FREEDOMS:
                    raise InputError(f"movement.{key}", f"{name!r} is no freedom of the hand",
                                     ", ".join(FREEDOMS), did_you_mean(name, FREEDOMS))
        for name in self.left_alone:
            if name in self.wanted_deg:
                raise InputError("movement.left_alone", f"{name!r} is wanted, too", "other freedoms",
                                 "remove it from one of the two")
        if not self.wanted_deg:
            raise InputError("movement.wanted_deg", "is empty", "one or more freedoms that move")
        for name, whole in self.wanted_deg.items():
            if not 1.0 <= abs(whole) <= 180.0:
                raise InputError(f"movement.wanted_deg.{name}", f"{whole:g}", "1 to 180 deg, or -180 to -1")

    def judge(self, movement: Array) -> Verdict:
        """Verdict on a movement from rest, (23,), rad, in the order of the hand's freedoms."""
        degrees = dict(zip(FREEDOMS, np.degrees(movement).tolist(), strict=True))
        wanted = [min(max(degrees[name] / whole, -1.0), 1.0) for name, whole in self.wanted_deg.items()]
        worst = dict.fromkeys(UNWANTED_DEG, 0.0)
        for name in FREEDOMS:
            if name not in self.wanted_deg and name not in self.left_alone:
                part = name.partition("_")[0]
                worst[part] = max(worst[part], min(abs(degrees[name]) / UNWANTED_DEG[part], 1.0))
        good = sum(wanted) / len(wanted)
        bad = (sum(u * u for u in worst.values()) / len(worst)) ** 0.5
        return Verdict(good - UNWANTED_WEIGHT * bad, good, bad)


def _of_fingers(**degrees: float) -> dict[str, float]:
    """The same of joints of all four fingers."""
    return {f"{finger}_{joint}_flexion": angle for finger in _FINGERS for joint, angle in degrees.items()}


MOVEMENTS: dict[str, Movement] = {
    "wrist_extension": Movement(wanted_deg={"wrist_flexion": -40.0}),
    # Long extensors straighten the MCP joints; PIP and DIP follow as far as they can. A hand that drops opens
    # its fingers too, but is of no use: the wrist is to be extended by the 15 deg of the semi-automatic
    # search in the source above.
    "finger_opening": Movement(
        wanted_deg={**_of_fingers(mcp=-30.0), "wrist_flexion": -15.0},
        left_alone=tuple(_of_fingers(pip=0.0, dip=0.0))),
    "pinch": Movement(
        wanted_deg={"F2_mcp_flexion": 20.0, "F2_pip_flexion": 30.0, "F1_mcp_flexion": 15.0,
                    "F1_ip_flexion": 30.0},
        left_alone=("F2_dip_flexion", "F1_cmc_flexion", "F1_cmc_abduction", "F1_cmc_pronation")),
    # A key between the thumb and the side of the index finger; the other fingers may bend beside it.
    "key_pinch": Movement(
        wanted_deg={"F2_mcp_flexion": 30.0, "F2_pip_flexion": 50.0, "F1_mcp_flexion": 20.0,
                    "F1_ip_flexion": 20.0},
        left_alone=("F1_cmc_flexion", "F1_cmc_abduction", "F1_cmc_pronation", "F2_dip_flexion",
                    *(name for name in _of_fingers(mcp=0.0, pip=0.0, dip=0.0) if name[:2] != "F2"))),
    "power_grasp": Movement(
        wanted_deg=_of_fingers(mcp=30.0, pip=50.0),
        left_alone=(*_of_fingers(dip=0.0), "F1_cmc_flexion", "F1_mcp_flexion", "F1_ip_flexion")),
}
"""By name (chosen: roughly what a hand at rest lacks of the posture)."""


def movement_of(given: str | Movement) -> Movement:
    """A movement itself, or a shipped one by its name; raises InputError for a name that is not there."""
    if isinstance(given, Movement):
        return given
    if given not in MOVEMENTS:
        raise InputError("movement", f"{given!r}", ", ".join(MOVEMENTS), did_you_mean(given, MOVEMENTS)
                         or "or give the path of a .toml file")
    return MOVEMENTS[given]


def movement_label(given: str | Movement) -> str:
    """Name of a movement in a sentence."""
    name = given.name if isinstance(given, Movement) else given
    return name.replace("_", " ") or "a movement without a name"


def movement_text(given: str | Mapping[str, Any]) -> str:
    """Text that is the same for the same movement, from its name or its table."""
    if isinstance(given, str):
        return given
    whole = {name: float(degrees) for name, degrees in sorted(given["wanted_deg"].items())}
    return json.dumps({"wanted_deg": whole, "left_alone": sorted(given.get("left_alone", ()))})


def stated_movement(given: str) -> str | dict[str, Any]:
    """The name of a shipped movement itself; of the path of a file (.toml) its tables.

    Raises InputError for an unknown name, and for a file that cannot be read or makes no movement.
    """
    if not given.endswith(".toml"):
        movement_of(given)
        return given
    try:
        tables = tables_of(read_whole(given, "a movement's file").decode("utf-8-sig"))
    except UnicodeDecodeError as fault:
        raise InputError(given, f"is not UTF-8 text (byte {fault.start})", "a TOML file") from None
    except TomlError as fault:
        raise InputError(given, f"is not TOML: {fault}", remedy="correct the line") from None
    tables = {"name": Path(given).stem, **tables}
    try:
        _require_form(tables)
        Movement(**tables)
    except InputError as fault:
        place = fault.where.removeprefix("movement.")
        raise InputError(f"{given}: {place}", fault.found, fault.allowed, fault.remedy) from None
    return tables


def _require_form(tables: Mapping[str, Any]) -> None:
    """Raise InputError for a key that no movement has, and a value of another type."""
    keys = ("name", "wanted_deg", "left_alone")
    for key, value in tables.items():
        if key not in keys:
            raise InputError(key, "unknown key", ", ".join(keys), did_you_mean(key, keys))
        if key == "name" and not isinstance(value, str):
            raise InputError(key, f"{value!r} is no text", "text")
        if key == "left_alone" and not (
                isinstance(value, list) and all(isinstance(name, str) for name in value)):
            raise InputError(key, f"{value!r}", "a list of freedoms")
        if key == "wanted_deg" and not isinstance(value, dict):
            raise InputError(key, f"{value!r} is no table", "a table of freedoms, with degrees each")
    for name, whole in tables.get("wanted_deg", {}).items():
        if isinstance(whole, bool) or not isinstance(whole, int | float):
            raise InputError(f"wanted_deg.{name}", f"{whole!r} is no number", "degrees")
    if "wanted_deg" not in tables:
        raise InputError("wanted_deg", "is missing", "a table of freedoms, with degrees each", "add it")


EXTRINSIC = (
    "ECRL", "ECRB", "EDC2", "EDC3", "EDC4", "EDC5", "EDM", "ECU", "EIP", "EPL", "EPB", "APL",
    "FCR", "PL", "FCU", "FDS2", "FDS3", "FDS4", "FDS5", "FDP2", "FDP3", "FDP4", "FDP5", "FPL")
"""Extensors and abductors, then flexors, of wrist, fingers and thumb."""
INTRINSIC = ("THENAR", "INT2", "INT3", "INT4", "INT5")
"""The thenar group, and for each finger its lumbrical and interossei lumped."""
MUSCLES = EXTRINSIC + INTRINSIC


def muscle(name: str) -> int:
    """Index of a muscle in `MUSCLES`; raises InputError for a name that is not there."""
    if name not in MUSCLES:
        raise InputError("muscle", f"{name!r}", ", ".join(MUSCLES), did_you_mean(name, MUSCLES))
    return MUSCLES.index(name)


def each_muscle(usual: float, own: Mapping[str, float], where: str) -> Array:
    """The number of each muscle, (muscles,): from `own` by name, `usual` for all others.

    Raises InputError, which begins with `where`, for an unknown muscle.
    """
    numbers = np.full(len(MUSCLES), usual)
    for name, number in own.items():
        try:
            numbers[muscle(name)] = number
        except InputError as fault:
            raise InputError(where, fault.found, fault.allowed, fault.remedy) from fault
    return numbers
