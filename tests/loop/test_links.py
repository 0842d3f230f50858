"""Wires of one link: what their sources send at one tick is one packet. About 5 s."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linear_parts import scalar_loop
from loop_parts import ImpulseProbe, Pass, Sink, Source

import fesloop
from fesloop.analysis.theory.linear_loop import linear_loop
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.duration import Duration
from fesloop.loop.nodes import Node
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

JITTERS = st.one_of(
    st.just(Duration()),
    st.builds(lambda high: Duration(kind="uniform", low_ms=0.0, high_ms=high), st.floats(0.0, 60.0)),
    st.builds(lambda mean: Duration(kind="exponential", mean_ms=mean, high_ms=80.0), st.floats(0.1, 30.0)))
TRANSPORTS = st.fixed_dictionaries({
    "latency_ms": st.floats(0.0, 50.0), "jitter": JITTERS, "loss": st.floats(0.0, 0.45),
    "burst_messages": st.sampled_from([0.0, 1.0, 3.0]), "late": st.sampled_from(["keep-newest", "in-order"])})


def read_by_two(transport, seed, link="radio", rates=("100", "100")):
    """What two sinks read of two sources, (tick, sample of the port) each, over one second."""
    nodes = [Node("fast", Source(), rates[0]), Node("derived", Pass(), rates[1]), Node("a", Sink(), "250"),
             Node("b", Sink(), "250")]
    wires = [Wire("fast.y", "derived.u"), Wire("fast.y", "a.u", link=link, **transport),
             Wire("derived.y", "b.u", link=link, **transport)]
    loop = Loop(Wiring(nodes, wires, seed))
    loop.run_until(NS_PER_S)
    return [loop.states()[name].log for name in "ab"], loop.message_counts()


@settings(max_examples=40, deadline=None)
@given(transport=TRANSPORTS, seed=st.integers(0, 2**31))
def test_signals_of_a_packet_arrive_together_or_not_at_all(transport, seed):
    (first, second), counts = read_by_two(transport, seed)
    assert first == second
    sent, derived = counts["fast.y->a.u"], counts["derived.y->b.u"]
    assert sent == derived


@pytest.mark.parametrize("late", ["keep-newest", "in-order"])
def test_a_message_due_at_a_tick_is_read_at_that_tick_by_whatever_way_it_came(late):
    """A wire with random jitter orders its messages; one without leaves that to its queue."""
    logs, always = [], Duration(kind="uniform", low_ms=6.0, high_ms=6.0)
    for transport in ({"latency_ms": 10.0}, {"latency_ms": 4.0, "jitter": always}):
        nodes = [Node("source", Source(), "100"), Node("sink", Sink(), "100")]
        loop = Loop(Wiring(nodes, [Wire("source.y", "sink.u", late=late, **transport)]))
        loop.run_until(NS_PER_S // 10)
        logs.append(loop.states()["sink"].log)
    assert logs[0] == logs[1]
    assert [sample.value for _, sample in logs[0]][1:4] == [0.0, 1.0, 2.0]


def test_wires_without_a_link_have_losses_and_jitter_of_their_own():
    transport = {"loss": 0.3, "jitter": Duration(kind="uniform", low_ms=0.0, high_ms=30.0)}
    (first, second), _ = read_by_two(transport, 1, link=None)
    assert first != second


def test_a_link_has_random_numbers_by_its_name():
    transport = {"loss": 0.3}
    by_name = [read_by_two(transport, 1, link=name)[0] for name in ("radio", "cable", "radio")]
    assert by_name[0] == by_name[2] != by_name[1]


@settings(max_examples=15, deadline=None)
@given(transport=TRANSPORTS, seed=st.integers(0, 1000), tick=st.integers(0, 30))
def test_the_latency_report_foretells_packets_to_the_nanosecond(transport, seed, tick):
    def wiring(impulse_ns):
        nodes = [Node("plant", ImpulseProbe(impulse_ns=impulse_ns)), Node("sensor", Pass(), "100"),
                 Node("other", Pass(), "100"), Node("controller", Pass(), "100"), Node("sink", Sink(), "100")]
        return Wiring(nodes, [
            Wire("plant.y", "sensor.u"), Wire("sensor.y", "controller.u", link="radio", **transport),
            Wire("plant.y", "other.u"), Wire("other.y", "sink.u", link="radio", **transport),
            Wire("controller.y", "plant.u")], seed)

    path = Loop(wiring(-1)).latency_report().path("plant.y", "plant.u")
    foretold = path.of_tick(tick)
    loop = Loop(wiring(tick * 10 * NS_PER_MS))
    loop.run_until(2 * NS_PER_S)
    acted = [at for at, value in loop.states()["plant"].log if value == 1.0]
    assert acted[:1] == ([foretold.acts_ns] if foretold is not None else [])


@pytest.mark.parametrize(("changed", "words"), [
    ({"latency_ms": 20.0}, ("latency_ms", "links.radio.latency_ms")),
    ({"loss": 0.1}, ("loss", "links.radio.loss")),
    ({"jitter": Duration(kind="fixed", ms=1.0)}, ("jitter", "fixed jitter, and zero jitter")),
    ({"late": "in-order"}, ("late", "keep-newest"))])
def test_wires_that_differ_from_their_link_are_refused(changed, words):
    nodes = [Node("source", Source(), "100"), Node("sink", Sink(names=("u", "v")), "100")]
    with pytest.raises(InputError) as refused:
        Wiring(nodes, [Wire("source.y", "sink.u", link="radio"),
                       Wire("source.y", "sink.v", link="radio", **changed)])
    assert "source.y->sink.v" in str(refused.value)
    assert all(word in str(refused.value) for word in words)


def test_a_packet_has_one_clock():
    with pytest.raises(InputError, match="one clock for all that a packet carries"):
        read_by_two({}, 1, rates=("100", "50"))


def test_theory_refuses_two_random_wires_of_one_link():
    transport = {"loss": 0.1, "link": "radio"}
    assert linear_loop(scalar_loop(1.0, 0.5, sensed=transport)).random
    with pytest.raises(InputError, match="one random wire of a link in the loop"):
        linear_loop(scalar_loop(1.0, 0.5, sensed=transport, stimulated=transport))
    fixed = {"latency_ms": 20.0, "link": "radio"}
    assert not linear_loop(scalar_loop(1.0, 0.5, sensed=fixed, stimulated=fixed)).random


def transports(experiment):
    """{wire: latency_ms, highest jitter in ms, loss} of the wires on the radio."""
    return {wire.name: (wire.latency_ms, wire.jitter.high_ms, wire.loss)
            for wire in experiment.wires if wire.link == "radio"}


@pytest.mark.parametrize(("name", "controller"), [
    ("grasp_ilc", "synergies.synergies->controller.measured"),
    ("grasp_mpc", "synergies.synergies->controller.measured"),
    ("pinch_mpc", "synergies.synergies->controller.measured"),
    ("open_close_ilc", "synergies.synergies->controller.measured"),
    ("identify_grasp", "synergies.synergies->excitation.measured"),
    ("hold_grip_force", "tracker.angles->synergies.angles")])
def test_one_setting_moves_the_posture_of_controller_and_safety_block(name, controller):
    experiment = fesloop.load(name, ["tracker_latency_ms=40", "jitter_ms=20", "loss=0.1"])
    start = [name for name in transports(experiment) if name == "synergies.synergies->reference.measured"]
    assert transports(experiment) == dict.fromkeys(
        (controller, *start, "tracker.angles->safety.posture", "tracker.aligned->safety.aligned"),
        (40.0, 20.0, 0.1))


@pytest.mark.parametrize("variant", ["plant=finger", "tracker=ideal", "tracker=kortier"])
def test_variants_of_the_hand_keep_the_radio(variant):
    experiment = fesloop.load("grasp_mpc", [variant, "tracker_latency_ms=40"])
    assert {"synergies.synergies->controller.measured", "tracker.angles->safety.posture"} \
        <= transports(experiment).keys()
    assert {latency for latency, *_ in transports(experiment).values()} == {40.0}


def test_a_document_has_the_transport_of_a_link_once():
    experiment = fesloop.load("open_close_ilc", ["loss=0.1"])
    document = experiment.document()
    assert document["links"]["radio"]["loss"] == 0.1
    assert not any("loss" in wire for wire in document["wires"] if "link" in wire)
    assert from_document(document) == experiment


@pytest.mark.parametrize(("setting", "words"), [
    ('wires."tracker.angles->safety.posture".latency_ms=5', ("link = 'radio'", "set links.radio.latency_ms")),
    ('wires."tracker.angles->safety.posture".link=radoi', ("no link 'radoi'", "did you mean 'radio'")),
    ("links.radio.latency=5", ("links.radio.latency", "latency_ms")),
    ("links.radio.loss=2", ("loss", "[0, 1)"))])
def test_mistakes_with_links_are_named(setting, words):
    with pytest.raises(InputError) as refused:
        fesloop.load("grasp_mpc", [setting])
    assert all(word in str(refused.value) for word in words), str(refused.value)
