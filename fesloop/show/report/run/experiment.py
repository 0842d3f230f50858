"""Section of a report on the experiment: its wiring as drawing and tables, and resolved parameters."""


from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from fesloop.experiment.specification import with_transport
from fesloop.forms.toml import toml_text
from fesloop.loop.duration import Duration
from fesloop.show.report import svg
from fesloop.show.report.parts import Code, Drawing, Fold, Notice, Paragraph, Part, Section, Table
from fesloop.show.report.run.known import Known
from fesloop.show.report.run.words import counted

_LONGEST = 200_000
"""Characters of the experiment in the page (chosen: tables of measured numbers go on for megabytes)."""


def experiment_section(known: Known) -> Section:
    """Section made from the tables in the recording, which need no installed kinds."""
    tables = known.recording.experiment
    about = tables.get("experiment", {}).get("description", "")
    parts: list[Part] = [Paragraph(text=about)] if about else []
    return Section(key="experiment", title="Experiment", parts=[*parts, *_parts(known, tables)])


def _parts(known: Known, tables: Mapping[str, Any]) -> Iterator[Part]:
    blocks = tables.get("blocks", {})
    wires = [with_transport(wire, tables) for wire in tables.get("wires", [])]
    rates = {name: _rate(known, name, table) for name, table in blocks.items()}
    if blocks:
        yield Drawing(key="wiring", title="Blocks with rates, wires with latencies",
                      svg=wiring_svg(blocks, wires, rates),
                      text=f"{counted(len(blocks), 'block')} joined by {counted(len(wires), 'wire')}; the "
                      "tables below say the same.")
        yield Fold(title=f"{counted(len(blocks), 'block')} and {counted(len(wires), 'wire')}", parts=[
            Table(title="Blocks", columns=["block", "kind", "ticks"],
                  rows=[[name, str(table.get("kind", "")), rates[name]] for name, table in blocks.items()]),
            Table(title="Wires", columns=["from", "to", "latency", "loss", "late messages"],
                  rows=[_wire_row(wire) for wire in wires])])
    yield from _resolved(tables)
    versions = known.recording.versions
    yield Fold(title="Versions and identity", parts=[Table(columns=["", ""], rows=[
        *([name, version] for name, version in versions.items()),
        ["fingerprint of the experiment", known.recording.fingerprint],
        ["command that repeats the run", f"fesloop run {known.recording.path.name}"]])])


def _rate(known: Known, name: str, table: Mapping[str, Any]) -> str:
    """Rate of a block in words, from its clock or else from its table."""
    if known.experiment is not None:
        node = known.experiment.wiring.node(name)
        if node.is_plant:
            return f"steps at {node.plant.grid}" if node.plant.grid else "continuous"
        return str(node.clock).rpartition("stamps, ")[2]
    if "rate" in table:
        return f"{table['rate']} Hz"
    if "clock" in table:
        return f"with {table['clock']}"
    return "continuous" if is_plant(table) else "its own clock"


def _varies(jitter: Mapping[str, Any]) -> bool:
    """Whether a wire's jitter adds anything."""
    return any(jitter.get(key) for key in _JITTERS)


def _wire_row(wire: Mapping[str, Any]) -> list[str]:
    jitter = wire.get("jitter", {"kind": "zero"})
    varies = f" + {jitter['kind']} jitter of {Duration(**jitter)}" if _varies(jitter) else ""
    burst = wire.get("burst_messages")
    bursts = f" in bursts of {burst:g}" if burst else ""
    return [wire["from"], wire["to"], f"{wire.get('latency_ms', 0.0):g} ms{varies}",
            f"{100.0 * wire['loss']:g} %{bursts}" if wire.get("loss") else "-", str(wire.get("late", ""))]


def _resolved(tables: Mapping[str, Any]) -> Iterator[Part]:
    """Fold with the experiment as TOML."""
    text = toml_text(without_none(tables))
    shown = text if len(text) <= _LONGEST else text[:text.rindex("\n", 0, _LONGEST) + 1]
    parts: list[Part] = [Code(text=shown)]
    if len(shown) < len(text):
        parts.append(Notice(text=f"{len(text) - len(shown)} characters of the experiment are omitted here; "
                            "the recording contains them."))
    yield Fold(title="Experiment with all parameters resolved", parts=parts)


