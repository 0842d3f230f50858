import numpy as np
import pytest
from ilc_parts import MODEL, scalar

from controllers.trajectories import mixed, response, shares_of

MODELS = [scalar(0.5, 1.0), scalar(0.9, 0.3), scalar(0.2, 2.0)]
DRIVES = np.random.default_rng(0).uniform(0.0, 1.0, (40, 1))
EVERYWHERE = np.ones((40, 1), dtype=bool)


@pytest.mark.parametrize("rule", ["best", "mixture"])
@pytest.mark.parametrize("which", range(3))
def test_the_true_model_is_found_whatever_the_offset(rule, which):
    posture = 3.0 + response(MODELS[which], DRIVES)
    shares, miss = shares_of(MODELS, DRIVES, posture, EVERYWHERE, rule)
    np.testing.assert_allclose(shares, np.eye(3)[which], atol=1e-6)
    assert miss[which] == pytest.approx(0.0, abs=1e-12)
    assert mixed(MODELS, np.eye(3)[which]) is MODELS[which]


def test_a_mixture_is_found_again_and_responds_as_one():
    wanted = np.array([0.25, 0.0, 0.75])
    posture = sum(share * response(model, DRIVES) for share, model in zip(wanted, MODELS, strict=True))
    shares, _ = shares_of(MODELS, DRIVES, posture, EVERYWHERE, "mixture")
    np.testing.assert_allclose(shares, wanted, atol=1e-6)
    np.testing.assert_allclose(response(mixed(MODELS, shares), DRIVES), posture, atol=1e-6)


def test_what_was_not_covered_does_not_count():
    posture, covered = response(MODELS[1], DRIVES), EVERYWHERE.copy()
    posture[25:], covered[25:] = 99.0, False
    assert shares_of(MODELS, DRIVES, posture, covered, "best")[0][1] == 1.0


@pytest.mark.parametrize("rule", ["best", "mixture"])
def test_a_trial_at_rest_says_nothing_and_the_first_model_stays(rule):
    rest = np.zeros((40, 3))
    twin = [MODEL, MODEL]
    shares, _ = shares_of(twin, rest, np.ones((40, 2)), np.ones((40, 2), dtype=bool), rule)
    np.testing.assert_array_equal(shares, [1.0, 0.0])
