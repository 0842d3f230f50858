"""The command line as a user meets it: exit codes, one JSON object, one line a mistake, no traceback."""

import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

from fesloop.apps.cli import main
from fesloop.apps.cli.check_command import critical_text
from fesloop.experiment.files.parse import read
from fesloop.experiment.recording.reading import Recording
from fesloop.forms.toml import toml_text

ROOT = Path(__file__).resolve().parent.parent
SMALL = str(ROOT / "tests" / "experiment" / "small.toml")


def run(capsys, *arguments):
    """(exit code, standard output, standard error) of a command."""
    code = main(list(arguments))
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    return code, captured.out, captured.err


def test_run_prints_one_object_with_the_agreed_keys(capsys, tmp_path):
    code, out, err = run(capsys, "run", SMALL, "--json", "--seed", "9", "--out", str(tmp_path))
    told = json.loads(out)
    assert code == 0
    assert list(told) == ["experiment", "seed", "status", "recording", "metrics", "wall_s", "realtime_factor"]
    assert (told["experiment"], told["seed"], told["status"]) == ("small", 9, "done")
    assert len(told["metrics"]["joint_rmse_deg"]) == 2
    assert "joint_rmse_deg" in err
    with Recording(told["recording"]) as recording:
        assert recording.seed == 9


def test_a_run_without_a_score_says_that_nothing_was_scored(capsys, tmp_path):
    unscored = tmp_path / "unscored.toml"
    before, _, after = Path(SMALL).read_text().partition("[score]")
    unscored.write_text(before + after[after.index("[aliases]"):])
    for experiment, told in ((unscored, True), (SMALL, False)):
        assert main(["run", str(experiment), "--out", str(tmp_path / "runs")]) == 0
        assert ("nothing was scored" in capsys.readouterr().err) == told


def test_run_without_json_prints_the_recording_alone(capsys, tmp_path):
    code, out, _ = run(capsys, "run", SMALL, "--out", str(tmp_path))
    assert code == 0
    assert Path(out.strip()).is_file()


def test_a_run_ends_with_where_its_report_is_and_what_to_try_next(capsys, tmp_path):
    shown = ["--out", str(tmp_path), "--set", "experiment.duration_s=1"]
    code, out, err = run(capsys, "run", "finger_control", *shown)
    report, *following = err.splitlines()[-3:]
    assert code == 0
    assert report == f"report: fesloop report {out.strip()}"
    same = "--set experiment.duration_s=1 --out " + str(tmp_path)
    assert following == [f"next:   fesloop run finger_control {same} --set control=pid --set latency_ms=100",
                         f"next:   fesloop run hil_twin --set recording={out.strip()}"]
    _, out, err = run(capsys, "run", out.strip(), "--out", str(tmp_path))
    assert err.splitlines()[-1] == f"report: fesloop report {out.strip()}"


