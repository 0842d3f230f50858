"""Semi-automatic search of doi 10.1186/s12984-018-0460-1 with a simulated therapist."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import degrees, isfinite

import numpy as np

from controllers.point_search.contract import Found, Query, Response
from controllers.point_search.prior_zones import expectation
from controllers.point_search.space import Electrode, SearchSpace
from fesloop.errors import InputError
from fesloop.hand.movements import FREEDOMS


@dataclass(slots=True, eq=False)
class SemiAutomaticState:
    """State of the search.

    Attributes
    ----------
    space: search space.
    electrode: present element; None when the search is over.
    current_ma: present current of the feedback.
    steps: number of its changes at this element.
    held: whether the feedback has reached its band, so that the hand is rated next.
    begun: whether there has been a query.
    found: rated query and quality of each element, in order.
    """

    space: SearchSpace
    electrode: Electrode | None
    current_ma: float
    steps: int = 0
    held: bool = False
    begun: bool = False
    found: dict[Electrode, Found] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class SemiAutomatic:
    """A virtual electrode is moved from element to element while feedback holds the wrist extended.

    Stimulation never pauses. At each place stairs of current bring one freedom's movement into a band; then
    the held hand is rated. The therapist begins where anatomy suggests the movement and goes to an untried
    neighbour of the best place so far, while there is one.

    Attributes
    ----------
    freedom: freedom under feedback.
    target_deg, tolerance_deg: its movement from rest, and the band's half width (the source: 15 +- 5 deg of
        wrist extension; for flexors choose another freedom).
    step_ma: height of a stair (chosen).
    stairs: greatest number of stairs at each place (chosen).
    """

    freedom: str = "wrist_flexion"
    target_deg: float = -15.0
    tolerance_deg: float = 5.0
    step_ma: float = 1.0
    stairs: int = 30

    def __post_init__(self) -> None:
        if self.freedom not in FREEDOMS:
            raise InputError("semi_automatic.freedom", f"{self.freedom!r}", ", ".join(FREEDOMS))
        if not (isfinite(self.target_deg) and self.target_deg != 0.0):
            raise InputError("semi_automatic.target_deg", f"{self.target_deg}", "a finite movement, not 0")
        for key in ("tolerance_deg", "step_ma"):
            if not (isfinite(getattr(self, key)) and getattr(self, key) > 0.0):
                raise InputError(f"semi_automatic.{key}", f"{getattr(self, key)}", "a finite number above 0")
        if self.stairs < 1:
            raise InputError("semi_automatic.stairs", f"{self.stairs}", "1 or more")

    def start(self, space: SearchSpace, key: int) -> SemiAutomaticState:
        """State above the muscle, at the lowest current."""
        alone: list[Electrode] = [(element,) for element in space.usable]
        positions = np.array([space.position(electrode) for electrode in alone])
        first = alone[int(np.argmax(expectation(space.zones, positions, space.radius_mm)))]
        return SemiAutomaticState(space, first, min(self.step_ma, space.current_max_ma))

    def ask(self, state: SemiAutomaticState) -> Query | None:
        """Stair of the feedback, or its final level."""
        if state.electrode is None:
            return None
        return Query(elements=state.electrode, current_ma=state.current_ma, width_us=state.space.width_us,
                     rested=not state.begun, stair=not state.held)

    def tell(self, state: SemiAutomaticState, query: Query, response: Response) -> None:
        """Change the current, or the place once the hand was rated."""
        state.begun = True
        if state.held:
            state.found[query.elements] = Found(query, response.quality)
            state.electrode, state.steps, state.held = self._next(state), 0, False
            return
        # Movement towards the target is positive, whatever the freedom's sign.
        sign = 1.0 if self.target_deg > 0.0 else -1.0
        short = sign * (self.target_deg - degrees(response.movement[FREEDOMS.index(self.freedom)]))
        lowest, highest = min(self.step_ma, state.space.current_max_ma), state.space.current_max_ma
        wanted = state.current_ma + (self.step_ma if short > 0.0 else -self.step_ma)
        limited = min(max(wanted, lowest), highest)
        state.steps += 1
        if abs(short) <= self.tolerance_deg or limited == state.current_ma or state.steps >= self.stairs:
            state.held = True
        else:
            state.current_ma = limited

    def _next(self, state: SemiAutomaticState) -> Electrode | None:
        """Untried neighbour of the best place."""
        best = max(state.found.values(), key=lambda found: found.quality).query.elements[0]
        for one, other in state.space.neighbours():
            if best in (one, other):
                beside: Electrode = (other if one == best else one,)
                if beside not in state.found:
                    return beside
        return None

    def recommend(self, state: SemiAutomaticState) -> Found | None:
        """Best rated level."""
        return max(state.found.values(), key=lambda found: found.quality, default=None)
