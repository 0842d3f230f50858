"""The state-space plant: against python-control, analytic responses and its own contract."""

import math
import pickle

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.loop.block import Context
from plants.finger import Finger
from plants.linear import StateSpace
from plants.linear.state_space import InputNonlinearity

W, ZETA = 2 * math.pi * 2.5, 0.6
SECOND_ORDER = {"a": ((0.0, 1.0), (-W * W, -2 * ZETA * W)), "b": ((0.0,), (W * W,)), "c": ((1.0, 0.0),)}
TWO_BY_TWO = {"a": ((-3.0, 1.0, 0.0), (0.0, -5.0, 2.0), (1.0, 0.0, -8.0)),
              "b": ((1.0, 0.0), (0.0, 2.0), (0.5, 0.5)), "c": ((1.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
              "d": ((0.0, 0.3), (0.2, 0.0))}
CONTEXT = Context("plant")


def step_response(time_s: float) -> float:
    damped = W * math.sqrt(1 - ZETA**2)
    return 1 - math.exp(-ZETA * W * time_s) * (
        math.cos(damped * time_s) + ZETA * W / damped * math.sin(damped * time_s))


@given(cuts=st.lists(st.integers(1, 499_999_999), max_size=6))
@settings(max_examples=40, deadline=None)
def test_the_step_response_is_the_analytic_one_however_it_is_split(cuts: list[int]) -> None:
    plant = StateSpace(**SECOND_ORDER)
    state, now = plant.init(CONTEXT), 0
    for cut in [*sorted(cuts), 500_000_000]:
        plant.advance(state, [1.0], now, cut)
        now = cut
        assert plant.read(state, [1.0])[0] == pytest.approx(step_response(now * 1e-9), abs=1e-12)


def test_a_driven_system_agrees_with_forced_response() -> None:
    system = control.ss(*(np.array(TWO_BY_TWO[key]) for key in "abcd"))
    plant = StateSpace.from_control(system, initial_state=(0.4, -1.0, 0.2))
    rng = np.random.default_rng(1)
    held = rng.normal(size=(2, 12))
    times = np.arange(12) * 0.05
    sampled = control.sample_system(system, 0.05)
    expected = control.forced_response(sampled, times, held, [0.4, -1.0, 0.2]).outputs
    state = plant.init(CONTEXT)
    for k in range(12):
        np.testing.assert_allclose(plant.read(state, [held[:, k]])[0], expected[:, k], atol=1e-12)
        plant.advance(state, [held[:, k]], k * 50_000_000, (k + 1) * 50_000_000)


@pytest.mark.parametrize("parameters", [SECOND_ORDER, TWO_BY_TWO])
def test_observing_equals_advancing_a_copy_and_touches_nothing(parameters: dict) -> None:
    plant = StateSpace(**parameters)
    value = 0.7 if len(parameters["b"][0]) == 1 else np.array([0.7, -0.2])
    state = plant.init(CONTEXT)
    plant.advance(state, [value], 0, 3_000_000)
    before = pickle.dumps(state)
    other = 1.5 if isinstance(value, float) else np.array([0.1, 0.9])
    times = [3_000_000, 3_500_001, 9_000_000]
    rows = plant.observe(state, [other], 3_000_000, times)[0]
    assert pickle.dumps(state) == before
    for row, time_ns in zip(rows, times, strict=True):
        copy = pickle.loads(before)
        plant.advance(copy, [other], 3_000_000, time_ns)
        np.testing.assert_array_equal(row, plant.read(copy, [other])[0])


def test_direct_feedthrough_shows_an_input_at_once() -> None:
    plant = StateSpace(a=((-1.0,),), b=((1.0,),), c=((1.0,),), d=((2.0,),))
    assert plant.feedthrough
    state = plant.init(CONTEXT)
    plant.advance(state, [1.0], 0, 10)
    assert plant.read(state, [5.0])[0] == pytest.approx(10.0, abs=1e-7)
    assert not StateSpace(**SECOND_ORDER).feedthrough


def test_fixed_steps_take_the_exact_period_of_their_rate() -> None:
    plant = StateSpace(**SECOND_ORDER, grid_rate="285.714")
    assert plant.grid is not None
    state = plant.init(CONTEXT)
    for k in range(100):
        plant.advance(state, [1.0], plant.grid.tick(k), plant.grid.tick(k + 1))
    assert plant.read(state, [1.0])[0] == pytest.approx(step_response(100 / 285.714), abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("nonlinearity", "inputs", "expected"), [
    ({"kind": "saturation", "lower": -1.0, "upper": 2.0}, (-3.0, 0.5, 9.0), (-1.0, 0.5, 2.0)),
    ({"kind": "deadzone", "lower": -1.0, "upper": 2.0}, (-3.0, 0.5, 9.0), (-2.0, 0.0, 7.0)),
    ({"kind": "logistic", "lower": 1.0, "upper": 3.0, "centre": 0.2, "width": 0.5},
     (-900.0, 0.2, 0.7), (1.0, 2.0, 1 + 2 / (1 + math.exp(-1)))),
    ({"kind": "table", "table_input": (0.0, 1.0, 3.0), "table_output": (5.0, 6.0, 0.0)},
     (-1.0, 0.25, 2.0, 3.0, 8.0), (5.0, 5.25, 3.0, 0.0, 0.0)),
    ({}, (-2.0, 7.0), (-2.0, 7.0))])
def test_a_nonlinearity_acts_before_the_plant(nonlinearity: dict, inputs: tuple, expected: tuple) -> None:
    curve = InputNonlinearity(**nonlinearity)
    plant = StateSpace(**SECOND_ORDER, nonlinearity=curve)
    plain = StateSpace(**SECOND_ORDER)
    for value, wanted in zip(inputs, expected, strict=True):
        assert curve.apply(value) == pytest.approx(wanted, abs=1e-12)
        bent, straight = plant.init(CONTEXT), plain.init(CONTEXT)
        plant.advance(bent, [value], 0, 40_000_000)
        plain.advance(straight, [wanted], 0, 40_000_000)
        assert plant.read(bent, [0.0])[0] == pytest.approx(plain.read(straight, [0.0])[0], abs=1e-12)


@pytest.mark.slow
def test_a_pickled_state_goes_on_with_the_same_bits() -> None:
    plant = StateSpace(**SECOND_ORDER)
    state = plant.init(CONTEXT)
    plant.advance(state, [1.0], 0, 1_234_567)
    again = pickle.loads(pickle.dumps(state))
    twin = pickle.loads(pickle.dumps(plant))
    plant.advance(state, [1.0], 1_234_567, 99_000_000)
    twin.advance(again, [float("1")], 1_234_567, 99_000_000)
    assert plant.read(state, [1.0]) == twin.read(again, [1.0])


def test_ports_and_linear_model_follow_the_matrices() -> None:
    plant = StateSpace(**{**TWO_BY_TWO, "d": ()}, input_unit="A", output_unit="rad", output_offset=(1.0, 2.0))
    assert (plant.inputs[0].shape, plant.inputs[0].unit) == ((2,), "A")
    assert (plant.outputs[0].shape, plant.outputs[0].unit) == ((2,), "rad")
    model = plant.linear_model()
    np.testing.assert_array_equal(model.offset, [1.0, 2.0])
    np.testing.assert_array_equal(plant.read(plant.init(CONTEXT), [np.zeros(2)])[0], [1.0, 2.0])


@pytest.mark.parametrize(("change", "named"), [
    ({"a": ((0.0, 1.0),)}, "state_space.a"), ({"a": ((0.0, 1.0), (1.0,))}, "state_space.a"),
    ({"b": ((0.0,),)}, "state_space.b"), ({"c": ((1.0,),)}, "state_space.c"),
    ({"d": ((1.0, 2.0),)}, "state_space.d"), ({"initial_state": (1.0,)}, "state_space.initial_state"),
    ({"output_offset": (1.0, 2.0)}, "state_space.output_offset"), ({"a": ()}, "state_space"),
    ({"a": ((math.nan, 0.0), (0.0, 0.0))}, "state_space.a"), ({"grid_rate": "-5"}, "state_space.grid_rate")])
def test_bad_parameters_are_named(change: dict, named: str) -> None:
    with pytest.raises(InputError, match=named.replace(".", r"\.")):
        StateSpace(**{**SECOND_ORDER, **change})


@pytest.mark.parametrize("change", [
    {"lower": 1.0}, {"width": 0.0}, {"centre": math.inf}, {"kind": "table", "table_input": (1.0, 1.0)},
    {"kind": "table", "table_input": (0.0, 1.0), "table_output": (1.0,)}])
def test_bad_nonlinearities_are_named(change: dict) -> None:
    with pytest.raises(InputError, match="nonlinearity"):
        InputNonlinearity(**change)


def test_what_is_not_a_continuous_state_space_is_refused() -> None:
    with pytest.raises(InputError, match="discrete-time"):
        StateSpace.from_control(control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], 0.1))
    with pytest.raises(InputError, match="discrete-time"):
        StateSpace.from_control(control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], True))
    with pytest.raises(InputError, match=r"control\.ss"):
        StateSpace.from_control(control.tf([1.0], [1.0, 1.0]))
    with pytest.raises(InputError, match="feedthrough"):
        StateSpace(**TWO_BY_TWO).linear_model()


