import math
import pickle
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, read
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import NEVER, Port, Sample
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.models.electrode_arrays import VirtualElectrode
from plants import stimulator as generations
from plants.electrodes import Electrodes
from plants.stimulator import PRESETS, Limits, Stimulator, given_pulse

ELEMENTS, CHARGE, CHARGE_RATE, ELEMENT_CHARGE, ELEMENT_CHARGE_RATE = range(5)


def run(stimulator, commands, shares=None, slots=8):
    """Outputs of the slots after a command, each stacked, and reports; commands by slot, in mA and us."""
    state, tick, seen = stimulator.init(Context("stimulator")), Tick(), []
    absent = Sample(np.zeros((stimulator.channels, stimulator.elements)), NEVER, NEVER, NEVER)
    command = Sample(np.zeros((stimulator.channels, 2)), NEVER, NEVER, NEVER)
    mux = absent
    for slot in range(slots):
        tick.index, tick.time_ns = slot, stimulator.clock.tick(slot)
        if slot in commands:
            given_command = np.array(commands[slot], dtype=float) * (1e-3, 1e-6)
            command = Sample(given_command, *(tick.time_ns,) * 3)
        if shares is not None and slot in shares:
            mux = Sample(np.array(shares[slot], dtype=float), *(tick.time_ns,) * 3)
        seen.append(stimulator.step(state, (command, mux), tick))
    return [np.array(values) for values in zip(*seen, strict=True)], tick.reports


def quick(**parameters):
    """A device without latency, with three elements."""
    shared = {"preset": "generation3", "channels": 1, "elements": 3, "latency_ms": 0.0}
    return Stimulator(**shared | parameters)


