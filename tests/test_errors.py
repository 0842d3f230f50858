import pickle

import pytest

from fesloop.errors import RENAMED, InputError, InputErrors, RunError, did_you_mean


def test_errors_reach_another_process_whole():
    one = InputError("blocks.pid.kp", "-1", "0 or more", "raise it")
    again = pickle.loads(pickle.dumps(one))
    assert (str(again), again.where, again.remedy) == (str(one), "blocks.pid.kp", "raise it")
    several = pickle.loads(pickle.dumps(InputErrors([one, InputError("wires", "none")])))
    assert [fault.where for fault in several.faults] == ["blocks.pid.kp", "wires"]
    assert str(several).count("\n") == 1
    assert str(pickle.loads(pickle.dumps(RunError("lost")))) == "lost"


def test_an_error_made_anew_of_its_text_has_that_text():
    text = str(InputError("action", "1.5", "-1 to 1", "clip it"))
    assert str(InputError(text)) == text


@pytest.mark.parametrize(("old", "new"), RENAMED.items())
def test_a_former_name_is_refused_with_the_present_one(old, new):
    assert did_you_mean(old, ["other", new]) == f"{old!r} is now called {new!r}"
    assert "now called" not in did_you_mean(old, ["other"])
