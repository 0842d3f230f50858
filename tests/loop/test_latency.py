"""latency_report() against an impulse sent through the running loop, to the nanosecond."""

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import count, takewhile

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from loop_parts import ImpulseProbe, Pass

from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.latency import LatencyReport, Transit
from fesloop.loop.nodes import Node
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

rates = st.one_of(
    st.sampled_from(["7", "60", "285.714", "1000", "2000/7", "50", "100", "1000/3"]),
    st.fractions(7, 1000, max_denominator=97).map(str))
milliseconds = st.integers(0, 250 * NS_PER_MS).map(lambda ns: ns / NS_PER_MS)
jitters = st.one_of(
    st.just(ZERO),
    st.just(ZERO),
    st.floats(0, 40).map(lambda ms: Duration(kind="uniform", low_ms=0.0, high_ms=ms)),
    st.floats(0, 10).map(lambda ms: Duration(kind="normal", mean_ms=ms, sd_ms=ms, low_ms=0, high_ms=3 * ms)),
    st.floats(0.1, 10).map(lambda ms: Duration(kind="exponential", mean_ms=ms, high_ms=60.0)))
executions = st.one_of(jitters, st.floats(0, 60).map(lambda ms: Duration(kind="fixed", ms=ms)))
grids = st.one_of(st.none(), rates.map(RateClock.from_rate))


@st.composite
def chains(draw):
    """A plant sampled into one to three blocks, one after the other, back into the plant."""
    blocks = draw(st.integers(1, 3))
    grid = draw(grids)
    names = [f"b{i}" for i in range(blocks)]
    ends = ["plant.y", *(f"{n}.{p}" for n in names for p in ("u", "y")), "plant.u"]
    wires = [Wire(ends[2 * i], ends[2 * i + 1], latency_ms=draw(milliseconds), jitter=draw(jitters),
                  loss=draw(st.sampled_from([0.0, 0.0, 0.3])),
                  burst_messages=draw(st.sampled_from([0, 0, 1, 4])),
                  late=draw(st.sampled_from(["keep-newest", "in-order"]))) for i in range(blocks + 1)]
    if draw(st.booleans()):
        wires[0] = replace(wires[0], rate=draw(rates), offset_ms=draw(milliseconds))
    nodes = [Node(n, Pass(), rate=draw(rates), offset_ms=draw(milliseconds), execution=draw(executions))
             for n in draw(st.permutations(names))]
    return grid, nodes, wires, draw(st.integers(0, 2**32))


def impulse_test(grid, nodes, wires, seed, captured_ns):
    """First instant at which the plant's input is 1, the output having been 1 at `captured_ns` only."""
    plant = Node("plant", ImpulseProbe(impulse_ns=captured_ns, grid=grid))
    loop = Loop(Wiring([plant, *nodes], wires, seed))
    loop.run_until(captured_ns + 3 * NS_PER_S)
    list(loop._plants["plant"].values_through((captured_ns + 3 * NS_PER_S,)))
    return next((instant for instant, value in loop.states()["plant"].log if value == 1.0), None)


@pytest.mark.slow
@given(chains(), st.integers(0, 60))
@settings(max_examples=300, deadline=None)
def test_latency_of_tick_k_equals_an_impulse_test(chain, k):
    grid, nodes, wires, seed = chain
    wiring = Wiring([Node("plant", ImpulseProbe(grid=grid)), *nodes], wires, seed)
    path = Loop(wiring).latency_report().path("plant.y", "plant.u")
    latency = path.of_tick(k)
    sampled = path._sampling.tick(k)
    captured = sampled if grid is None else grid.tick(grid.last_at_or_before(sampled))
    if grid is not None:
        # One grid step may be sampled several times; an impulse of the step then has several ways.
        around = [path._sampling.tick(j) for j in (max(k - 1, 0), k + 1)]
        assume(all(grid.tick(grid.last_at_or_before(t)) != captured for t in around if t != sampled))
    acts = impulse_test(grid, nodes, wires, seed, captured)
    assert acts == (None if latency is None else latency.acts_ns)
    if latency is not None:
        assert latency.captured_ns == captured
        assert sum(latency.stages_ns) == latency.total_ns
        assert min(latency.stages_ns) >= 0


def test_the_stages_of_a_known_chain():
    """1 kHz grid plant, sampled at 60 Hz, 10 ms to a 40 Hz block that takes 3 ms, 5.5 ms back."""
    grid = RateClock.from_rate("1000")
    wires = [Wire("plant.y", "b.u", latency_ms=10, rate="60"), Wire("b.y", "plant.u", latency_ms=5.5)]
    nodes = [Node("plant", ImpulseProbe(grid=grid)),
             Node("b", Pass(), rate="40", execution=Duration(kind="fixed", ms=3))]
    path = Loop(Wiring(nodes, wires)).latency_report().path("plant.y", "plant.u")
    assert path.stages == ("plant holds its last step", "wire plant.y->b.u", "b waits for its tick",
                           "b executes", "wire b.y->plant.u", "plant waits for its step")
    # sample 2 is due at 33.333333 ms: the step of 33 ms, at b from 43.333333 on, read at 50, out at 53
    latency = path.of_tick(2)
    assert latency.captured_ns == 33 * NS_PER_MS
    assert latency.stages_ns == (333_333, 10_000_000, 6_666_667, 3_000_000, 5_500_000, 500_000)
    assert latency.total_ns == 26 * NS_PER_MS
    # sample 1 (16.666666) is there from 26.666666 on and overwritten before 50
    assert path.of_tick(1) is None


