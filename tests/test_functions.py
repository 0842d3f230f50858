"""The commands as functions: same results as from the command line, and the same messages."""

import json

import pytest

import fesloop
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.models.patient_model import load_patient_model


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return fesloop.run("finger_control", {"control": "pid", "latency_ms": 50}, seed=3,
                       out=tmp_path_factory.mktemp("runs"))


def test_a_run_is_that_of_the_command(result, tmp_path, capsys):
    main(["run", "finger_control", "--set", "control=pid", "--set", "latency_ms=50", "--seed", "3", "--out",
          str(tmp_path), "--json"])
    assert json.loads(capsys.readouterr().out)["metrics"] == json.loads(json.dumps(result.metrics))
    with fesloop.Recording(result.recording) as ours, \
            fesloop.Recording(next(tmp_path.glob("*.h5"))) as theirs:
        assert ours.digest() == theirs.digest()


def test_settings_are_a_mapping_or_texts_and_an_experiment_has_its_own(result, tmp_path):
    experiment = fesloop.load("finger_control", ["control=pid", "latency_ms=50"])
    again = fesloop.run(experiment, seed=3, out=tmp_path)
    assert again.metrics == result.metrics
    with pytest.raises(InputError, match="settings: given with an experiment"):
        fesloop.run(experiment, {"control": "mpc"})
    with pytest.raises(InputError, match="lantency_ms"):
        fesloop.run("finger_control", {"lantency_ms": 50}, out=tmp_path)
    run = fesloop.run("finger_control", {"blocks.controller.compensate_age": False}, out=tmp_path)
    with fesloop.Recording(run.recording) as recording:
        assert recording.experiment["blocks"]["controller"]["compensate_age"] is False


def test_reports_take_results_paths_and_names(result, tmp_path):
    assert fesloop.report(result, out=tmp_path / "one.html").stat().st_size > 100_000
    both = fesloop.report(result, str(result.recording), out=str(tmp_path / "both.html"))
    assert both.exists()
    with pytest.raises(InputError, match="of nothing"):
        fesloop.report()
    with pytest.raises(InputError, match="name of an HTML file"):
        fesloop.report(result, out=tmp_path / "one.txt")
    with pytest.raises(InputError, match="there is no such recording"):
        fesloop.report(tmp_path / "none.h5")


@pytest.mark.slow
def test_a_patient_is_identified_as_by_the_command(tmp_path, capsys):
    run = fesloop.run("identify_patient", out=tmp_path)
    model = fesloop.identify(run)
    model.save(str(tmp_path / "ours.toml"))
    with pytest.raises(InputError, match=r"ours\.toml/model\.toml: cannot be written: Not a directory"):
        model.save(tmp_path / "ours.toml" / "model.toml")
    main(["identify", str(run.recording), "--out", str(tmp_path / "theirs.toml")])
    capsys.readouterr()
    theirs = load_patient_model(tmp_path / "theirs.toml")
    assert (tmp_path / "ours.toml").read_text() == (tmp_path / "theirs.toml").read_text()
    assert model.usable == theirs.usable


@pytest.mark.slow
def test_a_study_gives_its_results(tmp_path):
    (tmp_path / "small.toml").write_text("""
[study]
name = "small"
description = "two latencies"
experiment = "finger_control"
[study.metrics]
error_deg = "joint_rmse_deg"
[axes.latency_ms]
key = "latency_ms"
values = [0, 50]
[[figures]]
name = "error"
kind = "curves"
metric = "error_deg"
x = "latency_ms"
theory = "none"
""")
    results = fesloop.study(tmp_path / "small.toml", out=tmp_path, workers=1)
    assert (tmp_path / "small" / "error.png").stat().st_size > 1000
    assert len(results.frame()) == 2
    assert (results.frame()["status"] == "done").all()
    assert fesloop.report(tmp_path / "small").exists()
    with pytest.raises(InputError, match="form"):
        fesloop.study(tmp_path / "small.toml", "full", out=tmp_path)
