"""Draw the worked example of time.md as an SVG: `time_line.py TARGET`."""

import re
import sys
import tomllib
from html import escape
from pathlib import Path

from fesloop import Loop
from fesloop.experiment.files.parse import from_document
from fesloop.loop.latency import TickLatency

PAGE = Path(__file__).resolve().parents[1] / "time.md"
SAMPLES = 9
LANES = ("finger", "tracker", "controller", "stimulation")
LEFT, TOP, PER_MS, LANE = 96.0, 34.0, 5.4, 52.0
STYLE = """text { font: 13px sans-serif; fill: #24292f } .small { font-size: 11px }
line, path { stroke: #57606a; fill: none } .grid { stroke: #d0d7de }
.acts { stroke: #0072b2; stroke-width: 2.5 }
.lost { stroke-dasharray: 3 3 } circle { fill: #57606a } circle.acts { fill: #0072b2; stroke: none }
@media (prefers-color-scheme: dark) { text { fill: #e6edf3 } line, path { stroke: #8d96a0 }
.grid { stroke: #3d444d } .acts { stroke: #56b4e9 }
circle { fill: #8d96a0 } circle.acts { fill: #56b4e9 } }"""


def ways() -> dict[int, TickLatency | None]:
    """Samples of the page's loop by their number, None for those that never act."""
    text = re.search(r"^`loop.toml`\n\n```toml\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    assert text is not None, "time.md has no loop.toml"
    report = Loop(from_document(tomllib.loads(text[1])).wiring).latency_report()
    path = report.path("finger.angles", "finger.stimulation")
    return {k: path.of_tick(k) for k in range(SAMPLES)}


def at(ms: float, lane: int) -> tuple[float, float]:
    """Place of an instant on a lane."""
    return LEFT + PER_MS * ms, TOP + LANE * lane


def line(kind: str, *points: tuple[float, float]) -> str:
    """A line through points."""
    return f'<path class="{kind}" d="M{" L".join(f"{x:.1f},{y:.1f}" for x, y in points)}"/>'


def dot(kind: str, point: tuple[float, float]) -> str:
    """A dot."""
    return f'<circle class="{kind}" cx="{point[0]:.1f}" cy="{point[1]:.1f}" r="4"/>'


def of_sample(captured: float, way: TickLatency | None) -> list[str]:
    """Lines of a sample's way to the stimulation, or to the instant of its loss."""
    if way is None:
        return [line("lost", at(captured, 0), at(captured + 2.0, 1), at(captured + 14.0, 2)),
                dot("lost", at(captured, 0))]
    acts = 1e-6 * way.acts_ns
    read = acts - 1e-6 * way.stages_ns[-1]
    waits = read - 1e-6 * way.stages_ns[4]
    return [line("acts", at(captured, 0), at(captured + 2.0, 1), at(waits, 2), at(read, 2), at(acts, 3)),
            dot("acts", at(captured, 0)), dot("acts", at(acts, 3))]


def drawing() -> str:
    """The drawing."""
    end_ms, rows = 110.0, []
    width, height = LEFT + PER_MS * end_ms + 20.0, TOP + LANE * 3 + 44.0
    for lane, name in enumerate(LANES):
        rows += [line("grid", at(0.0, lane), at(end_ms, lane)),
                 f'<text x="8" y="{at(0.0, lane)[1] + 4:.1f}">{escape(name)}</text>']
    for ms in range(0, 101, 25):
        (x, top), (_, bottom) = at(ms, 0), at(ms, 3)
        rows += [line("grid", (x, top), (x, bottom)),
                 f'<text class="small" x="{x:.1f}" y="{bottom + 24:.1f}" text-anchor="middle">{ms} ms</text>']
    for number, way in ways().items():
        rows += of_sample(10.0 * number, way)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" role="img">\n'
            f"<title>Samples on their way from the finger to the stimulation that acts</title>\n"
            f"<style>{STYLE}</style>\n" + "\n".join(rows) + "\n</svg>\n")


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(drawing())
