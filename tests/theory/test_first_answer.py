"""What theory says at once: an answer, or why there is none."""

import numpy as np
import pytest

from fesloop.analysis.theory import linear_loop, stationary_cost
from fesloop.analysis.theory.first_answer import COST, first_answer
from fesloop.errors import RunError
from fesloop.experiment.files.parse import load


@pytest.mark.parametrize("random", [[], ["loss=0.3"]])
@pytest.mark.parametrize("kp", ["1", "1e80", "1e160", "1e250", "1e308"])
def test_gains_of_any_size_have_an_answer_or_a_reason(kp, random):
    answer = first_answer(load("linear_loop", [f"kp={kp}", *random]))
    if answer.cost is None:
        assert "beyond the range of floats" in answer.not_known[COST]
    else:
        assert answer.cost.stable == np.isfinite(answer.cost.rms).all()


@pytest.mark.parametrize("random", [[], ["jitter_ms=15"], ["loss=0.3"]])
def test_what_floats_do_not_hold_is_no_failure_of_a_library(random):
    with pytest.raises(RunError, match="beyond the range of floats"):
        stationary_cost(linear_loop(load("linear_loop", ["kp=1e308", *random])))
