"""What a patient's stimulation can reach: the floor under every error of following a reference.

Surface stimulation cannot set every joint. For a reference the best admissible pulse widths are sought with
perfect knowledge, offline, on the simulated plant itself, without noise and without an object; what error is
left, no controller of these channels and currents need be blamed for. What is found is an upper bound of the
true floor: the search is local, knots are `SPACING_S` apart, stimulation changes from `LEAD_S` before the
window on, and axons fire one by one, which leaves some tenths of a degree. How far searches from several
starts end apart (`Floor.spread_deg`) tells how tight it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.chain_slopes import ChainSlopes
from fesloop.apps.reproduce.open_chain import OpenChain
from fesloop.apps.reproduce.reachable_descent import Aim, Descent, descend
from fesloop.apps.reproduce.reachable_posture import held_postures
from fesloop.errors import InputError
from fesloop.experiment.experiment import Experiment
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wiring import Wiring

Array = NDArray[np.float64]
SPACING_S = 0.1
"""Between knots of the pulse widths (chosen: knots twice as close gain nothing)."""
LEAD_S = 0.7
"""Before the window, from when on widths are sought (chosen: by then what was before is forgotten)."""
_STEPS = 16
_POSTURES_S = 0.4
"""Between the postures of the quasi-static start (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Floor:
    """The least error that was found, over the window.

    Attributes
    ----------
    rmse_deg, rows_deg: of all sums, and (m,) of each.
    widths_s: (n, channels), as `safety` admits them, the last held after the window.
    course: (n, m), rad, what they make of the patient; NaN before the search begins and after the window.
    ends_deg: by start, where the search from it ended; settled: by start, whether it had stopped falling.
    static_deg: (m,), error of the best postures that standing still reaches, fresh, along the reference.
    rollouts: how often the plant was played.
    """

    rmse_deg: float
    rows_deg: Array
    widths_s: Array
    course: Array
    ends_deg: Mapping[str, float]
    settled: Mapping[str, bool]
    static_deg: Array
    rollouts: int

    @property
    def spread_deg(self) -> float:
        """How far the second best search ended above the best."""
        best = sorted(self.ends_deg.values())
        return best[1] - best[0] if len(best) > 1 else float("inf")


def reference_course(experiment: Experiment) -> Array:
    """(n, m), rad, what the experiment's scored reference asks at its ticks, over a trial."""
    name, _, port = str(experiment.score.reference).partition(".")
    nodes = [node for node in experiment.nodes if node.name == name]
    if not nodes or nodes[0].part.inputs:
        raise InputError("score.reference", f"{experiment.score.reference}", "a source without inputs")
    seen = Recorder(None)
    Loop(Wiring(nodes, [], experiment.seed), recorder=seen).run_until(experiment.duration_ns - 1)
    number = [each.name for each in nodes[0].part.outputs].index(port)
    return np.array([row[5][number] for row in seen.blocks[name]])


def learnt_widths(recording: Recording, trial: int) -> Array:
    """(n, channels), s, what left the block `safety` in a trial: a start for `reachable_floor`."""
    widths: Array = np.asarray(recording.signal("safety.stimulation", trial).values)[:, :, 1]
    return widths


def reachable_floor(
    experiment: Experiment, reference: Array, window_s: tuple[float, float],
    starts: Mapping[str, Array] | None = None, current_ma: Array | None = None,
) -> Floor:
    """The least error over [from, until) that widths found from several starts leave.

    The search begins at no stimulation (`rest`), at the best postures along the reference (`postures`), and
    at `starts`, where it never ends above what they reach themselves.

    Parameters
    ----------
    experiment: with nodes `safety`, `stimulator`, `electrodes`, `muscles`, `hand`; its score's truth is a
        node of kind `synergies`.
    reference: (n, m), rad, at the ticks of `safety`, for the sums of the score's truth.
    window_s: where errors count, s.
    starts: by name, widths (n, channels), s, such as those that a controller has learnt.
    current_ma: (channels,); None: those of the node `controller`.

    Raises InputError for what does not fit together.
    """
    currents = _currents(experiment) if current_ma is None else np.asarray(current_ma, dtype=np.float64)
    probe = OpenChain(experiment, currents, 1)
    begin, end = (probe.tick_at(time_s) for time_s in window_s)
    if not 0 <= begin < end <= len(reference) or reference.shape[1:] != (len(probe.rows),):
        raise InputError("reference", f"shape {reference.shape}, window {window_s[0]:g} to {window_s[1]:g} s",
                         f"(n, {len(probe.rows)}), a window of at least a tick within its n ticks")
    given = _checked(starts or {}, end, len(currents))
    chain = OpenChain(experiment, currents, end)
    per_s = 1.0 / (1e-9 * probe.time_ns(1))
    aim = Aim(reference[:end], max(0, begin - round(LEAD_S * per_s)), begin)
    slopes = ChainSlopes(chain)
    every = max(1, round(_POSTURES_S * per_s))
    instants = np.arange(begin, end, every)
    postures, held = held_postures(experiment, currents, reference[instants])
    places = np.arange(end)[:, np.newaxis]
    between = np.array([np.interp(places[:, 0], instants, column)
                        for column in np.array([each.widths for each in postures]).T]).T
    named = {"rest": np.zeros((end, len(currents))), "postures": np.where(places < aim.first, 0.0, between),
             **given}
    ends = {name: descend(chain, slopes, aim, start, max(1, round(SPACING_S * per_s)), _STEPS)
            for name, start in named.items()}
    best = min(ends.values(), key=lambda each: each.rmse_rad[-1])
    widths, course = _lowered(chain, slopes, aim, best)
    errors = np.degrees(aim.errors(course))
    missed = np.degrees(reference[instants] - [each.sums for each in postures])
    whole = np.full(reference.shape, np.nan)
    whole[aim.first:end] = course
    return Floor(
        rmse_deg=float(np.sqrt(np.mean(errors**2))), rows_deg=np.sqrt(np.mean(errors**2, axis=0)),
        widths_s=np.vstack([widths, np.repeat(widths[-1:], len(reference) - end, axis=0)]), course=whole,
        ends_deg={name: float(np.degrees(each.rmse_rad[-1])) for name, each in ends.items()},
        settled={name: each.settled for name, each in ends.items()},
        static_deg=np.sqrt(np.mean(missed**2, axis=0)), rollouts=chain.rollouts + held)


def _currents(experiment: Experiment) -> Array:
    """Currents of the node `controller`, mA."""
    for node in experiment.nodes:
        part: Any = node.part
        if node.name == "controller" and hasattr(part, "current_ma"):
            return np.asarray(part.current_ma, dtype=np.float64)
    raise InputError("current_ma", "no node `controller` that has currents", "current_ma, one a channel")


def _checked(starts: Mapping[str, Array], ticks: int, channels: int) -> dict[str, Array]:
    """The starts up to the window's end."""
    for name, widths in starts.items():
        if widths.ndim != 2 or len(widths) < ticks or widths.shape[1] != channels:
            raise InputError(f"starts.{name}", f"shape {widths.shape}", f"({ticks} or more, {channels})")
    return {name: widths[:ticks] for name, widths in starts.items()}


def _lowered(chain: OpenChain, slopes: ChainSlopes, aim: Aim, best: Descent) -> tuple[Array, Array]:
    """Admitted widths and their course, pulses that recruit nothing left out if that costs nothing."""
    lowered = chain.admitted(np.where(best.widths <= slopes.front.threshold, 0.0, best.widths))
    course = chain.course(lowered, aim.first)
    if np.mean(aim.errors(course) ** 2) <= np.mean(aim.errors(best.course) ** 2) * (1.0 + 1e-9):
        return lowered, course
    return chain.admitted(best.widths), best.course
