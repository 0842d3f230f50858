"""Cautions about an experiment that no run would report, found without running it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import asdict, fields, is_dataclass

import numpy as np

from fesloop.experiment.metrics.grasp_outcome import RESTING_M, half_height, longest
from fesloop.experiment.running import Experiment
from fesloop.experiment.score_spec import Score
from fesloop.loop.abilities import Warns, offers
from fesloop.loop.block import Context
from fesloop.loop.cautions import cautions_in_place, too_old
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import is_live
from fesloop.loop.wiring import Wiring

Caution = tuple[str, str, str]
"""Node, status, detail."""
_MEASURED = "measured"
"""Input of a controller that receives the controlled quantity."""
_INSTANTS = 2000
"""Instants of the scored span at which a reference is evaluated (chosen: ms apart in a trial of seconds)."""
_SECONDS = re.compile(r"^[^.]*(?<!deg|rad)_s$")
"""Names of durations in seconds: no rates of rotation, and none in tables, which are time constants."""
_STILL = 1e-9
"""Chosen: less than this, rad, is round-off and no motion."""


def experiment_cautions(experiment: Experiment, *, blocks: bool = True) -> list[Caution]:
    """Cautions about an experiment.

    They are controllers that no plant reaches, references that do not move while they are scored, durations
    longer than a trial, scored spans that end beyond it, objects above or within their tables, inputs that
    are always or often too old, contradictions between neighbours, and warnings of plants; with `blocks`,
    also those of blocks, which report them at their first tick.
    """
    wiring, duration_ns = experiment.wiring, experiment.duration_ns
    return [*_unclosed(wiring), *_references(experiment), *_endless(experiment),
            *_unscored(experiment.score, duration_ns),
            *_unsupported(wiring),
            *too_old(wiring, duration_ns),
            *cautions_in_place(wiring, duration_ns), *_warnings(experiment, blocks)]


def _warnings(experiment: Experiment, blocks: bool) -> Iterator[Caution]:
    for node in experiment.wiring.nodes:
        if (blocks or node.is_plant) and offers(node.part, Warns):
            context = Context(node.name, experiment.seed, clock=node.clock)
            yield from ((node.name, *warning) for warning in node.part.cautions(context))


def _unclosed(wiring: Wiring) -> Iterator[Caution]:
    """Controllers that act on a plant, and whose measurement derives from none.

    A block that plays a recording or reads a live stream is a measurement, too.
    """
    onward = [(c.source.name, c.target.name) for c in wiring.connections]
    acting = _reached({node.name for node in wiring.nodes if node.is_plant},
                      [(target, source) for source, target in onward])
    measuring = _reached({node.name for node in wiring.nodes if node.is_plant or _plays(node)}, onward)
    for connection in wiring.connections:
        target, port = connection.target, connection.target.part.inputs[connection.target_port].name
        if port != _MEASURED or target.is_plant or target.name not in acting \
                or connection.source.name in measuring:
            continue
        yield (target.name, "loop_not_closed",
               f"no way leads from the patient to the input `{port}` of `{target.name}`: "
               f"`{connection.wire.source}`, which is wired to it, derives from no output of a plant; what "
               "the joints do changes nothing")


def _plays(node: Node) -> bool:
    return is_live(node) or hasattr(node.part, "source")


def _reached(begin: set[str], steps: list[tuple[str, str]]) -> set[str]:
    """Names that are reached from `begin`, which are included."""
    found, ends = set(begin), list(begin)
    while ends:
        end = ends.pop()
        new = {to for source, to in steps if source == end} - found
        found |= new
        ends += new
    return found


def _references(experiment: Experiment) -> Iterator[Caution]:
    """References with way-points after the trial's end, and scored ones that move at other times only."""
    duration_s = experiment.duration_ns / NS_PER_S
    score = experiment.score
    scored = (score.reference or "").partition(".")[0]
    for node in experiment.wiring.nodes:
        course = getattr(node.part, "course", None)
        times = np.asarray(getattr(course, "times_s", ()), dtype=np.float64)
        if course is None or times.ndim != 1 or not times.size:
            continue
        until_s = duration_s if score.until_s is None else min(score.until_s, duration_s)
        at = course.at(np.linspace(score.after_s, until_s, _INSTANTS))
        still = node.name == scored and float(np.ptp(at, axis=0).max()) < _STILL \
            < float(np.ptp(course.at(times), axis=0).max())
        late = times[times > duration_s]
        if not still and not late.size:
            continue
        texts = []
        if late.size:
            texts.append(f"{late.size} of {times.size} way-points, at {_span(late)} s, lie beyond the trial "
                         f"of {duration_s:g} s")
        if still:
            texts.append(f"the reference does not move from {score.after_s:g} to {until_s:g} s, where it is "
                         "scored: an error of 0 shows nothing")
        yield (node.name, "reference_still" if still else "reference_cut_off",
               f"{'; '.join(texts)}; times are in seconds from the trial's beginning")


