"""Every number that a command prints has a definition, and every definition a number."""

import ast
import re
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from metric_pages import PAGE, metrics_page

import fesloop
from fesloop.apps.cli import bench_command, main
from fesloop.errors import InputError
from fesloop.experiment.metrics.words import definitions_of, groups

ROOT = Path(__file__).resolve().parents[3]
DEFINITIONS = [each for group in groups() for each in group.definitions]
NAMES = sorted({text for each in DEFINITIONS for text in (each.name, *each.shown)})
METRICS = ("cycles", "grasp", "intention", "lateness", "orientation", "scoring", "search")
NO_NUMBERS = {
    "", "case", "node", "kind", "ticks", "takes", "from", "to", "latency", "late messages", "status",
    "detail", "stage, ms", "option", "description", "name", "key", "exactly", "number", "unit",
    "what it is", "angle", "electrode", "pulses", "muscle", "output", "channel", "joint", "--set",
    "needs", "in", "options, the default first", "--form", "what it is, and what the form costs",
    "who it is", "table", "row", "pattern", "parent's axis", "child's axis", "sensor", "w x y z",
    "other", "marker", "stream", "type", "centre m", "rotation w x y z", "origin m"}
"""Headings of columns that hold names, words or vectors."""
INNER = {"from_ms", "instants", "p50", "p99", "worst", "median", "hold", "opening", "contact", "rmse"}
"""Keys within a number, which its definition explains."""