@pytest.mark.parametrize("arguments", [
    ("run", SMALL, "--set", "blocks.pid.gain=1"),
    ("run", SMALL, "--set", 'wires.1.latency_ms="0.01"'),
    ("run", SMALL, "--set", "nothing=1"),
    ("run", "absent"),
    ("run", "absent.toml"),
    ("check", SMALL, "--set", "blocks.pid.rate=-1"),
    ("bench", "absent"),
    ("fmu", "build", "absent"),
])
def test_bad_input_is_one_line_with_exit_code_2_and_leaves_nothing(capsys, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, *arguments)
    assert code == 2
    assert out == ""
    assert len(err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_bad_input_with_json_is_one_object_too(capsys):
    code, out, _ = run(capsys, "run", SMALL, "--json", "--set", "blocks.pid.gain=1", "--set", "score.x=1")
    assert code == 2
    assert len(json.loads(out)["faults"]) == 2


def test_a_folder_that_cannot_be_written_to_is_bad_input(capsys, tmp_path):
    (tmp_path / "file").touch()
    code, _, err = run(capsys, "run", SMALL, "--out", str(tmp_path / "file" / "runs"))
    assert code == 2
    assert "--out" in err


@pytest.mark.parametrize("name", ["A_sweep.h5", "a/b.HDF5"])
def test_a_folder_with_the_name_of_a_recording_is_refused_unless_it_exists(name, capsys, tmp_path,
                                                                              monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = ["run", "finger_pid_latency", "--set", "experiment.duration_s=1.0", "--out", name]
    assert main(command) == 2
    *_, line = capsys.readouterr().err.splitlines()
    assert line == (f"fesloop: --out {name}: has the name of a file; allowed: a folder: the recording in it "
                    f"is named after the experiment; give --out {name.rpartition('.')[0]}")
    assert list(tmp_path.iterdir()) == []
    Path(name).mkdir(parents=True)
    assert main(command) == 0
    assert [each.name for each in Path(name).iterdir()] == ["finger_pid_latency-1.h5"]


def test_replay_says_how_to_give_the_recording(capsys, tmp_path):
    code, _, err = run(capsys, "run", "replay", "--out", str(tmp_path / "runs"))
    assert code == 2
    assert "--set recording=" in err
    code, _, err = run(capsys, "run", "replay", "--set", "recording=absent.mat",
                       "--out", str(tmp_path / "runs"))
    assert code == 2
    assert "absent.mat" in err
    assert not (tmp_path / "runs").exists()


UNSTABLE = """
[experiment]
name = "unstable"
duration_s = 20

[blocks.plant]
kind = "state_space"
a = [[60.0, 0.0], [0.0, -1.0]]
b = [[1.0, 0.0], [0.0, 1.0]]
c = [[1.0, 0.0], [0.0, 1.0]]
initial_state = [1.0, 1.0]

[blocks.feedback]
kind = "select"
rate = "100"
indices = [1, 1]
unit = "1"

[[wires]]
from = "plant.y"
to = "feedback.vector"

[[wires]]
from = "feedback.elements"
to = "plant.u"
"""


def test_a_failing_run_exits_with_1_its_cause_in_a_line_and_is_kept(capsys, tmp_path):
    """exp(60 t) passes the greatest float at 11.8 s."""
    file = tmp_path / "unstable.toml"
    file.write_text(UNSTABLE)
    code, out, err = run(capsys, "run", str(file), "--json", "--out", str(tmp_path))
    told = json.loads(out)
    assert code == 1
    assert told["status"] == "failed"
    before, cause, *_ = err.splitlines()
    assert before.startswith("fesloop: the loop is unstable")
    assert cause.startswith("fesloop: plant.y is not finite at 118")
    assert told["cause"] in cause
    with Recording(told["recording"]) as recording:
        assert recording.status == "failed"
        assert recording.signal("plant.y").times_ns[-1] > 11e9
        assert recording.events[-1].detail == told["cause"]


def test_check_prints_wiring_and_latency_and_runs_nothing(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, _ = run(capsys, "check", SMALL)
    assert code == 0
    assert "pid.stimulation" in out
    assert "total" in out
    assert list(tmp_path.iterdir()) == []
    _, out, _ = run(capsys, "check", SMALL, "--json")
    stages = json.loads(out)["latency"][0]["stages"]
    assert stages[-1]["min_ms"] == 25.0


def test_check_names_what_can_be_set_by_a_short_name_and_whose_hand_it_is_in_one_line(capsys):
    code, out, _ = run(capsys, "check", "open_close", "--set", "patient=sci_c6", "--set", "cohort=11",
                       "--set", "member=12", "--set", "day=13")
    assert code == 0
    assert "patient sci_c6, member 12 of cohort 11, day 13" in out.splitlines()[0]
    assert "blocks.hand.splint_deg" in next(line for line in out.splitlines() if line.startswith("brace"))
    _, out, _ = run(capsys, "check", "open_close", "--json")
    assert json.loads(out)["aliases"]["brace"] == "blocks.hand.splint_deg"


@pytest.mark.slow
def test_check_cautions_where_a_device_waits_for_code_and_where_its_port_is_not_there(capsys, tmp_path):
    document = read("finger_fmu")[1]
    document["blocks"]["device"] = {"kind": "stimulator_device", "rate": "50",
                                    "port": str(tmp_path / "no" / "log")}
    document["wires"].append({"from": "safety.stimulation", "to": "device.stimulation"})
    (tmp_path / "both.toml").write_text(toml_text(document))
    code, out, _ = run(capsys, "check", str(tmp_path / "both.toml"), "--json")
    told = {(each["node"], each["status"]): each["detail"] for each in json.loads(out)["cautions"]}
    assert code == 0
    assert "without a rehearsal" in told["finger", "not_rehearsed"]
    assert told["device", "not_ready"].startswith(f"port: there is no folder {tmp_path / 'no'}")
    _, out, _ = run(capsys, "check", "finger_fmu", "--json")
    assert json.loads(out)["cautions"] == []


def test_list_names_every_shipped_experiment_and_kind(capsys):
    code, out, _ = run(capsys, "list", "--json")
    told = json.loads(out)
    assert code == 0
    assert {"finger_ilc", "replay"} <= set(told["experiments"])
    assert all(told["kinds"].values())
    for each in told["experiments"].values():
        assert each["takes_s"] > 0.0
        assert each["job"]
        assert each["description"]
    assert told["experiments"]["array_search_gp"]["needs"] == ["extra search"]
    _, out, _ = run(capsys, "list")
    lines = [line.split() for line in out.splitlines()]
    for name, each in told["experiments"].items():
        row = next(line for line in lines if line[:1] == [name])
        assert row[1].isdigit()
        assert row[2] in ("s", "min", "h")
        for need in each["needs"]:
            assert need.split()[0] in row


@pytest.mark.slow
def test_the_schema_accepts_shipped_files_and_refuses_a_typing_error(capsys):
    _, out, _ = run(capsys, "schema")
    schema = json.loads(out)
    document = read(SMALL)[1]
    jsonschema.validate(document, schema)
    document["blocks"]["pid"]["gain"] = 1
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, schema)


def test_fmu_build_writes_the_finger(capsys, tmp_path):
    code, out, _ = run(capsys, "fmu", "build", "--out", str(tmp_path), "--json")
    told = json.loads(out)
    assert code == 0
    assert Path(told["fmu"]).stat().st_size == told["size"]


def test_an_error_inside_a_block_is_one_line_unless_asked_for(capsys, monkeypatch, tmp_path):
    def broken(*_):
        raise ZeroDivisionError("in a block")

    monkeypatch.setattr("controllers.pid.block.Pid.step", broken)
    code, _, err = run(capsys, "run", SMALL, "--out", str(tmp_path))
    assert code == 1
    assert "ZeroDivisionError: in a block (test_cli.py:" in err
    with pytest.raises(ZeroDivisionError):
        main(["--traceback", "run", SMALL, "--out", str(tmp_path)])
    assert len(list(tmp_path.glob("small-*.h5"))) == 2


def python(code, cwd=None):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=cwd, check=False)


@pytest.mark.parametrize("code", ["import fesloop", "from fesloop.apps.cli import main; main([])",
                                  "from fesloop.apps.cli import main; main(['--help'])"])
def test_import_greeting_and_help_load_nothing_heavy(code):
    require_light(code, [])


def test_the_list_loads_no_block_and_nothing_heavy_but_its_tables():
    require_light("from fesloop.apps.cli import main; main(['list'])", ["rich"])


def require_light(code, loaded):
    heavy = "print([m for m in ('numpy', 'numba', 'scipy', 'h5py', 'pydantic', 'rich') if m in sys.modules])"
    done = python(f"import atexit, sys; atexit.register(exec, {heavy!r}, {{'sys': sys}})\n{code}")
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1] == str(loaded)


