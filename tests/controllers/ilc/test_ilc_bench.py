"""Our laws on the plants and subjects of the peers' comparison of learning laws. Some 15 s."""

import sys

import numpy as np
import pytest
from ilc_parts import learning

from controllers.ilc.convergence import condition
from controllers.ilc.laws import Limits
from fesloop.models.linear_model import SampledModel

pytestmark = pytest.mark.slow
PERIOD_NS = 40_000_000
SUBJECTS, FEW = 20, 6
"""Subjects of the comparison, and how many of them do where a test asks of each of them."""
LAWS = {
    "phase_lead": {"gain": 0.5, "lead": 8, "cutoff": 0.24}, "gradient": {}, "noilc": {},
    "noilc_constrained": {"limits": Limits(reach=np.ones(4), slew=0.15)}, "point_to_point": {}, "newton": {},
}


@pytest.fixture(scope="module")
def hand(peers):
    """The mismatched Hammerstein hand, from where it lies."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(peers / "ilc"), str(peers / "mpc"), *sys.path])
        yield pytest.importorskip("ilc_bench")


class Curves:
    """The nominal recruitment of the comparison."""

    def __init__(self, hand):
        self.hand = hand

    def widths(self, drives):
        return self.hand.rec_inv(drives, self.hand.P0)

    def drives(self, widths):
        return self.hand.rec(widths, self.hand.P0)


def law_on(hand, name, **changes):
    """A law as the comparison sets it, on the nominal model with its delay of two samples."""
    a, b, c = hand.plant(hand.NU, hand.NY)
    states, muscles = b.shape
    delayed = SampledModel(
        np.block([[a, b], [np.zeros((muscles, states + muscles))]]),
        np.vstack([np.zeros((states, muscles)), np.eye(muscles)]),
        np.hstack([c, np.zeros((hand.NY, muscles))]), np.zeros(hand.NY), 1)
    points = np.ones((hand.N, hand.NY), dtype=bool)
    if name == "point_to_point":
        points[:] = np.isin(np.arange(hand.N), (0, 14, 36, 60, 75, 99))[:, None]
    return learning(name, delayed, hand.N, **{
        "limits": Limits(reach=np.ones(muscles), slew=np.inf), "points": points, "curves": Curves(hand),
        "change_weight": 0.06, "solver": "osqp"} | LAWS[name] | changes)


def rmse_per_trial(hand, law, updates, subjects=FEW):
    """RMSE in deg over what the law heeds, (subjects, updates + 1)."""
    every, table = np.ones((hand.N, hand.NY), dtype=bool), []
    heeded = law.points if law.law == "point_to_point" else every
    for subject in range(subjects):
        rng = np.random.default_rng(subject)
        lifted = hand.lifted(*hand.plant_m(subject))
        curves = [(hand.P0[0] * (1 + 0.15 * rng.uniform(-1, 1)), hand.P0[1] * (1 + 0.2 * rng.uniform(-1, 1)))
                  for _ in range(hand.NU)]
        drives, row = np.zeros((hand.N, hand.NU)), []
        for _ in range(updates + 1):
            widths = hand.rec_inv(drives, hand.P0)
            recruited = np.stack([hand.rec(widths[:, j], curves[j]) for j in range(hand.NU)], 1)
            noise = rng.standard_normal((hand.N, hand.NY)).cumsum(0) * 0.002
            noise += 0.003 * rng.standard_normal(hand.N * hand.NY).reshape(noise.shape)
            errors = hand.R - (lifted @ recruited.ravel()).reshape(hand.R.shape) - noise
            row.append(hand.DEG * np.sqrt(np.mean(errors[heeded] ** 2)))
            drives, status = law.learn(drives, errors, every)
            assert status == ""
        table.append(row)
    return np.array(table)


def test_limits_inside_the_programme_learn_in_two_updates_what_clipping_does_not(hand):
    inside = np.median(rmse_per_trial(hand, law_on(hand, "noilc_constrained"), 4, SUBJECTS), axis=0)
    clipped = np.median(rmse_per_trial(hand, law_on(hand, "noilc"), 2, SUBJECTS), axis=0)
    assert inside[0] == pytest.approx(21.5, abs=0.1)
    assert inside[2] <= 1.7
    assert inside[4] <= 1.05
    assert clipped[2] > 3.0 * inside[2]


@pytest.mark.parametrize("name", LAWS)
def test_no_law_diverges_where_its_condition_holds(hand, name):
    law = law_on(hand, name)
    told = condition(law, PERIOD_NS)
    assert told.holds
    assert told.strength_margin >= 1.2
    rmse = rmse_per_trial(hand, law, 10)
    assert (rmse[:, -1] < 0.3 * rmse[:, 0]).all()
    assert (rmse.max(axis=1) <= 1.05 * rmse[:, 0]).all()


def test_a_step_of_slim_margin_diverges_for_some(hand):
    law = law_on(hand, "gradient", step=1.8)
    assert condition(law, PERIOD_NS).strength_margin < 1.2
    rmse = rmse_per_trial(hand, law, 10, 12)
    assert (rmse[:, -1] > rmse[:, 0]).any()


def test_the_comparison_says_the_same_of_the_laws_that_both_have(hand):
    ours = {name: np.median(rmse_per_trial(hand, law_on(hand, name), 2), axis=0)
            for name in ("phase_lead", "gradient", "noilc")}
    for name, rmse in ours.items():
        theirs = np.median(hand.run(name, 0.06, 0.0, FEW, 3), axis=0)
        np.testing.assert_allclose(rmse, theirs, rtol=0.02)
