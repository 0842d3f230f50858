"""Which experiments are linear loops, and how the others are turned away."""

import numpy as np
import pytest
from linear_parts import scalar_loop, sensed_loop, uniform

from controllers.open_loop import Programme
from fesloop.analysis.theory import critical_latency_ms, linear_loop, stationary_cost
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import Experiment
from fesloop.experiment.score_spec import Score
from fesloop.loop.duration import Duration
from fesloop.loop.nodes import Node
from fesloop.loop.wire import Wire

SENSED = 'wires."tracker.angles->controller.measured"'
STIMULATED = 'wires."controller.stimulation->finger.stimulation"'


@pytest.mark.parametrize(("setting", "named"), [
    ("blocks.tracker.walk_deg=0.1", "tracker.walk_deg"),
    ("blocks.tracker.drift_deg_s=0.1", "tracker.drift_deg_s"),
    ("blocks.tracker.quantisation_deg=0.1", "tracker.quantisation_deg"),
    ("blocks.tracker.rate=285.714", "285.714"),
    ("blocks.finger.fatigue={}", "finger.fatigue"),
    ("blocks.finger.recruitment_curve=lognormal", "controller.recruitment"),
    ('blocks.controller.execution={kind="uniform",low_ms=0,high_ms=5}', "controller.execution"),
    ('blocks.controller.execution={kind="fixed",ms=21}', "controller.execution"),
    (STIMULATED + '.jitter={kind="uniform",low_ms=0,high_ms=5}', "->finger.stimulation"),
    (SENSED + ".late=in-order", None),
])
def test_what_is_not_covered_is_named_in_one_line(setting, named):
    experiment = load("linear_loop", (setting,))
    if named is None:
        stationary_cost(experiment)  # in order without jitter is nothing special
        experiment = load("linear_loop", (setting, "jitter_ms=5"))
        named = "in-order"
    with pytest.raises(InputError) as fault:
        stationary_cost(experiment)
    assert named in str(fault.value)
    assert "\n" not in str(fault.value)
    assert "theory of a linear loop" in str(fault.value)


def test_jitter_on_two_wires_or_with_losses_in_bursts_is_turned_away():
    plant_wire = 'wires."finger.angles->tracker.angles".jitter={kind="uniform",low_ms=0,high_ms=5}'
    with pytest.raises(InputError, match="one such wire"):
        linear_loop(load("linear_loop", ("jitter_ms=5", plant_wire)))
    with pytest.raises(InputError, match="burst_messages"):
        linear_loop(load("linear_loop", ("jitter_ms=5", "loss=0.2", f"{SENSED}.burst_messages=4")))


@pytest.mark.parametrize(("name", "named"), [
    ("finger_mpc", "Mpc"), ("grasp_ilc", "plants muscles, hand are on a loop"),
    ("recruitment_sweep", "no plant's output returns to it")])
def test_what_is_not_linear_is_named(name, named):
    with pytest.raises(InputError, match=named):
        linear_loop(load(name))


def test_a_plant_that_only_a_watchdog_hears_of_is_on_no_linear_loop():
    nodes = {node.name: node for node in load("finger_pid_latency").nodes}
    steady = Programme(times_s=(0.0,), current_ma=((20.0,) * 4,), width_us=((100.0,) * 4,))
    watched = Experiment(
        name="watched", duration_s=1.0,
        nodes=(Node("programme", steady, rate=50), nodes["safety"], nodes["finger"], nodes["tracker"]),
        wires=(Wire("programme.stimulation", "safety.stimulation"), Wire("finger.angles", "tracker.angles"),
               Wire("tracker.angles", "safety.posture"), Wire("safety.stimulation", "finger.stimulation")))
    with pytest.raises(InputError, match="feeds no output back"):
        linear_loop(watched)


def test_jitter_that_cannot_vary_is_latency():
    fixed = load("linear_loop", (SENSED + '.jitter={kind="fixed",ms=12.5}',))
    still = load("linear_loop", (SENSED + '.jitter={kind="uniform",low_ms=12.5,high_ms=12.5}',))
    late = stationary_cost(load("linear_loop", ("latency_ms=42.5", "jitter_ms=0")))
    assert all(np.array_equal(stationary_cost(each).rms, late.rms) for each in (fixed, still))
    assert not linear_loop(still).random


