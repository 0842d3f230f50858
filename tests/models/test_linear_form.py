"""The linear forms of blocks against the blocks themselves, stepped beside them."""

import numpy as np
import pytest

from controllers.pid import Pid
from controllers.safety import Safety
from estimators.ideal import IdealTracker
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Sample
from fesloop.models.linear_form import LinearBlock, LinearPlant, numbers_of
from fesloop.models.linear_model import Recruitment
from fesloop.streams.blocks.select import Select
from fesloop.streams.blocks.synergies import Synergies
from plants.finger import Finger
from plants.linear import StateSpace

CLOCK = RateClock.from_rate(50)
CURVES = Recruitment(threshold_ma=(12.0, 9.0), spread=(0.35, 0.3))
GAINS = {"kp": (0.3, 0.2), "ki": (0.5, 0.4), "kd": (0.02, 0.01), "mixing": ((0.8, 0.3), (-0.2, 0.6)),
         "current_ma": (30.0, 30.0)}


def stepped(block, *values):
    """What the block's linear output puts out, (ticks, ...), for (ticks, ...) at each linear input."""
    context = Context("block", 1, clock=CLOCK)
    form = block.linear_form(context)
    state, tick, found = block.init(context), Tick(), []
    number = [port.name for port in block.outputs].index(form.output)
    for index, each in enumerate(zip(*values, strict=True)):
        tick.index, tick.time_ns = index, CLOCK.tick(index)
        samples = []
        for port in block.inputs:
            given = dict(zip(form.inputs, each, strict=True)).get(port.name)
            stamp = -1 if given is None else tick.time_ns
            samples.append(Sample(port.initial_value() if given is None else given, stamp, stamp, stamp))
        found.append(np.array(block.step(state, samples, tick)[number]))
    return np.array(found)


def by_form(block, deviations):
    """The same by the form's recursion, (ticks, outputs)."""
    form = block.linear_form(Context("block", 1, clock=CLOCK))
    x, found = np.zeros(len(form.a)), []
    for u in deviations:
        found.append(form.c @ x + form.d @ u)
        x = form.a @ x + form.b @ u
    return np.array(found)


def ticks(size, count=40):
    values = np.random.default_rng(2).normal(scale=0.05, size=(count, size))
    values[0] = 0.0
    return values


@pytest.mark.parametrize("curve", ["linear", "lognormal"])
def test_pid(curve):
    pid = Pid(**GAINS, bias=(0.4, 0.5), recruitment_curve=curve, recruitment=CURVES)
    both = ticks(4)
    pulses = stepped(pid, 0.3 + both[:, :2], 0.3 + both[:, 2:])
    found = pulses[:, :, 1] if curve == "linear" else np.array([CURVES.fraction(each) for each in pulses])
    assert np.allclose(found - found[0], by_form(pid, both), atol=1e-9)
    assert np.abs(found - found[0]).max() > 0.01 * (5e-4 if curve == "linear" else 1.0)
    assert pid.linear_form(Context("pid", clock=CLOCK)).curves == (None if curve == "linear" else CURVES)


@pytest.mark.parametrize("delay_ms", [0.0, 20.0, 35.0, 60.1])
def test_ideal_tracker(delay_ms):
    tracker = IdealTracker(joints=2, bias_deg=1.0, delay_ms=delay_ms)
    truth = ticks(2)
    found = stepped(tracker, truth)
    assert np.allclose(found - found[0], by_form(tracker, truth), atol=1e-12)


def test_ideal_trackers_noise_has_the_sd_that_is_asked_for():
    form = IdealTracker(joints=2, noise_deg=(0.2, 0.5)).linear_form(Context("tracker", clock=CLOCK))
    assert np.allclose(form.noise @ form.noise.T, np.diag(np.radians([0.2, 0.5]) ** 2))


@pytest.mark.parametrize("block", [
    Select(indices=(2, 0), size=3), Synergies(rows=("wrist_extension", "finger_flexion"), offset_deg={
        "finger_flexion": 10.0})])
def test_sums_and_selections(block):
    values = ticks(numbers_of(block.inputs[0]))
    found = stepped(block, values)
    assert np.allclose(found - found[0], by_form(block, values))


def test_safety_passes_what_no_limit_touches():
    pulses = np.abs(ticks(2))[:, :, None] * [0.0, 1e-4] + [0.02, 2e-4]
    safety = Safety(channels=2, charge_rise_uc=50.0)
    assert np.array_equal(stepped(safety, pulses), pulses)
    form = safety.linear_form(Context("safety", clock=CLOCK))
    assert form.passes_pulses
    assert np.array_equal(form.d, np.eye(2))


def test_plants_forms_are_their_models():
    finger = Finger(recruitment_curve="linear", full_scale_us=250.0)
    form, model = finger.linear_form("rates"), finger.linear_model("rates")
    pulses = np.column_stack([np.full(4, 0.02), np.arange(4) * 1e-4])
    assert np.allclose(form.b @ pulses[:, 1], model.b @ finger.recruited(pulses))
    assert (form.delay_ns, form.curves) == (20_000_000, None)
    plant = StateSpace(a=((-1.0,),), b=((2.0,),), c=((3.0,),))
    assert (plant.linear_form("y").input, plant.linear_form("y").curves) == ("u", None)
    assert isinstance(plant, LinearPlant)
    assert isinstance(Safety(), LinearBlock)


def test_a_signal_of_stimulation_counts_as_a_number_a_channel():
    assert numbers_of(Finger().inputs[0]) == 4
    assert numbers_of(Finger().outputs[0]) == 3
    assert numbers_of(StateSpace(a=((-1.0,),), b=((2.0,),), c=((3.0,),)).outputs[0]) == 1
