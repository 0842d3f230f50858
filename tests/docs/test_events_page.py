"""docs/events.md has a row for every status that the source can report, and for no other."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from fesloop.apps.cli import main
from fesloop.experiment.recording.reading import Recording

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/events.md"
ROOMS = ("controllers", "estimators", "plants", "fesloop")
SECTIONS = {
    "controllers/safety.py": "Safety",
    "plants/stimulator.py": "Stimulator and devices",
    "plants/devices/": "Stimulator and devices",
    "plants/electrodes/": "Electrodes and muscles",
    "plants/muscles/": "Electrodes and muscles",
    "plants/intention/": "A person's intention",
    "plants/imus/": "Sensors on the hand",
    "plants/fmu/": "FMUs",
    "plants/force_sensors.py": "Sensors on the hand",
    "estimators/emg_effort.py": "A person's intention",
    "estimators/": "Trackers and calibration",
    "controllers/open_loop/": "Sweep over elements",
    "controllers/pid/": "PID",
    "controllers/ilc/": "Iterative learning (ILC)",
    "controllers/trajectories.py": "Iterative learning (ILC)",
    "controllers/progress.py": "Iterative learning (ILC)",
    "controllers/mpc/": "Predictive control (MPC)",
    "controllers/reach.py": "Targets out of reach",
    "controllers/quadratic_programme.py": "Quadratic programmes",
    "controllers/grip.py": "Grip force",
    "controllers/point_search/": "Point search",
    "controllers/reference/triggered.py": "A person's intention",
    "controllers/reference/proportional.py": "A person's intention",
    "controllers/reference/intended.py": "A person's intention",
    "controllers/reference/": "References",
    "fesloop/streams/blocks/": "Streams, recorded and live",
    "fesloop/streams/doubts.py": "Streams, recorded and live",
    "fesloop/streams/live/": "Streams, recorded and live",
    "fesloop/loop/": "Loop and wires",
}
"""Heading of the page under which the statuses of a file stand."""
_QP = ("controllers/quadratic_programme.py:_DAQP", "controllers/quadratic_programme.py:_OSQP",
       "controllers/quadratic_programme.py:solve", "controllers/quadratic_programme.py:_solve",
       "controllers/quadratic_programme.py:solve_sparse")
_DEVICE_LIMITS = ("plants/stimulator.py:LIMITED",)
_STOPPED = ("plants/devices/driver.py:FAULTS", "plants/devices/kept_device.py:_read")
INDIRECT = {
    ("controllers/grip.py", "status"): ("controllers/grip.py:_TROUBLES",),
    ("controllers/ilc/block.py", "*report"): (
        "controllers/ilc/convergence.py:cautions", "controllers/ilc/block.py:next_trial",
        "controllers/trajectories.py:explained", "controllers/ilc/laws.py:_learnt",
        "controllers/progress.py:note", *_QP),
    ("controllers/mpc/block.py", "*report"): ("controllers/progress.py:note",),
    ("controllers/mpc/state.py", "trouble"): (
        "controllers/mpc/block.py:step", "controllers/mpc/block.py:_control", *_QP),
    ("controllers/pid/tuned.py", "trouble"): ("controllers/pid/tuned.py:step", *_QP),
    ("controllers/point_search/block.py", "status"): (
        "controllers/point_search/block.py:_hear", "controllers/point_search/block.py:_ask"),
    ("controllers/safety.py", "trouble[0]"): (
        "controllers/safety.py:_trouble", "controllers/safety.py:_present",
        "controllers/safety.py:_plausible"),
    ("controllers/safety.py", "status"): ("controllers/safety.py:LIMITED",),
    ("estimators/constrained/block.py", "event"): (
        "estimators/constrained/block.py:report", "estimators/constrained/block.py:report_misfits"),
    ("estimators/constrained/block.py", "status"): ("estimators/constrained/lateness.py:look",),
    ("estimators/kortier/tick.py", "status"): ("estimators/kortier/tick.py:report_unseen",),
    ("estimators/salchow/fusion.py", "status"): ("estimators/salchow/fusion.py:_report_unseen",),
    ("estimators/arrivals.py", "status"): ("estimators/arrivals.py:_report",),
    ("plants/devices/keeper.py", "fault.status"): _STOPPED,
    ("plants/devices/stimulator_device.py", "status"): _DEVICE_LIMITS,
    ("plants/stimulator.py", "status"): _DEVICE_LIMITS,
    ("fesloop/loop/assembly.py", "status"): (),  # what blocks have reported
    ("fesloop/loop/record.py", "status"): (),  # what is put
    ("fesloop/streams/blocks/replay.py", "self._reports()"): (
        "fesloop/streams/blocks/replay.py:_reports", "fesloop/streams/doubts.py:_doubts"),
    ("fesloop/streams/live/inlet.py", "note.status"): (
        "fesloop/streams/live/reader.py:judge", "fesloop/streams/live/reader.py:_doubts",
        "fesloop/streams/live/reader.py:note", "fesloop/streams/live/reader.py:attach",
        "fesloop/streams/live/reader.py:hear", "fesloop/streams/live/reader.py:_look_for_it"),
}
"""Where a status that is reported by an expression is written: "file:function or constant"."""
_REPORTS = re.compile(r"report\(|_latch\(|\.put\(|reports\.extend|events\.append|def cautions")
_STATUS = re.compile(r"[a-z]+(_[a-z]+)*")
_NOT_REPORTED = {"solved", "kept", "max_gap_ms", "q", "lower", "upper", "lam", "iterations", "status",
                 "detail"}
"""Other strings of the same form in these places."""


@cache
def tree_of(name):
    return ast.parse((ROOT / name).read_text())


def written(node):
    """Strings in a piece of source that have the form of a status, but for docstrings and comparisons."""
    if isinstance(node, ast.Constant):
        return {node.value} if isinstance(node.value, str) and _STATUS.fullmatch(node.value) else set()
    if isinstance(node, ast.Compare | ast.JoinedStr | ast.Raise) or (
            isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
        return set()
    return set().union(*map(written, ast.iter_child_nodes(node)))


def is_literal(expression):
    """Whether `written` finds every status that an expression can be."""
    if isinstance(expression, ast.IfExp):
        return is_literal(expression.body) and is_literal(expression.orelse)
    return isinstance(expression, ast.Constant) and bool(written(expression))


def written_at(place):
    """Those of each function or constant of a file that has the name."""
    name, _, wanted = place.partition(":")
    found = []
    for node in ast.walk(tree_of(name)):
        named = [node.name] if isinstance(node, ast.FunctionDef) else \
            [each.id for each in node.targets if isinstance(each, ast.Name)] if isinstance(node, ast.Assign) \
            else []
        if wanted in named:
            body = node.body if isinstance(node, ast.FunctionDef) else [node.value]
            found.append(set().union(*map(written, body)))
    assert found, f"{place}: is not there; INDIRECT names it"
    return set().union(*found) - _NOT_REPORTED


def reported(call):
    """The expression of the status that a call reports, None for any other call."""
    if not isinstance(call.func, ast.Attribute) or not call.args:
        return None
    owner, name = ast.unparse(call.func.value), call.func.attr
    first = call.args[0]
    if name in ("report", "_latch"):
        return first
    if name == "put" and ast.unparse(first) == "tick":
        return call.args[1]
    if name == "extend" and owner.endswith("tick.reports"):
        return first
    if name == "append" and owner.endswith("events") and isinstance(first, ast.Tuple):
        return first.elts[2]
    return None


def sources():
    return [str(path.relative_to(ROOT)) for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]


def pairs(name):
    """Statuses beside a detail in words, ("status", "in words ..."), wherever a file has them.

    Rows of `fesloop check`, of functions `of_arrays`, look like them.
    """
    rows = {id(each) for node in ast.walk(tree_of(name))
            if isinstance(node, ast.FunctionDef) and node.name == "of_arrays" for each in ast.walk(node)}
    for node in ast.walk(tree_of(name)):
        if isinstance(node, ast.Tuple) and id(node) not in rows:
            for first, second in zip(node.elts, node.elts[1:], strict=False):
                words = isinstance(second, ast.JoinedStr) or (
                    isinstance(second, ast.Constant) and " " in str(second.value))
                if words and is_literal(first):
                    yield from written(first) - _NOT_REPORTED


def sites():
    """(file, expression) of every status that is reported, and of every function that gives cautions."""
    for name in sources():
        for node in ast.walk(tree_of(name)) if _REPORTS.search((ROOT / name).read_text()) else ():
            if isinstance(node, ast.Call) and (status := reported(node)) is not None:
                yield name, status
            elif isinstance(node, ast.FunctionDef) and node.name == "cautions":
                yield from ((name, ast.Constant(status)) for status in written_at(f"{name}:cautions"))


def section_of(name):
    headings = [heading for start, heading in SECTIONS.items() if name.startswith(start)]
    assert headings, f"{name} reports a status: give it a section in docs/events.md, named in SECTIONS"
    return headings[0]


@cache
def in_the_source():
    """(section, status) of all that can be reported."""
    found = set()
    for name, status in sites():
        if is_literal(status):
            found |= {(section_of(name), each) for each in written(status)}
            continue
        key = name, ast.unparse(status)
        assert key in INDIRECT, f"{name} reports `{key[1]}`: say in INDIRECT where its statuses are written"
        for place in INDIRECT[key]:
            found |= {(section_of(place), each) for each in written_at(place)}
    for name in sources():
        if name.startswith(tuple(SECTIONS)):
            found |= {(section_of(name), each) for each in pairs(name)}
    return found


@cache
def on_the_page():
    """(section, status) of all rows, each with its cells."""
    rows, heading = {}, ""
    for line in PAGE.read_text().splitlines():
        if line.startswith("#"):
            heading = line.lstrip("# ")
        elif line.startswith("| `"):
            status, *cells = (cell.strip() for cell in line.strip("|").split("|"))
            key = heading, status.strip("`")
            assert key not in rows, f"{key} has two rows"
            rows[key] = cells
    return rows


@pytest.mark.slow
def test_every_status_of_the_source_has_a_row():
    assert len(in_the_source()) > 100
    assert in_the_source() - set(on_the_page()) == set()


def test_every_row_is_of_a_status_of_the_source():
    assert set(on_the_page()) - in_the_source() == set()


def test_every_row_says_what_it_means_how_grave_it_is_and_what_to_do():
    for key, (meaning, kind, what_to_do) in on_the_page().items():
        assert meaning.endswith("."), key
        assert kind.split()[0].rstrip(";,") in ("normal", "look", "fault"), key
        assert what_to_do.endswith("."), key


def test_what_is_said_to_be_reported_indirectly_is():
    assert set(INDIRECT) <= {(name, ast.unparse(status)) for name, status in sites()}


@pytest.mark.parametrize(("experiment", "duration_s"), [("finger_mpc", 1.5), ("open_close", 2)])
def test_events_of_a_run_have_rows_and_its_summary_names_the_page(capsys, tmp_path, experiment, duration_s):
    assert main(["run", experiment, "--set", f"experiment.duration_s={duration_s}",
                 "--out", str(tmp_path)]) == 0
    said = capsys.readouterr()
    with Recording(said.out.strip()) as recording:
        found = {event.status for event in recording.events}
    assert found
    assert found <= {status for _, status in on_the_page()}
    assert str(PAGE.relative_to(ROOT)) in said.err