def imported_from(*folders, cwd=None):
    """`import fesloop` where these folders come first, and no editable install comes before them."""
    return python(
        "import sys; sys.meta_path = [f for f in sys.meta_path if 'ditable' not in repr(f)]\n"
        f"sys.path[:0] = {[str(folder) for folder in folders]}\nimport fesloop", cwd)


@pytest.mark.parametrize("kind", ["module", "package"])
def test_a_file_that_shadows_a_block_package_is_named(tmp_path, kind):
    shadow = tmp_path / "plants.py" if kind == "module" else tmp_path / "plants" / "__init__.py"
    shadow.parent.mkdir(exist_ok=True)
    shadow.touch()
    done = imported_from(tmp_path, ROOT)
    assert done.returncode == 1
    assert f"shadowed by {shadow}" in done.stderr.splitlines()[-1]


def test_a_folder_without_a_package_in_it_shadows_nothing(tmp_path):
    (tmp_path / "controllers").mkdir()
    assert imported_from(tmp_path, ROOT, cwd=tmp_path).returncode == 0


def test_check_prints_what_theory_knows_of_a_linear_loop(capsys):
    code, out, _ = run(capsys, "check", "linear_loop", "--set", "latency_ms=60")
    assert code == 0
    assert "critical latency of tracker.angles->controller.measured" in out
    assert "rms at rest, deg" in out
    _, out, _ = run(capsys, "check", "linear_loop", "--json")
    theory = json.loads(out)["theory"]
    assert theory["stable"]
    assert set(theory["rms"]) == {"MCP", "PIP", "DIP"}
    assert 30.0 < theory["critical_latency_ms"]["tracker.angles->controller.measured"] < 300.0
    code, out, _ = run(capsys, "check", "linear_loop", "--set", "latency_ms=200")
    assert "never" in out