@dataclass(frozen=True)
class Commanding:
    """A controller whose two channels come on at its fourth tick."""

    inputs = ()
    outputs = (Port("stimulation", (2, 2), "A,s"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (np.full((2, 2), (0.03, 3e-4)) * (tick.index >= 4),)


@pytest.mark.parametrize(("preset", "latency_ms"), [
    ("generation1", 24), ("generation2", 10), ("generation3", 1)])
@pytest.mark.parametrize("frequency", ["40", "285/7", "33.3"])
def test_pulses_come_in_their_slots_no_earlier_than_the_latency(preset, latency_ms, frequency):
    """In a loop: channel c fires at (8 n + c) / 8 f, at first when command, wire and device allow it."""
    stimulator = Stimulator(preset=preset, frequency_hz=frequency)
    nodes = [Node("controller", Commanding(), "100"), Node("stimulator", stimulator),
             Node("arm", Electrodes(), stimulator.clock)]
    wires = [Wire("controller.stimulation", "stimulator.stimulation", latency_ms=0.5),
             Wire("stimulator.elements", "arm.elements")]
    recorder = Recorder()
    Loop(Wiring(nodes, wires), recorder=recorder).run_until(200 * NS_PER_MS)
    slot_ns = Fraction(10**9) / (8 * Fraction(frequency))
    from_ns = (40 + latency_ms) * NS_PER_MS + NS_PER_MS // 2
    for channel in range(2):
        fired = [time for _, time, *_, values in recorder.blocks["stimulator"] if values[0][channel, 0] > 0.0]
        expected = [math.floor((8 * n + channel) * slot_ns) for n in range(10)]
        assert fired == [time for time in expected if from_ns <= time <= 200 * NS_PER_MS]
    recruited = [(time, values[0].any()) for _, time, *_, values in recorder.blocks["arm"]]
    assert min(time for time, any_recruited in recruited if any_recruited) == min(
        time for _, time, *_, values in recorder.blocks["stimulator"] if values[0].any())
    on = [any_recruited for _, any_recruited in recruited]
    assert on == sorted(on)  # without a gap from one pulse to the next


def test_only_the_slots_channel_has_a_pulse():
    stimulator = Stimulator(channels=2, elements=4, latency_ms=0.0, electrodes=(
        VirtualElectrode(elements=(0, 2), shares=(0.25, 0.75)), VirtualElectrode(elements=(1, 2))))
    (elements, *_), _ = run(stimulator, {0: [[20.0, 300.0], [10.0, 200.0]]}, slots=16)
    expected = np.zeros((16, 4, 3))
    expected[[0, 8], 0] = 5e-3, 300e-6, 40.0
    expected[[0, 8], 2] = 15e-3, 300e-6, 40.0
    expected[[1, 9], 1] = expected[[1, 9], 2] = 5e-3, 200e-6, 40.0
    np.testing.assert_allclose(elements, expected, rtol=1e-12)


def test_charge_is_accounted_for_each_channel_and_element():
    stimulator = Stimulator(channels=2, elements=3, latency_ms=0.0, frequency_hz="25", electrodes=(
        VirtualElectrode(elements=(0, 1)), VirtualElectrode(elements=(1, 2), shares=(0.25, 0.75))))
    outputs, _ = run(stimulator, {0: [[20.0, 300.0], [40.0, 200.0]]})
    charge = np.array([6e-6, 8e-6])
    np.testing.assert_allclose(outputs[CHARGE][-1], charge)
    np.testing.assert_allclose(outputs[CHARGE_RATE][-1], 25.0 * charge)
    np.testing.assert_allclose(outputs[ELEMENT_CHARGE][-1], [3e-6, 3e-6, 6e-6])
    np.testing.assert_allclose(outputs[ELEMENT_CHARGE_RATE][-1], [75e-6, 125e-6, 150e-6])


def test_charge_adds_up_to_that_of_the_pulses_of_a_second():
    outputs, _ = run(quick(channels=2), {0: [[20.0, 300.0], [40.0, 200.0]]}, slots=8 * 40 * 2)
    second = outputs[ELEMENTS][8 * 40:]
    delivered = (second[..., 0] * second[..., 1]).sum(axis=0)
    np.testing.assert_allclose(outputs[ELEMENT_CHARGE_RATE][-1], delivered)


@settings(deadline=None, max_examples=300)
@given(st.floats(-0.01, 0.3), st.floats(-1e-5, 1e-3), st.floats(1.0, 70.0),
       st.sampled_from([100.0, 500.0, 5e3]))
def test_a_given_pulse_is_in_range_on_the_steps_and_within_the_limits(current, width, charge_uc, load):
    limits = Stimulator(charge_max_uc=charge_uc, load_ohm=load).limits
    given_current, given_width, cut = given_pulse(limits, current, width)
    if given_current == 0.0 or given_width == 0.0:
        assert given_current == given_width == 0.0
        assert cut or current == 0.0 or width == 0.0
        return
    for value, step in ((given_current, 2e-3), (given_width, 1e-6)):
        assert value / step == pytest.approx(round(value / step), abs=1e-6)
    assert given_current <= min(0.126, 150.0 / load) * (1.0 + 1e-8)
    assert 20e-6 * (1.0 - 1e-8) <= given_width <= 500e-6 * (1.0 + 1e-8)
    assert given_current * given_width <= 1e-6 * charge_uc * (1.0 + 1e-8)
    assert 2.0 * 500.0 * given_current**2 * given_width <= 0.3 * (1.0 + 1e-8)
    if not cut:
        assert abs(given_current - current) <= 1e-3 * (1.0 + 1e-8)
        assert abs(given_width - width) <= 0.5e-6 * (1.0 + 1e-8)


@pytest.mark.slow
@settings(deadline=None, max_examples=400)
@given(st.floats(1.0, 150.0), st.floats(0.1, 3.0), st.floats(300.0, 5e3), st.floats(30.0, 800.0),
       st.floats(0.3, 7.0), st.floats(0.5, 70.0), st.floats(1.0, 300.0), st.floats(50.0, 2000.0))
def test_a_limit_between_two_steps_is_met_by_the_one_below(
    most_ma, step_ma, load, most_us, step_us, charge_uc, wish_ma, wish_us
):
    """What a limit cuts is within it, and one step more would not be."""
    limits = Limits(1e-3 * most_ma, 1e-3 * step_ma, 150.0 / load, 20e-6, 1e-6 * most_us, 1e-6 * step_us,
                    1e-6 * charge_uc)
    slack = 1.0 + 1e-8
    for never_more in (False, True):
        current, width, cut = given_pulse(limits, 1e-3 * wish_ma, 1e-6 * wish_us, never_more=never_more)
        if current == 0.0:
            continue
        most_a = min(1e-3 * most_ma, 150.0 / load)
        most_s = min(1e-6 * most_us, 1e-6 * charge_uc / current, 0.3 / (2.0 * 500.0 * current**2))
        assert current <= most_a * slack
        assert width <= most_s * slack
        if cut & (generations.CURRENT | generations.VOLTAGE):
            assert (current + 1e-3 * step_ma) * slack > most_a
        if cut & (generations.WIDTH | generations.CHARGE | generations.ENERGY):
            assert (width + 1e-6 * step_us) * slack > most_s
        if never_more:
            assert current <= 1e-3 * wish_ma * slack
            assert width <= 1e-6 * wish_us * slack


@pytest.mark.parametrize(("preset", "step"), [
    ("generation1", 2.0), ("generation2", 2.0), ("generation3", 0.5)])
def test_what_is_on_the_steps_is_given_unchanged(preset, step):
    limits = Stimulator(preset=preset, charge_max_uc=63.0).limits
    for current in np.arange(step, 126.0 + step / 2.0, step):
        for width in (20, 21, 299, 499, 500):
            wish = current * 1e-3, width * 1e-6
            assert given_pulse(limits, *wish) == pytest.approx((*wish, 0), rel=1e-9)


@pytest.mark.parametrize(("wish", "given_ma_us", "status", "parameters"), [
    ((130.0, 100.0), (126.0, 100.0), "current_limited", {}),
    ((60.0, 100.0), (50.0, 100.0), "voltage_limited", {"load_ohm": 3000.0}),
    ((0.2, 100.0), (0.0, 0.0), "current_too_small", {}),
    ((10.0, 700.0), (10.0, 500.0), "width_limited", {}),
    ((10.0, 12.0), (0.0, 0.0), "width_too_short", {}),
    ((60.0, 400.0), (60.0, 333.0), "charge_limited", {}),
    ((120.0, 400.0), (0.0, 0.0), "charge_limited", {"charge_max_uc": 2.0}),
    ((700.0, 800.0), (700.0, 612.0), "energy_limited", {
        "current_max_ma": 700.0, "width_max_us": 800.0, "charge_max_uc": 1e3, "compliance_v": 500.0}),
    ((-5.0, 100.0), (0.0, 0.0), "bad_input", {}), ((math.nan, 100.0), (0.0, 0.0), "bad_input", {}),
    ((5.0, math.inf), (0.0, 0.0), "bad_input", {})])
def test_what_cannot_be_given_is_cut_and_told_once(wish, given_ma_us, status, parameters):
    stimulator = quick(element_area_cm2=1e3, **parameters)
    outputs, reports = run(stimulator, {0: [wish], 16: [[10.0, 100.0]]}, slots=32)
    np.testing.assert_allclose(outputs[ELEMENTS][8, 0, :2], np.array(given_ma_us) * (1e-3, 1e-6), rtol=1e-9)
    np.testing.assert_allclose(outputs[ELEMENTS][16, 0, :2], (10e-3, 100e-6), rtol=1e-9)
    assert [told for told, _ in reports][:1] == [status]
    assert "channel 0" in reports[0][1]
    assert len(reports) == (2 if status == "charge_limited" and not any(given_ma_us) else 1)


def test_current_density_calls_for_attention_and_cuts_nothing():
    """Root mean square over the period of two phases of 20 mA and 300 us, 40 times a second: 3.1 mA."""
    period = np.zeros(25000)
    period[:300], period[400:700] = 20.0, -20.0
    density = np.sqrt(np.mean(period**2)) / 1.54
    outputs, reports = run(quick(channels=2), {0: [[20.0, 300.0], [10.0, 300.0]]}, slots=32)
    assert outputs[ELEMENTS][:, :, 0].max() == pytest.approx(20e-3)
    assert [status for status, _ in reports] == ["current_density"]
    assert density > 2.0
    assert f"element 0 ({density:.2g})" in reports[0][1]


def test_current_density_is_that_of_each_elements_own_area():
    _, reports = run(quick(channels=2, element_area_cm2=(1.54, 6.16, 1.54)),
                           {0: [[20.0, 300.0], [40.0, 300.0]]}, slots=32)
    assert [status for status, _ in reports] == ["current_density"]
    assert "under element 0 (" in reports[0][1]  # element 1 has twice the current on four times the area
    with pytest.raises(InputError, match=r"element_area_cm2: shape \(2,\); allowed: shape \(3,\)"):
        quick(element_area_cm2=(1.0, 2.0))


def test_a_channel_is_switched_onto_other_elements_while_it_runs():
    virtual = [[0.0, 0.5, 0.5]]
    outputs, reports = run(quick(), {0: [[10.0, 200.0]]}, shares={
        4: virtual, 12: [[0.0, 0.9, 0.0]], 20: [[-1.0, 1.0, 1.0]], 28: [[0.0, 0.0, 0.0]]}, slots=40)
    currents = outputs[ELEMENTS][::8, :, 0]
    np.testing.assert_allclose(currents, [
        [0.01, 0.0, 0.0], [0.0, 0.005, 0.005], [0.0, 0.005, 0.005], [0.0, 0.005, 0.005], [0.0, 0.0, 0.0]])
    assert [status for status, _ in reports] == ["bad_multiplexing"]
    assert "channel 0 add up to 0.9" in reports[0][1]
    assert not outputs[ELEMENT_CHARGE][-1].any()


def test_takes_the_number_of_channels_from_the_wire():
    assert Stimulator().inputs[0].shape == (None, 2)
    settled = Stimulator().resolve({"stimulation": (3, 2)})
    assert settled.outputs[CHARGE].shape == (3,)
    with pytest.raises(InputError, match="1 to 8"):
        Stimulator().resolve({"stimulation": (9, 2)})


def test_the_clock_is_that_of_the_slots():
    assert Stimulator(frequency_hz="2000/49").clock == RateClock.from_rate("16000/49")


def test_an_experiment_tells_that_electrodes_follow_the_stimulators_clock():
    _, document = read("finger_pid_latency")
    electrodes = [{"elements": [3]}, {"elements": [4, 5]}, {"elements": [20]}, {"elements": [40]}]
    document["blocks"] |= {
        "stimulator": {"kind": "stimulator", "electrodes": electrodes},
        "arm": {"kind": "electrodes", "clock": "stimulator", "axons": {"count": 16}}}
    document["wires"] += [{"from": "safety.stimulation", "to": "stimulator.stimulation"},
                          {"from": "stimulator.elements", "to": "arm.elements"}]
    experiment = from_document(document)
    told = experiment.document()
    assert told["blocks"]["arm"]["clock"] == "stimulator"
    assert from_document(told) == experiment
    assert pickle.loads(pickle.dumps(experiment)) == experiment


def test_presets_are_of_three_generations():
    newest = PRESETS["generation3"]
    assert {preset.current_step_ma for preset in PRESETS.values()} == {2.0, 0.5}
    assert (PRESETS["generation1"].latency_ms, newest.latency_ms) == (24.0, 1.0)
    assert all((p.channels, p.current_max_ma, p.width_min_us, p.width_max_us) == (8, 126.0, 20.0, 500.0)
               for p in PRESETS.values())


@pytest.mark.parametrize(("parameters", "named"), [
    ({"preset": "generation9"}, "stimulator.preset.*did you mean"),
    ({"channels": 9}, "stimulator.channels"),
    ({"frequency_hz": "60"}, "stimulator.frequency_hz"),
    ({"frequency_hz": "fast"}, "stimulator.frequency_hz"),
    ({"latency_ms": -1.0}, "stimulator.latency_ms"), ({"charge_max_uc": 0.0}, "stimulator.charge_max_uc"),
    ({"current_step_ma": 200.0}, "current_step_ma"), ({"compliance_v": 600.0}, "stimulator.compliance_v"),
    ({"width_max_us": 2000.0}, "stimulator.width_max_us.*within a slot"),
    ({"electrodes": (VirtualElectrode(elements=(59,)),)}, r"electrodes\[0\].elements: element 59 does not"),
    ({"channels": 2, "electrodes": (VirtualElectrode(elements=(5,)),)}, "stimulator.electrodes: 1 virtual"),
    ({"channels": 8, "elements": 4}, "element 4 does not exist")])
def test_bad_parameters_are_named(parameters, named):
    with pytest.raises(InputError, match=named):
        Stimulator(**parameters)


@pytest.mark.parametrize(("elements", "shares"), [
    ((), ()), ((1, 1), ()), ((-1,), ()), ((1, 2), (0.5, 0.4)), ((1, 2), (1.0,)), ((1, 2), (1.5, -0.5))])
def test_bad_virtual_electrodes_are_named(elements, shares):
    with pytest.raises(InputError, match="virtual_electrode"):
        VirtualElectrode(elements=elements, shares=shares)


@pytest.mark.parametrize("never_more", [False, True])
@given(current=st.floats(0.0, 1.0), width=st.floats(0.0, 1e-3))
def test_a_wish_for_no_pulse_is_met_and_not_called_too_small_or_too_short(never_more, current, width):
    limits = generations.Limits(
        current_max=0.1, current_driven=0.1, current_step=1e-3, width_min=2e-5, width_max=5e-4,
        width_step=1e-6, charge_max=5e-5)
    for wish in ((0.0, width), (current, 0.0)):
        assert generations.given_pulse(limits, *wish, never_more=never_more) == (0.0, 0.0, 0)
