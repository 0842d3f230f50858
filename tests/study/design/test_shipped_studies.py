"""Shipped studies: every level of every axis, in every form, makes an experiment. About 25 s."""

import json
import shlex
import zlib

import pytest

import fesloop
from fesloop.analysis.study.design.cells import cells_of, covering
from fesloop.analysis.study.design.plan import NotPrepared
from fesloop.analysis.study.design.shipped_studies import described_studies
from fesloop.analysis.study.design.study import KeptMetric
from fesloop.analysis.study.design.study_file import read_study
from fesloop.analysis.study.engine.preparing import Preparations
from fesloop.apps.cli.parser import make_parser

FORMS = [(name, form) for name, forms in described_studies().items() for form in forms]
WANTED = ["cohort_ilc", "dropout_map", "error_map", "grasp_latency_map", "latency_map", "persons",
          "required_accuracy", "required_accuracy_aperture", "required_latency", "search_accuracy",
          "search_map", "sensor_map", "tracker_map"]


def meanwhile(study):
    return [setting for preparation in study.prepare.values() for setting in preparation.meanwhile]


def test_they_are_all_there_and_have_a_full_form():
    studies = described_studies()
    assert set(WANTED) <= set(studies)
    assert all("full" in studies[name] for name in WANTED)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "form"), FORMS)
def test_every_level_makes_an_experiment(name, form):
    if name.startswith("search"):
        pytest.importorskip("sklearn", reason="the extra `search`")
    study = read_study(name, form)
    for cell in covering(study):
        experiment = fesloop.load(cell.experiment, [*meanwhile(study), *cell.settings])
        assert experiment.duration_ns > 0, cell.place


@pytest.mark.parametrize("name", WANTED)
def test_the_full_form_says_what_it_costs_and_is_larger(name):
    small, full = read_study(name), read_study(name, "full")
    assert full.cost.startswith(f"{full.runs} runs")
    assert full.runs > 5 * small.runs
    assert set(small.axes) <= set(full.axes)


def test_each_grasp_has_a_model_from_its_own_posture():
    study = read_study("required_accuracy")
    cells = {cell.experiment: cell for cell in cells_of(study) if cell.levels["member"] == 0}
    assert set(cells) == {"grasp_mpc", "pinch_mpc", "key_mpc"}
    preparations = Preparations(study)
    ids = {name: dict(preparations.ids(cell))["model"] for name, cell in cells.items()}
    documents = {name: json.loads(zlib.decompress(preparations.needed[id][1])) for name, id in ids.items()}
    assert {name: document["experiment"]["name"] for name, document in documents.items()} == {
        "grasp_mpc": "identify_grasp", "pinch_mpc": "identify_grasp", "key_mpc": "identify_key"}
    assert ids["grasp_mpc"] == ids["pinch_mpc"]
    with pytest.raises(NotPrepared, match=r"^identify_key: nothing moved"):
        preparations.settings(cells["key_mpc"], {}, {ids["key_mpc"]: "nothing moved"})


@pytest.mark.parametrize("name", ["latency_map", "error_map", "dropout_map"])
def test_metrics_are_those_of_a_run(name, tmp_path):
    study = read_study(name)
    cell = next(cell for cell in cells_of(study) if cell.levels["controller"] == "pid")
    metrics = fesloop.load(cell.experiment, cell.settings).run(tmp_path).metrics
    for metric, path in study.about.metrics.items():
        assert KeptMetric.parse(metric, path).of(metrics) is not None


@pytest.mark.parametrize("name", described_studies())
def test_each_says_what_to_try_next_which_is_no_part_of_it(name):
    study = read_study(name)
    assert 1 <= len(study.try_next) <= 2
    assert "guide" not in study.document
    for command in study.try_next:
        args = make_parser().parse_args(shlex.split(command)[1:])
        if args.command == "study":
            assert read_study(args.study, args.form).about.name == args.study
        else:
            pytest.importorskip("sklearn", reason="the extra `search`")
            assert fesloop.load(args.experiment, args.settings).name == args.experiment


def test_persons_are_the_same_members_of_every_kind_on_a_day():
    cells = list(cells_of(read_study("persons", "full")))
    whos = {cell.settings[:4] for cell in cells}
    assert len(whos) == 4 * 10
    assert ('patient.file="sci_c6"', "patient.cohort=3", "patient.member=7", "patient.day=1") in whos