def test_the_delay_of_the_plant_itself_is_latency_of_what_comes_to_it():
    muscles, wire = (
        stationary_cost(load("linear_loop", (f"blocks.finger.delay_ms={delay}", f"actuation_ms={latency}")))
        for delay, latency in ((20, 5.5), (0, 25.5)))
    assert np.array_equal(muscles.rms, wire.rms)


def test_jitter_of_a_nanosecond_is_as_good_as_none():
    wire = {"latency_ms": 5.0}
    sure, hardly = (stationary_cost(sensed_loop(-4.0, 14.0, 1.0, {**wire, **more}, plant_rate=100))
                    for more in ({}, {"jitter": uniform(0, 1e-6)}))
    assert hardly.rms[0] == pytest.approx(sure.rms[0], rel=1e-8)


def test_where_several_messages_come_at_once_the_newest_counts():
    # 20 ms of latency on messages every 10 ms, read every 20 ms: as if the sensor were as slow as its reader.
    quick, slow = (stationary_cost(sensed_loop(-4.0, 10.0, 1.0, {"latency_ms": 20.0}, rate))
                   for rate in (100, 50))
    assert quick.rms[0] == pytest.approx(slow.rms[0], rel=1e-12)


def test_a_delay_of_the_tracker_acts_as_latency_in_its_ticks():
    """The ideal tracker adds its noise after the delay, so the poles agree and the cost nearly does."""
    delayed = load("linear_loop", ("blocks.tracker.delay_ms=15", "latency_ms=0"))
    late = load("linear_loop", ("latency_ms=20",))
    assert stationary_cost(delayed).spectral_radius == pytest.approx(stationary_cost(late).spectral_radius)


def test_a_controller_without_integral_gain_comes_to_rest():
    none, hardly = (load("linear_loop", (f"ki={ki}",)) for ki in (0.0, 1e-5))
    assert stationary_cost(none).stable
    assert stationary_cost(none).rms == pytest.approx(stationary_cost(hardly).rms, rel=1e-3)


def test_what_moves_the_reference_belongs_to_the_loop():
    # The reference is what is measured: only the derivative is left, as with gains of zero.
    blocks = 'blocks.controller.{}=[0, 0, 0]'
    free = load("linear_loop", (blocks.format("kp"), blocks.format("ki"), "latency_ms=0"))
    plain_nodes = {node.name: node for node in load("linear_loop", ("latency_ms=0", "ki=0")).nodes}
    wires = [wire for wire in free.wires if wire.target != "controller.reference"]
    follows = Experiment(name="follows", duration_s=1.0, nodes=tuple(
        plain_nodes[name] for name in ("controller", "finger", "tracker")), record=free.record, score=Score(
        truth="finger.angles"), wires=(*wires, Wire("tracker.angles", "controller.reference")))
    assert stationary_cost(follows).rms == pytest.approx(stationary_cost(free).rms, rel=1e-9)


def test_offsets_of_clocks_count():
    aligned = load("linear_loop", ("latency_ms=0",))
    offset = load("linear_loop", ("latency_ms=0", "blocks.tracker.offset_ms=5"))
    late = load("linear_loop", ("latency_ms=5", "blocks.tracker.offset_ms=0"))
    assert stationary_cost(offset).rms[0] > stationary_cost(aligned).rms[0]
    # tracked at 5, 15, ... and read at 0, 20, ...: 5 ms old; sent at 10 and read at 20: 10 ms old
    assert stationary_cost(offset).rms[0] < stationary_cost(late).rms[0]


def test_rates_of_any_ratio_that_soon_come_together():
    cost = stationary_cost(sensed_loop(-4.0, 10.0, 1.0, {"latency_ms": 3.0}, "60", plant_rate=1000))
    assert cost.period_s == pytest.approx(0.1)
    assert cost.stable


def test_names_of_outputs_come_from_the_score():
    assert stationary_cost(load("linear_loop")).names == ("MCP", "PIP", "DIP")
    assert stationary_cost(scalar_loop(-1.0, 5.0)).names == ("y[0]",)


def test_a_wire_keeps_its_jitters_least_when_its_latency_is_searched():
    jitter = Duration(kind="uniform", low_ms=-2.0, high_ms=10.0)
    loop = sensed_loop(0.0, 30.0, 1.0, {"latency_ms": 2.0, "jitter": jitter})
    assert critical_latency_ms(loop, "sensor.y->feedback.y", up_to_ms=60.0) > 2.0