def test_check_says_why_there_is_no_theory_where_a_loop_is_not_linear(capsys):
    _, out, _ = run(capsys, "check", "finger_mpc", "--json")
    theory = json.loads(out)["theory"]
    why = "controller: Mpc is not linear; allowed: linear blocks, for the theory of a linear loop"
    assert theory == {"critical_latency_ms": {}, "missing": {"rms at rest": why, "critical latencies": why}}
    _, out, _ = run(capsys, "check", "finger_mpc")
    assert f"Theory gives no rms at rest and critical latencies: {why}" in out.splitlines()


@pytest.mark.parametrize(("settings", "line"), [
    (["jitter_ms=3"], "Theory gives no critical latencies: under jitter or loss they take long: "
     "fesloop.analysis.theory.critical_latency_ms gives them"),
    pytest.param(["loss=0.1", "latency_ms=300"], "Theory gives no critical latencies: under jitter or loss "
                 "they take long: fesloop.analysis.theory.critical_latency_ms gives them",
                 marks=pytest.mark.slow)])
def test_check_says_which_part_of_the_theory_is_missing_and_why(capsys, settings, line):
    """Under jitter or loss, and where the loop is unstable besides, a part used to go without a word."""
    given = [part for setting in settings for part in ("--set", setting)]
    _, out, _ = run(capsys, "check", "linear_loop", *given)
    assert line in out.splitlines()
    _, out, _ = run(capsys, "check", "linear_loop", "--json", *given)
    theory = json.loads(out)["theory"]
    assert {"rms" if "rms" in theory else "", *theory["missing"]} == {"rms", "critical latencies"}


def test_check_prints_latencies_as_they_are_compared_to_the_nanosecond(capsys):
    """Into a block latency acts in whole ticks: 110 ms is stable, 110.000001 is not, and no 110.000."""
    wire = "tracker.angles->controller.measured"
    for latency, rest in (("110", "rms at rest"), ("110.000001", "at rest  ")):
        _, out, _ = run(capsys, "check", "linear_loop", "--set", f"latency_ms={latency}")
        (row,) = (line for line in out.splitlines() if f"critical latency of {wire}" in line)
        assert row.split()[-5:] == ["110.000001", "ms", latency, "ms", "now"]
        assert any(line.startswith(rest) for line in out.splitlines())
        assert any(line.split()[:4] == ["tracker.angles", "controller.measured", latency, "ms"]
                   for line in out.splitlines())


@pytest.mark.parametrize("arguments", [
    ["run"], ["bogus"], ["check", "x", "--seed", "one"], ["check", "x", "--bogus"], ["fmu"],
    ["picture", "x", "--at", "a"], ["stream", "x", "--network", "moon"], ["run", "x", "--late", "\x1b[31m\n"],
    ["view", "a", "b", "c"]])
def test_a_mistake_on_the_command_line_is_one_line(capsys, arguments):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    captured = capsys.readouterr()
    (line,) = captured.err.splitlines()
    assert (ended.value.code, captured.out) == (2, "")
    assert line.startswith("fesloop: ")
    assert line.isprintable()


def test_a_set_of_sensors_of_a_hand_that_has_one_is_refused(capsys):
    assert main(["stream", "hand", "--sensor-set", "q"]) == 2
    assert capsys.readouterr().err == "fesloop: --sensor-set: 'q', but hand has one set; allowed: none\n"


@pytest.mark.parametrize(("latency_ms", "now_ms", "stable", "told"), [
    (None, 5.0, True, "none up to 500 ms"), (0.0, 450.0, True, "0 ms, but stable now"),
    (0.0, 5.0, False, "0 ms: unstable at 0, too"), (297.0, 700.0, True, "297 ms, but stable now"),
    (297.0, 700.0, False, "297 ms"), (297.0, 20.0, True, "297 ms")])
def test_a_loop_that_is_stable_beyond_its_critical_latency_is_told_so(latency_ms, now_ms, stable, told):
    assert critical_text(latency_ms, now_ms, stable) == told