def _endless(experiment: Experiment) -> Iterator[Caution]:
    """Durations longer than a trial, other than defaults and time constants.

    Blocks that are live wait for others, longer than a trial if need be.
    """
    trial_s = experiment.duration_ns / NS_PER_S
    stated = [(node.name, key, "", value) for node in experiment.wiring.nodes if not is_live(node)
              for key, value in (*_own_values(node.part), ("offset_ms", node.offset_ms))]
    stated += [(wire.target.partition(".")[0], "latency_ms", f" of the wire from {wire.source}",
                float(wire.latency_ms)) for wire in experiment.wires]
    for node, key, of, value in stated:
        unit = "ms" if key.endswith("_ms") else "s" if _SECONDS.search(key) else ""
        limit = {"ms": 1e3 * trial_s, "s": trial_s}.get(unit, np.inf)
        if value > limit:
            never = "nothing begins in one" if key == "begin_s" else "it does not end in one"
            yield (node, "longer_than_trial", f"{key}{of} is {value:g} {unit}, longer than a trial "
                   f"({limit:g} {unit}), so that {never}")


def _unscored(score: Score, trial_ns: int) -> Iterator[Caution]:
    """Instants and durations of scores beyond a trial's end."""
    parts = [("score", score), *((f"score.{each.name}", getattr(score, each.name)) for each in fields(score))]
    times = [(f"{where}.{each.name}", getattr(part, each.name)) for where, part in parts if is_dataclass(part)
             for each in fields(part) if _SECONDS.search(each.name)]
    late = [f"{key} is {time_s:g} s" for key, time_s in times
            if time_s is not None and round(time_s * NS_PER_S) > trial_ns]
    if late:
        ends = f"{trial_ns / NS_PER_S:g} s"
        yield ("score", "longer_than_trial", f"{', '.join(late)}, and a trial ends at {ends}: "
               "what lies beyond is not scored; lengthen experiment.duration_s, or score earlier")


def _unsupported(wiring: Wiring) -> Iterator[Caution]:
    """Objects whose lowest point is not on the table that they are put on."""
    for node in wiring.nodes:
        thing, table = getattr(node.part, "object", None), getattr(node.part, "table", None)
        if thing is None or table is None:
            continue
        thing, table = asdict(thing), asdict(table)
        x, y, z = thing["position_m"]
        beside = np.abs(np.array([x, y]) - table["centre_m"]) - table["half_m"]
        half = float(half_height(thing, np.array([thing["orientation"]]))[0])
        above = z - half - table["height_m"]
        if abs(above) <= RESTING_M or beside.max() > longest(thing):
            continue
        what = (f"is put {1e3 * above:.3g} mm above its table, and falls onto it" if above > 0.0 else
                f"reaches {-1e3 * above:.3g} mm into its table, where it has no room")
        yield (node.name, "object_off_table", f"the object {what}; object.position_m[2] = {z - above:.4g} or "
               f"table.height_m = {z - half:.4g} puts it on the table")


def _own_values(part: object, within: str = "") -> Iterator[tuple[str, float]]:
    """Numbers among the parameters of a block and in their tables, other than defaults, with their keys."""
    for each in fields(part) if is_dataclass(part) else ():
        value = getattr(part, each.name, None)
        if isinstance(value, (int, float)) and value != each.default:
            yield f"{within}{each.name}", float(value)
        yield from _own_values(value, f"{within}{each.name}.")


def _span(times: np.ndarray) -> str:
    first, last = f"{times[0]:g}", f"{times[-1]:g}"
    return first if first == last else f"{first} to {last}"