def test_behind_a_lost_message_nobody_looks_for_the_next_that_is_not(monkeypatch):
    """Else a report takes as many looks as there are samples, times those that are lost in a row."""
    looked, arrival_ns = [], Transit.arrival_ns
    monkeypatch.setattr(Transit, "arrival_ns", lambda self, index: (looked.append(index),
                                                                   arrival_ns(self, index))[1])
    wires = [Wire("plant.y", "b.u", loss=0.999), Wire("b.y", "plant.u")]
    wiring = Wiring([Node("plant", ImpulseProbe()), Node("b", Pass(), rate="1000")], wires)
    path = LatencyReport(wiring, horizon_ns=2 * NS_PER_S).path("plant.y", "plant.u")
    path.summary()
    assert len(looked) < 3 * 2001 + 20_000, "each sample, and a few thousand behind the two that are not lost"


def test_who_waits_for_all_messages_before_looks_back_to_the_last_that_is_known(monkeypatch):
    """Else each message of a wire in order looks at as many as may be under way: here 2000."""
    looked, raw = [], Transit._raw_arrival_ns
    monkeypatch.setattr(Transit, "_raw_arrival_ns", lambda self, index: (looked.append(index),
                                                                        raw(self, index))[1])
    late = Duration(kind="uniform", low_ms=0.0, high_ms=2000.0)
    wiring = Wiring([Node("plant", ImpulseProbe()), Node("b", Pass(), rate="1000")],
                    [Wire("plant.y", "b.u", jitter=late, late="in-order"), Wire("b.y", "plant.u")])
    path = LatencyReport(wiring, horizon_ns=NS_PER_S // 10).path("plant.y", "plant.u")
    path.summary()
    assert len(looked) < 100 * 2 * 2100, "for each of the hundred samples at those under way, twice"


def test_an_hour_in_the_tick_is_still_exact():
    wires = [Wire("plant.y", "b.u", rate="285.714"), Wire("b.y", "plant.u")]
    nodes = [Node("plant", ImpulseProbe()), Node("b", Pass(), rate="1000")]
    path = Loop(Wiring(nodes, wires)).latency_report().path("plant.y", "plant.u")
    index = 1_028_571
    latency = path.of_tick(index)
    sampled = Fraction(index * NS_PER_S * 1000, 285_714)
    assert latency.captured_ns == int(sampled)
    assert latency.acts_ns == -(-int(sampled) // NS_PER_MS) * NS_PER_MS


@given(chains())
@settings(max_examples=60, deadline=None)
def test_the_least_latency_is_that_of_the_quickest_sample(chain):
    grid, nodes, wires, seed = chain
    wiring = Wiring([Node("plant", ImpulseProbe(grid=grid)), *nodes], wires, seed)
    path = LatencyReport(wiring, horizon_ns=NS_PER_S // 5).path("plant.y", "plant.u")
    assert path.least_ns() == min((latency.total_ns for latency in path.ticks()), default=None)


def test_paths_through_a_block_are_those_of_all_that_pass_it():
    wires = [Wire("plant.y", "first.u"), Wire("first.y", "second.u"),
             Wire("second.y", "plant.u", latency_ms=1),
             Wire("plant.y", "third.u"), Wire("third.y", "other.u", latency_ms=2)]
    nodes = [Node("plant", ImpulseProbe()), Node("other", ImpulseProbe()),
             *(Node(name, Pass(), rate="100") for name in ("first", "second", "third"))]
    wiring = Wiring(nodes, wires)
    every = {path.name for path in LatencyReport(wiring).paths}
    assert every == {"plant.y -> first -> second -> plant.u", "plant.y -> third -> other.u"}
    for name, way in (("second", "plant.y -> first -> second -> plant.u"),
                      ("third", "plant.y -> third -> other.u"), ("other", "plant.y -> third -> other.u")):
        assert [path.name for path in LatencyReport(wiring, through=wiring.node(name)).paths] == [way]


def beating(duration_s, **wire):
    """Report on a plant sampled at 60 Hz for a block at 60.01 Hz, which are in step again after 100 s."""
    wires = [Wire("plant.y", "b.u", rate="60", **wire), Wire("b.y", "plant.u")]
    wiring = Wiring([Node("plant", ImpulseProbe()), Node("b", Pass(), rate="60.01")], wires)
    return LatencyReport(wiring, horizon_ns=duration_s * NS_PER_S)


def test_the_greatest_latency_of_rates_that_hardly_differ_is_that_of_the_whole_run():
    """A sample waits for the next tick: k / 60 s rounded up to the grid of 1 / 60.01 s."""
    waits = [(-(-k * 6001 // 6000)) * Fraction(100, 6001) - Fraction(k, 60) for k in range(6000)]
    for duration_s in (100, 3600):
        report = beating(duration_s)
        total = report.path("plant.y", "plant.u").summary()[-1]
        assert abs(total.most_ns - max(waits) * NS_PER_S) <= 1
        assert abs(total.mean_ns - sum(waits) / 6000 * NS_PER_S) < 1
        assert report.coverage() == f"Every sample in the {duration_s} s of a trial counts."
    assert 16.66e6 < total.most_ns < NS_PER_S / 60


def test_a_budget_that_is_not_of_the_whole_run_says_so():
    report = beating(3600, loss=0.1)
    path = report.path("plant.y", "plant.u")
    assert path.covered_ns == path._sampling.tick(20_000) == 333_333_333_333
    assert report.coverage() == ("Only samples in the first 333.333333 s of a trial of 3600 s count: later "
                                 "ones can take longer.")
    assert beating(10, loss=0.1).coverage(3) == (
        "Every sample in the 10 s of a trial counts. What is random is as in the first of 3 trials.")


def test_the_sample_at_the_end_of_a_run_is_not_part_of_it():
    """At 10 Hz a run of 0.3 s has the samples of 0, 100 and 200 ms, of which the last waits for 70 ms."""
    wires = [Wire("plant.y", "b.u", rate="10"), Wire("b.y", "plant.u")]
    wiring = Wiring([Node("plant", ImpulseProbe()), Node("b", Pass(), rate="100/9")], wires)
    path = LatencyReport(wiring, horizon_ns=3 * NS_PER_S // 10).path("plant.y", "plant.u")
    waits_ms = [0, 80, 70]
    assert [latency.total_ns for latency in path.ticks()] == [wait * NS_PER_MS for wait in waits_ms]
    assert path.summary()[-1].mean_ns == 50 * NS_PER_MS


@given(chains(), st.integers(1, 1500))
@settings(max_examples=100, deadline=None)
def test_a_summary_is_of_every_sample_of_the_run(chain, duration_ms):
    """Looked at one by one, whether a round of them stands for the others or not."""
    grid, nodes, wires, seed = chain
    wiring = Wiring([Node("plant", ImpulseProbe(grid=grid)), *nodes], wires, seed)
    path = LatencyReport(wiring, horizon_ns=duration_ms * NS_PER_MS).path("plant.y", "plant.u")
    instants = takewhile(lambda index: path._sampling.tick(index) < duration_ms * NS_PER_MS, count())
    every = [found.total_ns for index in instants if (found := path.of_tick(index)) is not None]
    total = path.summary()[-1] if every else None
    assert path.covered_ns == duration_ms * NS_PER_MS
    if total is None:
        assert path.summary() == ()
        return
    assert (total.least_ns, total.most_ns) == (min(every), max(every))
    assert total.mean_ns == sum(every) / len(every)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Foreign(ImpulseProbe):
    """A plant made elsewhere, such as a controller's FMU."""

    own_step_s: float = 0.0


def between_plants(controller):
    """A plant and another part in a loop, straight or through a block."""
    nodes = [Node("finger", Foreign(own_step_s=0.001)), Node("hand", controller),
             Node("b", Pass(), rate="50")]
    return LatencyReport(Wiring(nodes, [Wire("finger.y", "hand.u", rate="1000"), Wire("hand.y", "b.u"),
                                        Wire("b.y", "finger.u")]))


def test_time_inside_foreign_plants_between_others_is_said_not_to_be_counted():
    """A loop of two FMUs has two paths, and the waits inside the FMUs are in neither."""
    report = between_plants(Foreign(own_step_s=0.02))
    assert len(report.paths) == 2
    assert report.not_counted == (
        "Not counted is the time inside hand and finger: a path ends at a plant's input, and a loop through "
        "several plants takes longer than its paths together. Steps that they declare: hand 20 ms, "
        "finger 1 ms.")
    assert report.coverage().startswith(report.not_counted)
    assert report.not_counted in str(report)
    assert "inside finger:" in between_plants(ImpulseProbe()).not_counted


def test_one_foreign_plant_under_a_block_has_all_of_its_loop_in_the_budget():
    nodes = [Node("finger", Foreign(own_step_s=0.001)), Node("b", Pass(), rate="50")]
    report = LatencyReport(Wiring(nodes, [Wire("finger.y", "b.u"), Wire("b.y", "finger.u")]))
    assert report.paths
    assert report.not_counted == ""
