"""Outcome of the object of a grasp, a word per trial, from the recording alone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import FINGERS, PARTS, HandSize
from fesloop.hand.grip import places_of, sides
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.movements import MUSCLES
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_S, duration_ns

if TYPE_CHECKING:
    from fesloop.hand.mug import Mug

Array = NDArray[np.float64]
LASTING_S = 0.1
"""Least duration, s, of a contact that counts (chosen: a passing touch is shorter)."""


def contact_s(times_s: Array, forces: Array, starts_s: float, contact_n: float, *,
              one_side: bool = False) -> float:
    """First instant from `starts_s` on at which two sides of the hand hold something between them.

    Each presses by more than `contact_n`, and keeps pressing for `LASTING_S`; NaN if there is none.
    `one_side`: whether one side alone will do. `forces`: (n, 5) or (n, 16), N, on `places_of` them.
    """
    pressing = (sides(forces, places_of(forces)) > contact_n).sum(axis=1)
    touching = (pressing >= (1 if one_side else 2)) & (times_s >= starts_s)
    first = first_lasting(times_s, touching)
    return math.nan if first is None else float(times_s[first])


def first_lasting(times_s: Array, flags: NDArray[np.bool_]) -> int | None:
    """Number of the first row (of n) from which a flag is set for `LASTING_S`; None if there is none."""
    changes = np.flatnonzero(np.diff(flags.astype(np.int8), prepend=0, append=0))
    for first, after in zip(changes[::2], changes[1::2], strict=True):
        # A row is valid until the next one.
        if times_s[min(after, times_s.size - 1)] - times_s[first] >= LASTING_S:
            return int(first)
    return None


def needed_grip_n(node: Mapping[str, Any]) -> float:
    """Least grip force, N, that keeps an object from slipping: weight / (2 friction).

    The object comes from the table of a hand plant; NaN where the table has none. Two fingers of force N on
    either side carry 2 friction N (Westling and Johansson 1984, doi 10.1007/BF00238156, for the slip ratio).
    """
    thing = node.get("object")
    if not isinstance(thing, Mapping) or not thing.get("friction"):
        return math.nan
    return float(thing["mass_kg"] * STANDARD_GRAVITY / (2.0 * thing["friction"]))


Flags = NDArray[np.bool_]

OUTCOMES = {
    "held": "it stayed in the hand",
    "slipped": "it moved too far in the hand, and was still in it at the end",
    "dropped": "it was in the hand and fell",
    "thrown": "it was flung away",
    "on_table": "it never left the table",
    "knocked_off": "it was pushed off the table and never in the hand",
    "not_touched": "the hand never touched it",
    "given_late": "it was given after the hold had begun",
    "not_given": "it was never given: the hand left no room for it",
    "incomplete": "the trial ended before the hold was over",
}
"""Outcomes of an object, each with its meaning.

Judged on the rows from when the object is given to the end of the hold, in this order:

incomplete: the trial ended before.
not_given: an object that is to be given was never nearer to its place in the hand than to where it waits.
held, slipped: at the end it is neither on the table nor gone. Held if it never was farther than `within_mm`
    from its place at the start of the hold, slipped if it was; given_late if it was given during the hold.
thrown: it moved sideways by more than `THROWN_M_S`.
dropped: it was neither on the table nor gone for 0.1 s, and is now.
not_touched: it never was; no part of the hand pressed by more than `contact_n`, and until it was gone for
    good it moved neither sideways nor up by more than `TOUCHED_M`.
on_table, knocked_off: it never was either, but was touched, and at the end it is on the table, or it is not.

