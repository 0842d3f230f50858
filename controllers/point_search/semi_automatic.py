"""The semi-automatic search of doi 10.1186/s12984-018-0460-1, its therapist simulated."""

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
    """Where the virtual electrode stands.

    Attributes
    ----------
    space: where it moves.
    electrode: under it; None when the therapist is content.
    current_ma: that feedback has come to. steps: how often it has changed it here.
    held: whether feedback is content, so that the hand is judged next.
    begun: whether anything has been asked.
    found: what each electrode was judged at, in order.
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

    Stimulation goes on throughout. At each place stairs of current bring one freedom's movement into a
    band; then the hand is judged as it is held. The therapist begins where anatomy lets the movement be
    expected and goes to a neighbour of the best place so far that has not been tried, while there is one.

    Attributes
    ----------
    freedom: under feedback. target_deg, tolerance_deg: its movement from rest, and the band's half width (the
        source: 15 +- 5 deg of wrist extension; for flexors choose another freedom).
    step_ma: of a stair (chosen). stairs: at most, at each place (chosen).
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
        """Above the muscle, at the lowest current."""
        alone: list[Electrode] = [(element,) for element in space.usable]
        positions = np.array([space.position(electrode) for electrode in alone])
        first = alone[int(np.argmax(expectation(space.zones, positions, space.radius_mm)))]
        return SemiAutomaticState(space, first, min(self.step_ma, space.current_max_ma))

    def ask(self, state: SemiAutomaticState) -> Query | None:
        """A stair of the feedback, or the level that it has come to."""
        if state.electrode is None:
            return None
        return Query(elements=state.electrode, current_ma=state.current_ma, width_us=state.space.width_us,
                     rested=not state.begun, stair=not state.held)

    def tell(self, state: SemiAutomaticState, query: Query, response: Response) -> None:
        """Change the current, or move on once the hand was judged."""
        state.begun = True
        if state.held:
            state.found[query.elements] = Found(query, response.quality)
            state.electrode, state.steps, state.held = self._next(state), 0, False
            return
        # Towards the target is positive, whatever the freedom's sign.
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
        """A neighbour of the best place that has not been tried."""
        best = max(state.found.values(), key=lambda found: found.quality).query.elements[0]
        for one, other in state.space.neighbours():
            if best in (one, other):
                beside: Electrode = (other if one == best else one,)
                if beside not in state.found:
                    return beside
        return None

    def recommend(self, state: SemiAutomaticState) -> Found | None:
        """The best level that was held."""
        return max(state.found.values(), key=lambda found: found.quality, default=None)
