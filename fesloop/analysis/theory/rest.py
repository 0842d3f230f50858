"""Rest of a linear loop, and its distance from the limits of blocks.

A loop is linear while no limit acts. Where a drive rests on a limit, as that of a muscle that a posture does
not need, any noise, however small, cuts half of its commands: the loop is not linear then.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.theory.loop import LinearLoop
from fesloop.errors import InputError
from fesloop.models.linear_form import numbers_of

Array = NDArray[np.float64]
ROOM_SD = 3.0
"""Least distance of a resting drive from its limits, in standard deviations (chosen: normal noise takes it
there once in 700 commands)."""
_ROUNDING = 1e-9
"""Rounding of drives, whose range is 1; and of a rest, relative to the largest terms of its equations."""


def require_within_limits(loop: LinearLoop) -> None:
    """Raise InputError for the first drive that rests on or beyond a limit of its block."""
    for block, channel, value, end, limit, room in _rooms(loop):
        if room <= _ROUNDING:
            at = f"{_shown(value)}, its {end} limit" if room >= -_ROUNDING else \
                f"{_shown(value)}, beyond its {end} limit {_shown(limit)}"
            raise _not_covered(block, f"drive of channel {channel} rests at {at}")


def require_room(loop: LinearLoop, spread: Callable[[str], Array]) -> None:
    """Raise InputError for the first drive that rests nearer than `ROOM_SD` to a limit.

    `spread` gives the standard deviation of what a block of some name puts out.
    """
    sds: dict[str, Array] = {}
    for block, channel, value, end, limit, room in _rooms(loop):
        sd = float(sds.setdefault(block, spread(block))[channel])
        if room < ROOM_SD * sd:
            raise _not_covered(
                block, f"drive of channel {channel} rests at {_shown(value)}, {room / sd:.2g} sd of its "
                f"noise ({sd:.2g}) from its {end} limit {_shown(limit)}")


def _rooms(loop: LinearLoop) -> Iterator[tuple[str, int, float, str, float, float]]:
    """Block, channel, resting drive, and for each of its limits: name, value and distance."""
    limited = [(node.name, form.least, form.greatest) for node, form in loop.blocks
               if form.least is not None and form.greatest is not None]
    outputs = rest_of(loop) if limited else None
    for name, least, greatest in limited if outputs else ():
        assert outputs is not None
        for channel, value in enumerate(outputs[name]):
            yield name, channel, value, "lower", least[channel], value - least[channel]
            yield name, channel, value, "upper", greatest[channel], greatest[channel] - value


def rest_of(loop: LinearLoop) -> dict[str, Array] | None:
    """Outputs of each block at rest, by name.

    None where the loop has no rest, or where an input from outside the loop is not known.
    """
    plant, total = loop.plant_form, 0
    states, outputs = {}, {}

    def rows(size: int) -> slice:
        nonlocal total
        total += size
        return slice(total - size, total)

    states[loop.plant.name] = rows(len(plant.a))
    for node, form in loop.blocks:
        states[node.name], outputs[node.name] = rows(len(form.a)), rows(len(form.c))
    # Each row of a signal has the coefficients of the unknowns, and a constant in the last column.
    one = np.eye(total + 1)
    here = one[states[loop.plant.name]]
    measured = plant.c @ here
    measured[:, -1] += 0.0 if plant.offset is None else plant.offset
    signals = {loop.plant.name: measured} | {name: one[where] for name, where in outputs.items()}
    into = {(c.target.name, c.target.part.inputs[c.target_port].name): signals[c.source.name]
            for c in loop.connections}
    equations = [_moves(plant.a, here, plant.b @ into[loop.plant.name, plant.input], plant.b)]
    for node, form in loop.blocks:
        ports = {port.name: port for port in node.part.inputs}
        read = []
        for name in form.inputs:
            if (node.name, name) in into:
                read.append(into[node.name, name])
            elif (node.name, name) in loop.given:
                constant = loop.given[node.name, name]
                read.append(np.outer(constant, one[-1]))
            else:
                return None
            if len(read[-1]) != numbers_of(ports[name]):
                return None
        given, here = np.concatenate(read), one[states[node.name]]
        residual = form.c @ here + form.d @ given - one[outputs[node.name]]
        residual[:, -1] += 0.0 if form.offset is None else form.offset
        equations += [_moves(form.a - np.eye(len(form.a)), here, form.b @ given, form.b), residual]
    return _solved(np.concatenate(equations), outputs)


def _moves(a: Array, here: Array, driven: Array, b: Array) -> Array:
    """Rows that are zero at rest, one per state; a state that nothing moves stays at 0."""
    still = ~(a.any(axis=1) | b.any(axis=1))
    moves = a @ here + driven
    moves[still] = here[still]
    return moves


def _solved(equations: Array, outputs: dict[str, slice]) -> dict[str, Array] | None:
    matrix, constant = equations[:, :-1], -equations[:, -1]
    scale = np.abs(equations).max(axis=1)
    scale[scale == 0.0] = 1.0
    matrix, constant = matrix / scale[:, None], constant / scale
    found = np.linalg.lstsq(matrix, constant)[0]
    largest = max(np.abs(matrix * found).max(initial=0.0), np.abs(constant).max(initial=0.0))
    if not np.abs(matrix @ found - constant).max(initial=0.0) <= _ROUNDING * largest:
        return None
    return {name: found[where] for name, where in outputs.items()}


def _shown(value: float) -> str:
    return f"{value if abs(value) > _ROUNDING else 0.0:.3g}"


def _not_covered(block: str, found: str) -> InputError:
    return InputError(block, f"{found}: not covered",
                      "drives that rest within their limits, for the theory of a linear loop",
                      "change the rest of the loop (a bias, another reference), or reduce the noise")
