"""`[guide]`: checked like every other table of a file, and heeded by people alone."""

import pytest

from fesloop.errors import InputError
from fesloop.experiment.files.layout import Guide, guide_of
from fesloop.experiment.files.parse import from_document, read

SOUND = {"job": "closed_loop", "takes_s": 3}


def document(**guide):
    return {**read("finger_control")[1], "guide": {**SOUND, **guide}}


def test_a_file_without_a_guide_is_an_experiment_too():
    tables = document()
    del tables["guide"]
    assert guide_of(tables) is None
    assert from_document(tables).name == "finger_control"


@pytest.mark.parametrize(("guide", "where"), [
    ({"job": "fun"}, "guide.job"), ({"takes": 3}, "guide.takes"), ({"needs": ["luck"]}, r"guide.needs"),
    ({"needs_with": {"a=b": "luck"}}, "guide.needs_with"), ({"try_next": "fesloop list"}, "guide.try_next")])
def test_what_is_wrong_with_it_is_named(guide, where):
    with pytest.raises(InputError, match=where):
        from_document(document(**guide))


def test_a_run_takes_time():
    with pytest.raises(InputError, match=r"guide\.takes_s: 0; allowed: seconds above 0"):
        guide_of(document(takes_s=0))


def test_the_recording_stands_in_commands_to_try_next():
    guide = guide_of(document(try_next=["fesloop picture RUN.h5", "fesloop list"]))
    assert guide.next_commands("runs/a-1.h5") == ["fesloop picture runs/a-1.h5", "fesloop list"]


def test_a_model_is_tried_on_the_patient_that_it_was_identified_on():
    guide = Guide(job="closed_loop", takes_s=1.0, try_next=(
        "fesloop identify RUN.h5 --out own_model.toml", "fesloop run grasp_mpc --set model=own_model.toml"))
    settings = ("seed=3", "patient=able_bodied", "cohort=3", "member=2", "day=1", "plant=finger")
    assert guide.next_commands("a.h5", settings) == [
        "fesloop identify a.h5 --out own_model.toml",
        "fesloop run grasp_mpc --set model=own_model.toml --set patient=able_bodied --set cohort=3 "
        "--set member=2 --set day=1 --set plant=finger"]
    assert guide.next_commands("a.h5")[1] == "fesloop run grasp_mpc --set model=own_model.toml"