def headings():
    """Literal headings of the tables that commands print, each with its file."""
    for path in sorted((ROOT / "fesloop/apps/cli").glob("*_command.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            lists = []
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "print_table":
                lists = [node.args[1]]
            elif path.name == "calibrate_command.py" and isinstance(node, ast.Tuple) and len(node.elts) == 3:
                lists = [node.elts[1]]
            elif path.name == "reproduce_command.py" and isinstance(node, ast.Assign) \
                    and node.targets[0].id == "_COLUMNS":
                lists = [node.value]
            for each in lists:
                for item in getattr(each, "elts", ()):
                    if isinstance(item, ast.Constant):
                        yield path.name, item.value


def written_keys(path):
    """Strings by which a module names what it puts into dictionaries."""
    for node in ast.walk(ast.parse(path.read_text())):
        keys = []
        if isinstance(node, ast.Dict):
            keys = node.keys
        elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
            keys = [node.slice]
        elif isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in (
                "setdefault", "_add_by_joint"):
            keys = node.args[:2]
        yield from (key.value for key in keys if isinstance(key, ast.Constant) and isinstance(key.value, str))


@cache
def source():
    """Text of every module that computes or prints numbers."""
    return "\n".join(path.read_text() for room in ("fesloop", "controllers")
                     for path in (ROOT / room).rglob("*.py"))


def defined(name):
    return any(name in (each.name, *each.shown) for each in DEFINITIONS)


def test_every_metric_that_is_written_in_the_source_is_defined():
    """`_why` has reasons by metric, among others in dotted paths; signals of `units` are no metrics."""
    found = {key.partition(".")[0] for name in METRICS
             for key in written_keys(ROOT / f"fesloop/experiment/metrics/{name}.py")}
    lacking = {key for key in found - INNER if not defined(key)}
    assert lacking == {"inclination", "heading", "total", "from", "to"} & found
    assert {"joint_rmse_deg", "grip_margin", "queries", "late_ms", "decline_pct", "step_us"} <= found


def test_every_heading_of_a_table_of_numbers_is_defined():
    found = list(headings())
    assert len(found) > 80
    assert [(file, text) for file, text in found if text not in NO_NUMBERS and not defined(text)] == []
    assert all(map(defined, bench_command._COLUMNS))


@pytest.mark.parametrize("definition", DEFINITIONS, ids=lambda each: each.name)
def test_every_definition_is_of_a_number_that_the_source_has(definition):
    text = source()
    written = re.sub("split_(total|tracker|controller)_deg", "split_{part}_deg", definition.name)
    for name in (written, *definition.shown):
        assert re.search(rf"""["'\s]{re.escape(name)}["',;:\s=]""", text), name


def test_the_page_is_made_from_the_definitions():
    assert PAGE.read_text() == metrics_page(), "run python docs/_extensions/metric_pages.py"


@pytest.mark.parametrize("definition", DEFINITIONS, ids=lambda each: each.name)
def test_a_definition_is_a_sentence(definition):
    assert re.match("[A-Z`]|99th", definition.what)
    assert definition.what.endswith(".")
    assert not definition.nan.endswith(".")


@given(st.sampled_from(NAMES), st.booleans())
def test_a_name_is_found_in_any_case_and_with_blanks_around(name, upper):
    found = definitions_of(f" {name.upper() if upper else name} ")
    assert all(name.lower() in map(str.lower, (each.name, *each.shown)) for each in found)


@given(st.text(max_size=40))
def test_any_text_is_found_or_refused_in_one_line(name):
    try:
        found = definitions_of(name)
    except InputError as refused:
        found = [refused]
    assert found
    assert not any("\n" in str(each) for each in found if isinstance(each, InputError))


@pytest.mark.parametrize(("path", "name"), [
    ("joints.MCP.joint_rmse_deg", "joint_rmse_deg"), ("split_rmse_deg tracker", "split_rmse_deg"),
    ("aperture_mm.hold", "aperture_mm"), ("grip_force_n F2", "grip_force_n"), ("begun late, ms", "late_ms"),
    ("step_us.tracker.median", "step_us"), ("joints", "joints")])
def test_a_path_leads_to_its_number(path, name):
    assert [each.name for each in definitions_of(path)] == [name]


def test_a_number_of_two_commands_has_both_definitions(capsys):
    assert main(["explain", "realtime_factor"]) == 0
    told = capsys.readouterr().out
    assert "(fesloop run)" in told
    assert "(fesloop bench)" in told


def test_a_name_that_does_not_exist_is_answered_with_the_nearest(capsys):
    assert main(["explain", "grip_margn"]) == 2
    assert capsys.readouterr().err == ("fesloop: explain: no command prints a number 'grip_margn'; "
                                       "did you mean 'grip_margin'?\n")


@pytest.mark.parametrize(("name", "said"), [
    ("fit", "'fit' is no number, but a part of names of numbers (fit_percent)"),
    ("identify", "'identify' is the command `fesloop identify`, which prints fit_percent, held_out_s,"),
    ("grasp_mpc", "'grasp_mpc' is the experiment grasp_mpc (`fesloop check grasp_mpc`), and no number"),
    ("latency_map", "'latency_map' is the study latency_map (`fesloop study latency_map --dry-run`)"),
    ("fatigue", "'fatigue' is the experiment fatigue (`fesloop check fatigue`), and no number"),
    ("tuned_pid", "'tuned_pid' is the kind of block tuned_pid (`fesloop list`), and no number"),
    ("sweeps", "no command prints a number 'sweeps'; did you mean 'sweep'?")])
def test_a_name_of_something_else_is_answered_with_what_it_is(name, said, capsys):
    assert main(["explain", name]) == 2
    line = capsys.readouterr().err
    assert said in line
    assert line.count("\n") == 1


def test_the_heading_of_a_sweeps_fit_is_explained(capsys):
    assert main(["explain", "sweep"]) == 0
    assert "on the sweep that it was fitted to" in " ".join(capsys.readouterr().out.split())


def test_a_number_of_a_study_leads_to_the_one_that_it_comes_from(capsys):
    assert main(["explain", "first_error_deg"]) == 0
    told = capsys.readouterr().out
    assert "joint_rmse_deg:first in cohort_ilc" in told
    assert "fesloop explain joint_rmse_deg" in told
    assert main(["explain", "first_error_dg"]) == 2
    assert "did you mean 'first_error_deg'?" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["run", "study", "fit-error", "bench"])
def test_the_option_needs_nothing_else_of_a_command(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([command, "--explain", "joint_rmse_deg"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith("joint_rmse_deg, deg (fesloop run)\n")


def test_without_a_name_all_are_listed(capsys):
    assert main(["explain"]) == 0
    told = capsys.readouterr().out
    at = [told.index(group.title) for group in groups()]
    assert all(one < other for one, other in pairwise(at))


def paths_of(metrics):
    return {name for name in metrics if name != "missing"} | {
        column for table in metrics.get("joints", {}).values() for column in table}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fatigue", "finger_ilc", "array_search_two_phase", "hold_grip_force"])
def test_every_metric_of_a_run_is_defined(name, tmp_path):
    """Of each form of score one; .ci/plausible.py asks the same of every shipped experiment and variant."""
    short = {"array_search_two_phase": ["experiment.duration_s=5"]}
    found = paths_of(fesloop.load(name, short.get(name, ())).run(tmp_path).metrics)
    assert found
    assert {metric for metric in found if not defined(metric)} == set()


@pytest.mark.parametrize(("signal", "kind", "page"), [
    ("search.best_quality", "point_search", "controllers"), ("hand.angles", "hand", "plants"),
    ("tracker.fingertips", "constrained", "estimators")])
def test_a_signal_is_called_one_and_its_page_is_named(signal, kind, page, capsys):
    assert main(["explain", signal]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{signal!r} is a signal of a recording (block kind {kind}), and no number" in line
    assert line.endswith(f"docs/reference/{page}.md explains the outputs of {kind}")
    assert main(["explain", f"{signal}_of_nothing"]) == 2
    assert "is a signal" not in capsys.readouterr().err
