"""Elements of scripts of hand movements: phases, contacts and movement of the forearm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import FINGERS
from fesloop.hand.skeleton import CONTACTS

Three = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Two points of fingertips at a constant distance during a phase.

    Attributes
    ----------
    first, second: a finger and one of `fesloop.hand.skeleton.CONTACTS`, such as "F1 bottom".
    distance_mm: distance between them.
    facing: whether the second lies straight out from the skin at the first, as with an object in between;
        otherwise its direction is free.
    """

    first: str
    second: str
    distance_mm: float = 0.0
    facing: bool = False

    def __post_init__(self) -> None:
        for key, text in (("first", self.first), ("second", self.second)):
            finger, _, contact = text.partition(" ")
            if finger not in FINGERS or contact not in CONTACTS:
                known = [f"{f} {c}" for f in FINGERS for c in CONTACTS]
                raise InputError(key, f"{text!r}", f"a finger ({', '.join(FINGERS)}) and one of "
                                 f"{', '.join(CONTACTS)}", did_you_mean(text, known))
        if self.first[:2] == self.second[:2]:
            raise InputError("second", f"{self.second!r} with {self.first!r}", "a point of another finger")
        _require(self, 0.0, "distance_mm")
        if self.facing and self.first.endswith(" tip"):
            raise InputError("first", f"{self.first!r} is inside the finger", "a point on the skin",
                             "choose one: `facing` needs a normal of the skin")


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmSway:
    """Movement of the forearm in a phase: sinusoids with random phases, faded in and out.

    Attributes
    ----------
    turn_deg: amplitudes about the forearm's flexion, abduction and pronation axes.
    shift_m: amplitudes along east, north and up.
    offset_m: centre of the movement, east, north and up of its position at the start of the script.
    period_s: period of the slowest component; a second one has half the amplitude and 1.6 times the
        frequency (chosen, so that the movement does not repeat itself).
    """

    turn_deg: Three = (0.0, 0.0, 0.0)
    shift_m: Three = (0.0, 0.0, 0.0)
    offset_m: Three = (0.0, 0.0, 0.0)
    period_s: float = 4.0

    def __post_init__(self) -> None:
        for key, triple in (("turn_deg", self.turn_deg), ("shift_m", self.shift_m),
                            ("offset_m", self.offset_m)):
            if len(triple) != 3 or not all(math.isfinite(each) for each in triple):
                raise InputError(key, f"{triple}", "three finite numbers")
        if not (math.isfinite(self.period_s) and self.period_s > 0.0):
            raise InputError("period_s", f"{self.period_s}", "a finite number above 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Phase:
    """One phase of a script; it starts in the posture at the end of the phase before.

    Without cycles and contacts the hand moves to `posture_deg` in `duration_s` on minimum-jerk paths (Flash
    and Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985), or keeps still if no freedom is named.

    With cycles it moves there and back as often; each cycle takes `duration_s`, with a pause of `stay_s` at
    either end. In a `circle` the first named freedom is a quarter of a cycle ahead of the others.

    With contacts it first approaches the contacts in `approach_s`, holds them for `duration_s`, and with
    cycles opens and closes as often. The posture is the one nearest to the preferred posture, `posture_deg`
    varied by `play_deg`, in which the contacts hold.

    Attributes
    ----------
    name: name for metrics.
    duration_s: duration of the phase, or of one cycle.
    posture_deg: target angles by freedom (`fesloop.hand.segments.SegmentTree.freedoms`).
    to_rest: whether freedoms that are not named return to the hand's rest.
    cycles: number of cycles; 0: a single movement without return.
    stay_s: pause at either end of a cycle.
    circle: whether freedoms move in quadrature instead of there and back.
    vary: relative sd of the amplitude and duration of each cycle.
    contacts: contacts that hold.
    approach_s: duration of approach and release.
    play_deg: amplitude of variation of the touching fingers' preferred posture.
    arm: movement of the forearm; None: none.
    """

    name: str = ""
    duration_s: float
    posture_deg: dict[str, float] = field(default_factory=dict)
    to_rest: bool = False
    cycles: int = 0
    stay_s: float = 0.0
    circle: bool = False
    vary: float = 0.0
    contacts: tuple[Contact, ...] = ()
    approach_s: float = 1.0
    play_deg: float = 0.0
    arm: ArmSway | None = None

    def __post_init__(self) -> None:
        _require(self, 1e-3, "duration_s", "approach_s")
        _require(self, 0.0, "stay_s", "play_deg")
        if not 0 <= self.cycles <= 100_000:
            raise InputError("cycles", f"{self.cycles}", "0 or more")
        if not 0.0 <= self.vary <= 0.3:
            raise InputError("vary", f"{self.vary}", "0 to 0.3, a relative sd")
        if self.cycles and not self.contacts and 2.0 * self.stay_s >= self.duration_s:
            raise InputError("stay_s", f"{self.stay_s:g} twice in a cycle of {self.duration_s:g} s",
                             "less than half of duration_s")
        if self.circle and not (self.cycles and len(self.posture_deg) > 1):
            raise InputError("circle", f"{self.cycles} cycles of {len(self.posture_deg)} freedoms",
                             "one or more cycles of two or more freedoms")
        for name, angle in self.posture_deg.items():
            if not abs(angle) <= 180.0:
                raise InputError(f"posture_deg.{name}", f"{angle}", "-180 to 180 deg")

    @property
    def length_s(self) -> float:
        """Duration with all cycles, approaches and releases, s."""
        if self.contacts:
            return max(1, self.cycles) * (self.duration_s + self.approach_s) + (
                self.cycles * self.approach_s)
        return max(1, self.cycles) * self.duration_s


def length_s(phases: Sequence[Phase]) -> float:
    """Duration of a script, s."""
    return sum(phase.length_s for phase in phases)


def _require(owner: object, least: float, *names: str) -> None:
    for name in names:
        value = getattr(owner, name)
        if not (math.isfinite(value) and value >= least):
            raise InputError(name, f"{value}", f"a finite number, {least:g} or more")