def as_state_space(finger):
    """The matrices and curves of a finger, as a file would have them; its delay is left to a wire."""
    model = finger.linear_model()
    rows = {key: tuple(map(tuple, getattr(model, key))) for key in "abc"}
    return StateSpace(**rows, output_offset=tuple(model.offset), recruitment=model.recruitment,
                      output_unit="rad")


widths_s = st.lists(st.floats(0.0, 500e-6), min_size=4, max_size=4)


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(1, 80_000_000), widths_s), min_size=1, max_size=8))
@settings(max_examples=40, deadline=None)
def test_with_recruitment_it_is_the_finger_whose_numbers_it_has(course):
    finger = Finger(delay_ms=0.0)
    pair = [(plant, plant.init(CONTEXT)) for plant in (finger, as_state_space(finger))]
    now = 0
    for length, widths in course:
        stimulation = np.stack([np.full(4, 0.04), np.array(widths)], axis=-1)
        for plant, state in pair:
            plant.advance(state, [stimulation], now, now + length)
        now += length
        one, other = (plant.read(state, [stimulation])[0] for plant, state in pair)
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-9)


def test_recruitment_is_told_with_the_model_and_has_as_many_muscles_as_inputs():
    plant = as_state_space(Finger())
    assert [(port.name, port.shape, port.unit) for port in plant.inputs] == [("stimulation", (4, 2), "A,s")]
    assert plant.linear_model().recruitment == Finger().recruitment
    with pytest.raises(InputError, match=r"state_space.recruitment: 4 muscles; allowed: 1"):
        StateSpace(**SECOND_ORDER, recruitment=Finger().recruitment)