On the table: its lowest point is within `RESTING_M` of the table top at that instant, above the top's area.
Gone: it falls from the hand at more than `FALLING_M_S`, goes sideways at more than `THROWN_M_S`, or is
farther than a hand reaches. Where the experiment does not say where object and table are, there is no table.
"""
OBJECT_KEYS = frozenset({"shape", "size_mm", "orientation", "position_m", "given_at_s", "waits_m"})
TABLE_KEYS = frozenset({"height_m", "centre_m", "half_m", "lowered_at_s", "lowering_m", "lowering_m_s"})
"""Keys of a hand plant's tables `object` and `table` that say where the two are."""
THROWN_M_S = 1.0
"""Chosen: what falls out of a hand leaves it sideways at less than half of that."""
TOUCHED_M = 0.002
"""Chosen: contact of object and table lets it settle by less than 0.5 mm."""
RESTING_M = 0.005
"""Chosen: an object follows a table that starts to sink at 0.1 m/s within 0.5 mm; a lifted one is higher."""
FALLING_M_S = 0.5
"""Chosen: reached after 13 mm of free fall; arms that put down an object are slower."""
REACH_M = 0.3
"""Chosen: from wrist or back of the hand to beyond the fingertips of any hand."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ObjectCourse:
    """Motion of an object in a trial, and its surroundings as far as known.

    Attributes
    ----------
    times_s, places: of the rows, (n,), s, and the object's place, (n, 3), m, from the wrist's centre.
    hand: (n, 3), m, the hand's own place likewise; zeros where it is not known.
    in_hand: (n, 3), m, the object's place in the hand where the hand's pose is known, else `places`.
    turned: (n, 4), its orientation, to the global frame.
    pressed: (n,), whether a part of the hand presses; None where forces are not recorded.
    thing, table: tables `object` and `table` of the node that moves it; None where there are none.
    """

    times_s: Array
    places: Array
    hand: Array
    in_hand: Array
    turned: Array
    pressed: Flags | None
    thing: Mapping[str, Any] | None
    table: Mapping[str, Any] | None


@dataclass(frozen=True, slots=True)
class Found:
    """Outcome of the object: a word of `OUTCOMES`; how far it moved in the hand during the hold, m, NaN
    where it was not in the hand then; and how long from the hold's start it stayed, s."""

    word: str
    moved_m: float
    held_s: float


def find_outcome(course: ObjectCourse, from_s: float, until_s: float, within_m: float) -> Found:
    """Outcome of the object in a trial that lasted until the hold's end."""
    times_s = course.times_s
    rows = np.flatnonzero((times_s >= _given_s(course)) & (times_s <= until_s))
    hold = np.flatnonzero((times_s >= from_s) & (times_s <= until_s))
    if not rows.size:
        return Found("not_given", math.nan, 0.0)
    velocity = np.zeros_like(course.places)
    steps_s = np.diff(times_s[rows])[:, np.newaxis]
    velocity[rows[1:]] = np.diff(course.places[rows], axis=0) / steps_s
    resting = _resting(course)
    gone = _gone(course, velocity - np.gradient(course.hand, times_s, axis=0))
    if not (resting[rows[-1]] or gone[rows[-1]]):
        if rows[0] > hold[0]:
            return Found("given_late", math.nan, 0.0)
        moved_m, ends_s = _stayed(course, hold, until_s, within_m)
        return Found("held" if moved_m <= within_m else "slipped", moved_m, ends_s - from_s)
    first = first_lasting(times_s[rows], ~(resting | gone)[rows])
    caught = None if first is None else int(rows[first])
    if (np.linalg.norm(velocity[rows, :2], axis=1) > THROWN_M_S).any():
        word = "thrown"
    elif caught is not None:
        word = "dropped"
    elif not _touched(course, rows, gone):
        word = "not_touched"
    else:
        word = "on_table" if resting[rows[-1]] else "knocked_off"
    if caught is None or caught > hold[0]:
        return Found(word, math.nan, 0.0)
    lost = next(int(row) for row in rows[rows > caught] if resting[row] or gone[row])
    if lost <= hold[0]:
        return Found(word, math.nan, 0.0)
    moved_m, ends_s = _stayed(course, hold[hold < lost], float(times_s[lost]), within_m)
    return Found(word, moved_m, ends_s - from_s)


def _given_s(course: ObjectCourse) -> float:
    """Instant at which the object arrives where it is to be grasped; infinity if it never does."""
    thing = course.thing
    if thing is None or not thing.get("given_at_s"):
        return 0.0
    off = np.asarray(thing["waits_m"])
    ways = course.places - thing["position_m"]
    nearer = np.linalg.norm(ways, axis=1) < np.linalg.norm(ways - off, axis=1)
    there = np.flatnonzero((course.times_s >= thing["given_at_s"]) & (nearer | (not off.any())))
    return float(course.times_s[there[0]]) if there.size else math.inf


def _resting(course: ObjectCourse) -> Flags:
    """Rows in which the object is on the table."""
    table, thing = course.table, course.thing
    if table is None or thing is None:
        return np.zeros(course.times_s.size, dtype=np.bool_)
    lowered_s = table["lowered_at_s"] if table["lowered_at_s"] >= 0.0 else math.inf
    sunk = np.clip((course.times_s - lowered_s) * table["lowering_m_s"], 0.0, table["lowering_m"])
    height = course.places[:, 2] - half_height(thing, course.turned) - (table["height_m"] - sunk)
    beside = np.abs(course.places[:, :2] - table["centre_m"]) - table["half_m"]
    return np.asarray((np.abs(height) <= RESTING_M) & (beside.max(axis=1) <= longest(thing)))


