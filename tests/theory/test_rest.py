"""Where loops rest, and that theory gives no number where a limit acts there."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linear_parts import scalar_loop

from controllers.pid import Pid
from controllers.reference import MinimumJerk
from estimators.ideal import IdealTracker
from fesloop.analysis.theory import linear_loop, stationary_cost
from fesloop.analysis.theory.first_answer import COST, CRITICAL, first_answer
from fesloop.analysis.theory.period_map import period_map
from fesloop.analysis.theory.rest import rest_of
from fesloop.analysis.theory.second_moments import SecondMoments
from fesloop.errors import InputError
from fesloop.experiment.running import Experiment
from fesloop.experiment.score_spec import Score
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire
from fesloop.models.linear_model import Recruitment
from plants.linear import StateSpace

CURVE = Recruitment(threshold_ma=(10.0,), spread=(0.35,))


def loop(kp=1.0, ki=0.0, bias=0.0, aim_rad=0.0, noise_deg=0.1, tracker_bias_deg=0.0):
    """x' = -x + v, y = x, under PID control through recruitment, which no drive below 0 passes."""
    plant = StateSpace(a=((-1.0,),), b=((1.0,),), c=((1.0,),), output_unit="rad", recruitment=CURVE)
    pid = Pid(kp=(kp,), ki=(ki,), kd=(0.0,), mixing=((1.0,),), bias=(bias,), current_ma=(40.0,),
              recruitment=CURVE)
    nodes = (Node("aim", MinimumJerk(times_s=(0.0,), angles_deg=((math.degrees(aim_rad),),)), rate=20),
             Node("pid", pid, rate=20),
             Node("tracker", IdealTracker(joints=1, noise_deg=noise_deg, bias_deg=tracker_bias_deg), rate=20),
             Node("plant", plant))
    wires = (Wire("aim.angles", "pid.reference"), Wire("plant.y", "tracker.angles"),
             Wire("tracker.angles", "pid.measured"), Wire("pid.stimulation", "plant.stimulation"))
    return Experiment(name="rests", nodes=nodes, wires=wires, duration_s=10.0,
                      score=Score(truth="plant.y"))


@settings(deadline=None, max_examples=40)
@given(kp=st.floats(0.1, 5.0), ki=st.sampled_from([0.0, 0.5, 2.0]), bias=st.floats(0.0, 1.0),
       aim=st.floats(-1.0, 1.5), seen_deg=st.floats(-10.0, 10.0))
def test_a_loop_rests_where_its_equations_balance_or_is_not_covered(kp, ki, bias, aim, seen_deg):
    """At rest y = v; an integral makes y + b the reference, without one v = bias + kp (aim - v - b)."""
    b = math.radians(seen_deg)
    drive = aim - b if ki else (bias + kp * (aim - b)) / (1.0 + kp)
    experiment = loop(kp, ki, bias, aim, tracker_bias_deg=seen_deg)
    if 1e-6 < drive < 0.98:
        assert rest_of(linear_loop(experiment))["pid"] == pytest.approx([drive], abs=1e-9)
    elif drive < -1e-6 or drive > 1.0:
        with pytest.raises(InputError, match=r"beyond its (lower|upper) limit"):
            linear_loop(experiment)


def test_a_drive_that_rests_on_its_limit_is_named_in_place_of_numbers():
    answer = first_answer(loop())
    assert answer.cost is None
    assert not answer.critical_ms
    for what in (COST, CRITICAL):
        assert "drive of channel 0 rests at 0, its lower limit: not covered" in answer.not_known[what]


def test_noise_that_takes_a_drive_to_its_limit_again_and_again_is_not_covered():
    assert stationary_cost(loop(bias=0.2, noise_deg=0.5)).stable
    with pytest.raises(InputError, match=r"channel 0 rests at 0.1, .* sd of its noise .* lower limit 0"):
        stationary_cost(loop(bias=0.2, noise_deg=5.0))
    # Where it is stable says nothing of how large the noise is.
    assert first_answer(loop(bias=0.2, noise_deg=5.0)).critical_ms


@pytest.mark.parametrize("gain", [1.0, 8.0])
def test_the_spread_of_a_command_is_that_of_what_it_is_made_of(gain):
    noisy = linear_loop(scalar_loop(-2.0, gain, noise=0.3))
    recursion = SecondMoments(period_map(noisy, watched="feedback"))
    read = stationary_cost(noisy).rms[0] ** 2 + 0.3**2
    assert recursion.variance(recursion.at_rest()) == pytest.approx([gain**2 * read], rel=1e-9)