def without_none(value: Any) -> Any:
    """Tables and lists without `None`, which TOML cannot express."""
    if isinstance(value, Mapping):
        return {key: without_none(item) for key, item in value.items() if item is not None}
    if isinstance(value, (list, tuple)):
        return [without_none(item) for item in value if item is not None]
    return value


_COMMAND = "stimulation"
"""Name of the ports by which stimulation is commanded, forwarded and received."""


@dataclass(frozen=True, slots=True)
class Columns:
    """Names of blocks: `down` in the order in which commands pass them, `up` in that of measurements."""

    down: tuple[str, ...]
    up: tuple[str, ...]


def columns(blocks: Mapping[str, Any], wires: Sequence[Mapping[str, Any]]) -> Columns:
    """Both ways of an experiment, from its tables alone; every block is in one of them.

    Plants, and what lies between the first that asks for stimulation and them, are on the way down; so is
    what nothing is wired to and which leads there at once, such as a reference. All else is on the way up.
    """
    pairs = list(dict.fromkeys((_node(wire["from"]), _node(wire["to"])) for wire in wires))
    plants = {name for name, table in blocks.items() if is_plant(table)}
    askers = [name for name in blocks if _asks(name, wires)]
    passed = _reached(askers, pairs, plants) | plants
    heard = {target for _, target in pairs}
    sources = [name for name in blocks if name not in passed and name not in heard
               and all(target in passed for source, target in pairs if source == name)]
    down = [*sources, *_in_order([name for name in blocks if name in passed], pairs, askers)]
    rest = [name for name in blocks if name not in down]
    starts = [target for source, target in pairs if source in plants and target in rest]
    return Columns(tuple(down), tuple(_in_order(rest, pairs, starts)))


def is_plant(table: Mapping[str, Any]) -> bool:
    """Return whether a resolved table describes a plant, which has no execution time."""
    return "execution" not in table


def _node(end: str) -> str:
    return end.partition(".")[0]