def half_height(thing: Mapping[str, Any], turned: Array) -> Array:
    """Distance from the object's centre down to its lowest point, (n,), m."""
    if thing["shape"] == "mug":
        return _mug(thing).lowest(turned)
    half = 5e-4 * np.asarray(thing["size_mm"])
    axes = np.abs(np.stack([quaternion.rotate(turned, axis)[:, 2] for axis in np.eye(3)], axis=1))
    if thing["shape"] == "ball":
        return np.full(len(turned), half[0])
    if thing["shape"] == "cylinder":
        return np.asarray(half[1] * axes[:, 2] + half[0] * np.sqrt(np.clip(1.0 - axes[:, 2] ** 2, 0.0, 1.0)))
    return np.asarray(axes @ half)


def longest(thing: Mapping[str, Any] | None) -> float:
    """Upper bound of the distance from the object's centre to its farthest point, m."""
    if thing is None:
        return 0.0
    return _mug(thing).reach if thing["shape"] == "mug" else float(5e-4 * np.linalg.norm(thing["size_mm"]))


def _mug(thing: Mapping[str, Any]) -> Mug:
    from fesloop.hand.mug import Mug

    return Mug.of(thing["size_mm"])


def _gone(course: ObjectCourse, from_hand_m_s: Array) -> Flags:
    """Rows in which the object falls, flies or is out of reach, by its velocity (n, 3) from the hand's."""
    far = np.linalg.norm(course.places - course.hand, axis=1) > REACH_M + longest(course.thing)
    flying = np.linalg.norm(from_hand_m_s[:, :2], axis=1) > THROWN_M_S
    return np.asarray(far | flying | (from_hand_m_s[:, 2] < -FALLING_M_S))


def _touched(course: ObjectCourse, rows: NDArray[np.int64], gone: Flags) -> bool:
    """Return whether the hand touched the object, as far as the recording shows."""
    if course.pressed is None and course.thing is None:
        return True
    if course.pressed is not None and course.pressed[rows].any():
        return True
    stays = np.flatnonzero(~gone[rows])  # one that is given above the table falls onto it
    there = rows[:stays[-1] + 1] if stays.size else rows[:1]
    moved = course.places[there] - course.places[rows[0]]
    return bool((np.linalg.norm(moved[:, :2], axis=1) > TOUCHED_M).any() or (moved[:, 2] > TOUCHED_M).any())


def _stayed(course: ObjectCourse, hold: NDArray[np.int64], until_s: float, within_m: float
            ) -> tuple[float, float]:
    """Greatest motion of the object in the hand from the first row on, m, and until when it is near, s."""
    ways = np.linalg.norm(course.in_hand[hold] - course.in_hand[hold[0]], axis=1)
    beyond = np.flatnonzero(ways > within_m)
    return float(ways.max()), float(course.times_s[hold[beyond[0]]]) if beyond.size else until_s


