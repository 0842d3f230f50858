"""What a grasp is scored by: which signals, which times, and what counts as held."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.movements import MUSCLES
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_S, duration_ns

Shape = tuple[int | None, ...]
FREEDOMS = hand_tree(HandSize()).freedoms


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspScore:
    """What is a grasp: an object that stays where it is in the hand during a hold, without its table.

    All but the object and the hold is optional; `fesloop.experiment.metrics.grasp` says what each gives.

    Attributes
    ----------
    object: its position, (3,), m.
    from_s, until_s: start and end of the hold, seconds of each trial.
    within_mm: how far the object may be at any instant of the hold from where it was at its start (chosen).
    hand_position, hand_orientation: of the sites, (17, 3), m, and (17, 4): then the object's place in the
        hand counts, so that a wrist that gives way does not.
    forces: contact forces of the fingertips, (5,), N.
    starts_s: when the hand starts to close.
    contact_n: thumb and fingers touch when each side presses by more (chosen: ten times what is read as
        noise on a fingertip, sd 0.05 N).
    needed_n: least grip force that holds the object; None: from its mass and friction, where the node
        that moves it tells them.
    wanted_n: grip force that is wanted, (), N.
    angles: of the hand, (23,), rad.
    asked: freedoms that the movement asks for, by name or by what their names begin with ("F2").
    fingertips: (5, 3), m.
    opposed: fingers whose tips' distances from the thumb's tip are averaged as the aperture.
    aperture: wanted, (), m, or fingertips (5, 3) that have it.
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
    wanted_n: str | None = None
    angles: str | None = None
    asked: tuple[str, ...] = ()
    fingertips: str | None = None
    opposed: tuple[str, ...] = ("F2", "F3")
    aperture: str | None = None
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
        for key, others in (("wanted_n", ("forces",)), ("asked", ("angles",)), ("aperture", ("fingertips",)),
                            ("activation", ("forces", "fitness")),
                            ("hand_position", ("hand_orientation",)),
                            ("hand_orientation", ("hand_position",)), ("fitness", ("activation",))):
            missing = [other for other in others if getattr(self, key) and getattr(self, other) is None]
            if missing:
                raise InputError(key, f"stands without {' and '.join(missing)}", "both", "add the other")
        for name in self.asked:
            if not any(freedom.startswith(name) for freedom in FREEDOMS) or not name:
                raise InputError("asked", f"{name!r}", ", ".join(FREEDOMS), did_you_mean(name, FREEDOMS))
        if not self.opposed or not set(self.opposed) <= set(FINGERS[1:]):
            raise InputError("opposed", f"{self.opposed}", "one or more of " + ", ".join(FINGERS[1:]))

    def signals(self) -> Iterator[tuple[str, str, tuple[Shape, ...]]]:
        """Key, name and shapes that will do, of every signal that is read."""
        muscles, tips = (len(MUSCLES),), (len(FINGERS), 3)
        shapes: dict[str, tuple[Shape, ...]] = {
            "object": ((3,),), "hand_position": ((17, 3),), "hand_orientation": ((17, 4),),
            "forces": ((len(FINGERS),),), "wanted_n": ((),),
            "angles": ((len(FREEDOMS),),), "fingertips": (tips,), "aperture": ((), tips), "pulses": (),
            "activation": (muscles,), "fitness": (muscles,)}
        for key, allowed in shapes.items():
            name = getattr(self, key)
            if name is not None:
                yield key, name, allowed

    def units(self) -> Iterator[tuple[str, str, str]]:
        """Key, name and unit of every signal that is read; of pulses there are two ways."""
        units = {"object": "m", "hand_position": "m", "hand_orientation": "1", "forces": "N", "wanted_n": "N",
                 "angles": "rad", "fingertips": "m", "aperture": "m", "activation": "1", "fitness": "1"}
        return ((key, name, units[key]) for key, name, _ in self.signals() if key in units)

    def faults(self, shapes: Mapping[str, Shape]) -> Iterator[InputError]:
        """Signals that do not exist or do not fit; `shapes` are those of all outputs."""
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