def _asks(name: str, wires: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether a block generates its own stimulation."""
    gives = any(wire["from"] == f"{name}.{_COMMAND}" for wire in wires)
    return gives and not any(wire["to"] == f"{name}.{_COMMAND}" for wire in wires)


def _reached(starts: Sequence[str], pairs: Sequence[tuple[str, str]], plants: Collection[str]) -> set[str]:
    """Blocks that commands reach, up to the first plant."""
    found, left = set(starts), list(starts)
    while left:
        name = left.pop()
        if name in plants:
            continue
        fresh = {target for source, target in pairs if source == name} - found
        found |= fresh
        left += fresh
    return found


def _in_order(names: Sequence[str], pairs: Sequence[tuple[str, str]], starts: Sequence[str]) -> list[str]:
    """Names by how far they are from the starts, the longest way counting; ties as they were declared."""
    depth: dict[str, int] = {}

    def visit(name: str, far: int, way: tuple[str, ...]) -> None:
        if name in way or depth.get(name, -1) >= far:
            return
        depth[name] = far
        for source, target in pairs:
            if source == name and target in names:
                visit(target, far + 1, (*way, name))

    for name in [*starts, *names]:
        if name in names and name not in depth:
            visit(name, 0, ())
    return sorted(names, key=lambda name: depth[name])


_WIDE, _HIGH, _PITCH = 146.0, 40.0, 62.0
"""Width and height of a block, and vertical distance between blocks (chosen)."""
_GUTTER, _BETWEEN = 40.0, 98.0
"""Room beside the columns, and between them."""
_LANE, _LETTER, _LINE = 8.0, 5.6, 12.0
"""Distance between parallel wires; width of a letter and height of a line of a label."""
_MOST_LETTERS = 25
_JITTERS = ("ms", "low_ms", "high_ms", "mean_ms", "sd_ms")
"""Keys of a duration; if all are zero there is no jitter."""
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class _Way:
    """Wire, or several between the same blocks: points of its path, label, tooltip and side."""

    points: tuple[Point, ...]
    label: tuple[str, ...]
    told: str
    side: str


def wiring_svg(blocks: Mapping[str, Any], wires: Sequence[Mapping[str, Any]],
               rates: Mapping[str, str]) -> str:
    """SVG of the wiring, for narrow and wide pages; `rates`: rate of each block in words."""
    placed = columns(blocks, wires)
    rows = max(len(placed.down), len(placed.up), 1)
    height = _PITCH * rows
    right = _GUTTER + _WIDE + _BETWEEN
    downs, ups = _spread(len(placed.down), height), reversed(_spread(len(placed.up), height))
    corners = {name: (_GUTTER, y) for name, y in zip(placed.down, downs, strict=True)}
    corners |= {name: (right, y) for name, y in zip(placed.up, ups, strict=True)}
    ways = _ways(placed.down, placed.up, corners, _joined(wires))
    pieces = [*(piece for way in ways for piece in _drawn_way(way)),
              *(piece for name, corner in corners.items()
                for piece in _drawn_block(name, blocks[name], rates.get(name, ""), corner)),
              *_labels(ways)]
    return svg.drawing(right + _WIDE + _GUTTER, height, pieces)


def _spread(count: int, height: float) -> list[float]:
    """Upper edges of `count` blocks spread evenly over a height."""
    pitch = height / max(count, 1)
    return [pitch * (number + 0.5) - 0.5 * _HIGH for number in range(count)]


def _joined(wires: Sequence[Mapping[str, Any]]) -> dict[tuple[str, str], list[Mapping[str, Any]]]:
    """Wires grouped by the pair of blocks that they join."""
    found: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for wire in wires:
        ends = wire["from"].partition(".")[0], wire["to"].partition(".")[0]
        found.setdefault(ends, []).append(wire)
    return found


def _ways(down: Sequence[str], up: Sequence[str], corners: Mapping[str, Point],
          joined: Mapping[tuple[str, str], list[Mapping[str, Any]]]) -> list[_Way]:
    """Paths of wires: straight to the next block, beside a column to others, across between columns."""
    ends = _Ends(corners)
    next_ones = {*pairwise(down), *pairwise(up)}
    lanes: dict[str, list[tuple[float, float, int]]] = {"left": [], "right": []}
    found = []
    for (source, target), wires in sorted(joined.items(), key=lambda item: _length(item[0], corners)):
        label, words = _label(wires), _tooltip(wires)
        if source not in corners or target not in corners:
            continue
        if (source, target) in next_ones:
            found.append(_Way(_straight(corners[source], corners[target]), label, words, "beside"))
        elif corners[source][0] == corners[target][0]:
            side = "left" if source in down else "right"
            start, end = ends.take(source, side), ends.take(target, side)
            lane = _free_lane(lanes[side], start[1], end[1])
            x = start[0] + (_LANE * (1 + lane) if side == "right" else -_LANE * (1 + lane))
            found.append(_Way((start, (x, start[1]), (x, end[1]), end), label, words, side))
        else:
            inner = ("right", "left") if source in down else ("left", "right")
            start, end = ends.take(source, inner[0]), ends.take(target, inner[1])
            found.append(_Way((start, end), label, words, "across"))
    return found


def _length(pair: tuple[str, str], corners: Mapping[str, Point]) -> float:
    """Vertical length of a wire; short wires get the inner lanes."""
    return abs(corners[pair[0]][1] - corners[pair[1]][1]) if set(pair) <= corners.keys() else 0.0


class _Ends:
    """Points on the sides of blocks at which wires end; each is used once."""

    def __init__(self, corners: Mapping[str, Point]) -> None:
        self._corners = corners
        self._taken: dict[tuple[str, str], int] = {}

    def take(self, name: str, side: str) -> Point:
        """Next free point on a side, from its middle outwards."""
        number = self._taken.get((name, side), 0)
        self._taken[name, side] = number + 1
        away = (number + 1) // 2 * _LANE * (1 if number % 2 else -1)
        x, y = self._corners[name]
        return x + (_WIDE if side == "right" else 0.0), y + 0.5 * _HIGH + max(min(away, 17.0), -17.0)


def _straight(source: Point, target: Point) -> tuple[Point, ...]:
    middle = source[0] + 0.5 * _WIDE
    if target[1] > source[1]:
        return (middle, source[1] + _HIGH), (middle, target[1])
    return (middle, source[1]), (middle, target[1] + _HIGH)


def _free_lane(taken: list[tuple[float, float, int]], start: float, end: float) -> int:
    """Innermost lane that is free between two heights; marks it as taken."""
    low, high = min(start, end), max(start, end)
    busy = {lane for first, last, lane in taken if first <= high and low <= last}
    lane = next(number for number in range(len(taken) + 1) if number not in busy)
    taken.append((low, high, lane))
    return lane


def _label(wires: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Lines of a wire's label: greatest latency, jitter and loss of the wires that it joins."""
    wire = max(wires, key=lambda each: float(each.get("latency_ms", 0.0)))
    lines = [f"{wire['latency_ms']:g} ms"] if wire.get("latency_ms") else []
    if any(_varies(each.get("jitter", {})) for each in wires):
        lines.append("+ jitter")
    loss = max(float(each.get("loss", 0.0)) for each in wires)
    return (*lines, f"{100.0 * loss:g} % lost") if loss else tuple(lines)


def _tooltip(wires: Sequence[Mapping[str, Any]]) -> str:
    """Tooltip of a wire: the ports that it joins."""
    return "; ".join(f"{wire['from']} to {wire['to']}" for wire in wires)


def _drawn_way(way: _Way) -> Iterator[str]:
    yield svg.polyline(way.points, "stroke-plain", width=1.4, tooltip=way.told)
    yield svg.arrow_head(way.points[-2], way.points[-1], "fill-plain")


def _drawn_block(name: str, table: Mapping[str, Any], rate: str, corner: Point) -> Iterator[str]:
    x, y = corner
    kind = str(table.get("kind", ""))
    below = " · ".join(part for part in (kind if kind != name else "", rate) if part)
    yield svg.rect(x, y, _WIDE, _HIGH, "paper stroke-plain", radius=6.0, tooltip=f"{name}: {kind}, {rate}")
    yield svg.text(x + 0.5 * _WIDE, y + (17.0 if below else 24.0), _cut(name), size=13.0, anchor="middle",
                   bold=True)
    if below:
        yield svg.text(x + 0.5 * _WIDE, y + 32.0, _cut(below), kind="faint", size=11.0, anchor="middle")


def _cut(words: str) -> str:
    return words if len(words) <= _MOST_LETTERS else f"{words[:_MOST_LETTERS - 1]}…"


def _labels(ways: Sequence[_Way]) -> Iterator[str]:
    """Labels of wires, each placed where it overlaps earlier ones least."""
    taken: list[tuple[float, float, float, float]] = []
    for way in ways:
        if not way.label:
            continue
        wide, high = _LETTER * max(map(len, way.label)) + 4.0, _LINE * len(way.label) + 2.0
        boxes = [(x - 0.5 * wide, y - 0.5 * high, wide, high) for x, y in _spots(way, wide)]
        box = min(boxes, key=lambda each: sum(_shared(each, other) for other in taken))
        taken.append(box)
        yield svg.rect(*box, "paper", radius=2.0)
        for number, line in enumerate(way.label):
            yield svg.text(box[0] + 0.5 * wide, box[1] + _LINE * (number + 0.85), line, size=10.5,
                           anchor="middle")


def _spots(way: _Way, wide: float) -> Iterator[Point]:
    """Candidate centres of a label, the best first."""
    if way.side == "beside":
        (x, start), (_, end) = way.points
        yield x + 0.5 * wide + 4.0, 0.5 * (start + end)
        return
    (x0, y0), (x1, y1) = (way.points[0], way.points[-1]) if way.side == "across" else way.points[1:3]
    beside = _GUTTER - 0.5 * wide - 1.0
    total = 2.0 * (_GUTTER + _WIDE) + _BETWEEN
    for share in (0.5, 0.35, 0.65, 0.25, 0.75):
        x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
        if way.side == "left":
            yield max(min(x, beside), 0.5 * wide), y
        elif way.side == "right":
            yield min(max(x, total - beside), total - 0.5 * wide), y
        else:
            yield x, y


def _shared(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> float:
    """Area that two boxes share."""
    wide = min(one[0] + one[2], other[0] + other[2]) - max(one[0], other[0])
    high = min(one[1] + one[3], other[1] + other[3]) - max(one[1], other[1])
    return max(wide, 0.0) * max(high, 0.0)
