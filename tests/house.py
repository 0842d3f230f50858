"""Prints how big the library is, how its modules depend on each other, and what a run loads.

    python tests/house.py

Exits with 1 where modules import each other in a circle (imports for types alone included), where one imports
from a storey above its own, where a run loads too many modules, or where the shipped hand experiments grow.
"""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("fesloop", "plants", "estimators", "controllers")
MOST_LOADED, MOST_HAND_LINES = 130, 1030
RUN = ("run", "grasp_ilc", "--set", "trials=1")
HAND = ("parts/hand_rig", "parts/grasp", "grasp_ilc", "grasp_mpc", "hold_grip_force", "identify_grasp",
        "open_close_ilc", "pinch_mpc")


def modules(root: Path = ROOT) -> dict[str, Path]:
    """Every module of the library, by dotted name."""
    found = {}
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(known: Mapping[str, Path]) -> dict[str, set[str]]:
    """What each module imports of the others, wherever in it, for types alone included."""
    return {name: set(_imported(path, known)) - {name} for name, path in known.items()}


def _imported(path: Path, known: Mapping[str, Path]) -> Iterable[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                if full in known:
                    yield full
                elif node.module in known:
                    yield node.module


def circles(graph: Mapping[str, set[str]]) -> list[list[str]]:
    """Groups of modules that reach each other."""
    reached = {name: _reach(name, graph) for name in graph}
    groups = {frozenset({name} | {other for other in reached[name] if name in reached[other]})
              for name in graph if name in reached[name]}
    return sorted(sorted(group) for group in groups)


def _reach(start: str, graph: Mapping[str, set[str]]) -> set[str]:
    reached: set[str] = set()
    ways = [start]
    while ways:
        ways += (further := graph[ways.pop()] - reached)
        reached |= further
    return reached


def storeys(root: Path = ROOT) -> list[set[str]]:
    """The rooms of each storey, lowest first, as the import contract "storeys" has them."""
    table = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    contract = next(c for c in table["tool"]["importlinter"]["contracts"] if c["name"] == "storeys")
    return [{room.strip() for room in layer.split("|")} for layer in reversed(contract["layers"])]


def upward(graph: Mapping[str, set[str]], rooms: list[set[str]]) -> list[tuple[str, str]]:
    """Imports from a storey above the importer's own."""
    def storey(name: str) -> int | None:
        return next((i for i, layer in enumerate(rooms)
                     for room in layer if name == room or name.startswith(f"{room}.")), None)

    level = {name: storey(name) for name in graph}
    found = []
    for name, targets in graph.items():
        here = level[name]
        found += [(name, target) for target in sorted(targets)
                  if here is not None and (there := level[target]) is not None and there > here]
    return found


def loaded_by_a_run() -> int:
    """How many modules of the library `fesloop run grasp_ilc` loads, but for packages that hold no code."""
    code = ("import sys, tempfile; from fesloop.apps.cli import main\n"
            "with tempfile.TemporaryDirectory() as folder:\n"
            f"    try: main([*{RUN!r}, '--out', folder])\n"
            "    except SystemExit: pass\n"
            "print(*sys.modules)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    known = modules()
    return sum(holds_code(known[name]) for name in done.stdout.splitlines()[-1].split() if name in known)


def holds_code(path: Path) -> bool:
    """Whether a module holds more than a docstring."""
    body = ast.parse(path.read_text(encoding="utf-8")).body
    return len(body) > 1 or (len(body) == 1 and not isinstance(body[0], ast.Expr))


def lines(paths: Iterable[Path]) -> int:
    """Lines of files together."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in paths)


def main() -> int:
    """Print the table; 1 if a limit is passed."""
    known = modules()
    graph = imports(known)
    rooms = {name if "." not in name else name.split(".")[0] if name.split(".")[0] != "fesloop"
             else ".".join(name.split(".")[:2]) for name in known}
    for package in sorted(rooms):
        inside = [path for name, path in known.items() if f"{name}.".startswith(f"{package}.")]
        if len(inside) > 1 and package != "fesloop":
            coded = sum(map(holds_code, inside))
            print(f"{package:24} {lines(inside):6} lines {coded:4} modules")
    filled = [path for path in known.values() if holds_code(path)]
    print(f"{'library':24} {lines(filled):6} lines {len(filled):4} modules")
    shipped = ROOT / "fesloop" / "experiment" / "shipped"
    hand = lines(shipped / f"{name}.toml" for name in HAND)
    round_about, up, loaded = circles(graph), upward(graph, storeys()), loaded_by_a_run()
    print(f"circles {len(round_about)}, upward arrows {len(up)}")
    for group in round_about:
        print("  circle:", ", ".join(group))
    for low, high in up:
        print(f"  upward: {low} -> {high}")
    print(f"modules that `fesloop {' '.join(RUN[:2])}` loads: {loaded} (at most {MOST_LOADED})")
    print(f"lines of the shipped hand experiments: {hand} (at most {MOST_HAND_LINES})")
    return int(bool(round_about or up) or loaded > MOST_LOADED or hand > MOST_HAND_LINES)


if __name__ == "__main__":
    sys.exit(main())