Shape = tuple[int | None, ...]
FREEDOMS = hand_tree(HandSize()).freedoms


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspScore:
    """Score of a grasp: an object keeps its place in the hand during a hold, without its table.

    All but the object and the hold is optional; `fesloop.experiment.metrics.grasp` says what each gives.

    Attributes
    ----------
    object: its position, (3,), m.
    from_s, until_s: start and end of the hold, seconds of each trial.
    within_mm: how far the object may be at any instant of the hold from where it was at its start (chosen).
    hand_position, hand_orientation: of the sites, (17, 3), m, and (17, 4): then the object's place in the
        hand counts, so that a wrist that gives way does not.
    forces: normal forces between the object and palm and bones, (16,), N, or on the fingertips alone, (5,).
    starts_s: when the hand starts to close.
    contact_n: thumb and fingers touch when each side presses by more (chosen: ten times what is read as
        noise on a fingertip, sd 0.05 N).
    needed_n: least grip force that holds the object; None: from its mass and friction, where the node
        that moves it gives them.
    target_n: reference of the grip force, (), N.
    angles: of the hand, (23,), rad.
    intended: freedoms that the movement is meant to move, by name or by what their names begin with ("F2").
    fingertips: (5, 3), m.
    opposed: fingers whose tips' distances from the thumb's tip are averaged as the aperture.
    aperture: reference of the aperture, (), m, or fingertips (5, 3) that have it.
    touching: digits, and "palm", that are meant to press on the object, once the hand closes.
    pulses: (channels, 2), A and s, or (channels,), C a phase, of a node that has a `frequency_hz`.
    activation, fitness: of the muscles, (29,).
    """

    object: str
    from_s: float
    until_s: float
    within_mm: float = 20.0
    hand_position: str | None = None
    hand_orientation: str | None = None
    forces: str | None = None
    starts_s: float = 0.0
    contact_n: float = 0.5
    needed_n: float | None = None
    target_n: str | None = None
    angles: str | None = None
    intended: tuple[str, ...] = ()
    fingertips: str | None = None
    opposed: tuple[str, ...] = ("F2", "F3")
    aperture: str | None = None
    touching: tuple[str, ...] = ()
    pulses: str | None = None
    activation: str | None = None
    fitness: str | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.until_s) and 0.0 <= self.from_s < self.until_s):
            raise InputError("until_s", f"{self.from_s:g} to {self.until_s:g} s", "0 <= from_s < until_s")
        duration_ns(self.until_s, NS_PER_S, "until_s")
        if not 0.0 <= self.starts_s <= self.from_s:
            raise InputError("starts_s", f"{self.starts_s:g}", f"0 to {self.from_s:g}, from_s")
        for key in ("within_mm", "contact_n", "needed_n"):
            value = getattr(self, key)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise InputError(key, f"{value:g}", "a finite number above 0")
        for key, others in (("target_n", ("forces",)), ("touching", ("forces",)), ("intended", ("angles",)),
                            ("aperture", ("fingertips",)),
                            ("activation", ("forces", "fitness")),
                            ("hand_position", ("hand_orientation",)),
                            ("hand_orientation", ("hand_position",)), ("fitness", ("activation",))):
            missing = [other for other in others if getattr(self, key) and getattr(self, other) is None]
            if missing:
                raise InputError(key, f"stands without {' and '.join(missing)}", "both", "add the other")
        for name in self.intended:
            if not any(freedom.startswith(name) for freedom in FREEDOMS) or not name:
                raise InputError("intended", f"{name!r}", ", ".join(FREEDOMS), did_you_mean(name, FREEDOMS))
        if not self.opposed or not set(self.opposed) <= set(FINGERS[1:]):
            raise InputError("opposed", f"{self.opposed}", "one or more of " + ", ".join(FINGERS[1:]))

        for name in self.touching:
            if name not in (*FINGERS, "palm"):
                raise InputError("touching", f"{name!r}", ", ".join((*FINGERS, "palm")),
                                 did_you_mean(name, (*FINGERS, "palm")))

    def signals(self) -> Iterator[tuple[str, str, tuple[Shape, ...]]]:
        """Key, name and valid shapes of every signal that is read."""
        muscles, tips = (len(MUSCLES),), (len(FINGERS), 3)
        shapes: dict[str, tuple[Shape, ...]] = {
            "object": ((3,),), "hand_position": ((17, 3),), "hand_orientation": ((17, 4),),
            "forces": ((len(PARTS),), (len(FINGERS),)), "target_n": ((),),
            "angles": ((len(FREEDOMS),),), "fingertips": (tips,), "aperture": ((), tips), "pulses": (),
            "activation": (muscles,), "fitness": (muscles,)}
        for key, allowed in shapes.items():
            name = getattr(self, key)
            if name is not None:
                yield key, name, allowed

    def units(self) -> Iterator[tuple[str, str, str]]:
        """Key, name and unit of every signal that is read, except pulses, which have two forms."""
        units = {"object": "m", "hand_position": "m", "hand_orientation": "1", "forces": "N", "target_n": "N",
                 "angles": "rad", "fingertips": "m", "aperture": "m", "activation": "1", "fitness": "1"}
        return ((key, name, units[key]) for key, name, _ in self.signals() if key in units)

    def faults(self, shapes: Mapping[str, Shape]) -> Iterator[InputError]:
        """Faults: signals that do not exist or do not fit; `shapes` are those of all outputs."""
        for key, name, allowed in self.signals():
            if name not in shapes:
                yield InputError(f"score.grasp.{key}", f"there is no signal {name!r}",
                                 ", ".join(sorted(shapes)), did_you_mean(name, list(shapes)))
            elif allowed and shapes[name] not in allowed:
                yield InputError(f"score.grasp.{key}", f"{name!r} has shape {shapes[name]}",
                                 " or ".join(map(str, allowed)))
            elif key == "pulses" and not (len(shapes[name]) == 1 or shapes[name][1:] == (2,)):
                yield InputError(f"score.grasp.{key}", f"{name!r} has shape {shapes[name]}",
                                 "(channels, 2), current and pulse width, or (channels,), charge a phase")
