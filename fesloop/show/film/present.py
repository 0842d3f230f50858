"""Picture of the hand of a loop at its present instant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.loop.run import Loop
from fesloop.show.film.film import framed
from fesloop.show.film.stage import Picture, Stage, drawing_surface
from fesloop.show.picture.cast import cast_of
from fesloop.show.picture.signals import Instants
from fesloop.show.report.motion import view_into
from fesloop.show.report.recorded_hand import ESTIMATE, TRUTH, hands_at, holdable, recorded_hand

_ROOM = 1.3
"""Picture relative to the hand's first posture (chosen: an opened hand fits)."""


class Present:
    """Present outputs of a loop, with the members of a recording of one instant.

    Parameters
    ----------
    experiment: document of the experiment.
    loop: in operation.
    """

    def __init__(self, experiment: Mapping[str, Any], loop: Loop) -> None:
        self.experiment = experiment
        self._now_ns = max(loop.now, 0)
        self._values = {f"{name}.{port}": value for name in experiment["blocks"]
                        if name in loop.states() for port, value in loop.newest(name).items()}

    @property
    def signals(self) -> Sequence[str]:
        """Every output signal that has a value, as "node.port"."""
        return tuple(self._values)

    @property
    def at_ns(self) -> Instants:
        """The present instant, (1,), ns."""
        return np.array([self._now_ns], dtype=np.int64)

    def column(self, name: str, trial: int = 0) -> tuple[Instants, Any]:
        """The present instant (1,) of a signal, ns, and its value (1, *shape)."""
        return self.at_ns, np.asarray(self._values[name])[np.newaxis]


class HandCamera:
    """Camera that follows the hand of a loop.

    Parameters
    ----------
    experiment: document of the loop's experiment.
    loop: its first posture sets the view.
    width, height: of the pictures, pixels.

    Raises InputError for a loop without a hand or finger, or where nothing draws in three dimensions.
    """

    def __init__(self, experiment: Mapping[str, Any], loop: Loop, width: int, height: int) -> None:
        now = Present(experiment, loop)
        hand = recorded_hand(now, cast_of(now), experiment.get("score", {}))
        if hand is None:
            raise InputError("render", "the experiment has no hand", "a hand, or a finger whose three joints "
                             "are scored", "leave render_mode out")
        self._experiment, self._hand = experiment, hand
        seen = hands_at(now, hand, 0, now.at_ns)
        view = view_into(seen.postures, holdable(seen.solids))
        if view is None:
            raise InputError("render", "the hand has no finite posture", "a posture", "leave render_mode out")
        self._view = view
        self._middle, *extent = framed(hand.shapes, seen, view)
        self._extent = tuple(_ROOM * each for each in extent)
        with ExitStack() as surface:
            surface.enter_context(drawing_surface(width, height))
            self._stage = Stage(hand.shapes, seen.solids, width, height)
            self._surface = surface.pop_all()

    def picture(self, loop: Loop) -> Picture:
        """Picture (height, width, 3) of the true hand, and the tracker's translucent over it."""
        now = Present(self._experiment, loop)
        seen = hands_at(now, self._hand, 0, now.at_ns)
        rows = {name: poses[0] for name, poses in seen.hands.items()}
        wrist = rows[TRUTH if TRUTH in rows else ESTIMATE][0, 4:]
        self._stage.look(self._view, wrist + self._middle, *self._extent)
        return np.ascontiguousarray(self._stage.picture(rows, seen.solid_poses[0]))

    def close(self) -> None:
        """Free what draws."""
        self._stage.close()
        self._surface.close()
