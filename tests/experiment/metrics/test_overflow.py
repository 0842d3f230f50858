"""Runs whose numbers leave the floats, and experiments that are given no score."""

import warnings

import pytest

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import Experiment

UNSTABLE = ["latency_ms=300", "kp=20", "experiment.duration_s=60"]


def test_squares_beyond_floats_are_the_reason_and_nothing_is_warned_of(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        metrics = load("linear_loop", UNSTABLE).run(out=tmp_path).metrics
    reasons = {why for each in metrics["missing"].values()
               for why in ([each] if isinstance(each, str) else each)}
    assert reasons == {"its squares are beyond floating point: the loop is unstable"}


@pytest.mark.parametrize(("settings", "unstable"), [(UNSTABLE, True), (["experiment.duration_s=6"], False)])
def test_a_run_of_an_unstable_loop_begins_with_that(settings, unstable, tmp_path, capsys):
    sets = [word for each in settings for word in ("--set", each)]
    main(["run", "linear_loop", *sets, "--out", str(tmp_path / "runs")])
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("fesloop: ")]
    assert any("the loop is unstable: the spectral radius" in line for line in said[:1]) == unstable


@pytest.mark.parametrize("key", ["score", "record"])
def test_no_score_is_named(key):
    experiment = load("linear_loop")
    with pytest.raises(InputError, match=f"{key}: None"):
        Experiment(name="none", nodes=experiment.nodes, wires=experiment.wires, duration_s=1.0, **{key: None})
