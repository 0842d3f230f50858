"""The budget of loops whose blocks wait inside, against an impulse sent through them, to the nanosecond.

A stimulator's latency and slots, an electrode's memory of a pulse, a tracker's delay: from the capture to the
instant at which the pulse is there.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from loop_parts import Memory, Pass

from estimators.ideal import IdealTracker
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.latency import LatencyReport
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.models.electrode_arrays import VirtualElectrode
from plants.electrodes import Electrodes
from plants.stimulator import PRESETS, Stimulator

rates = st.one_of(st.sampled_from(["20", "40", "60", "100", "1000/3", "285.714"]),
                  st.fractions(10, 400, max_denominator=97).map(str))
milliseconds = st.one_of(st.just(0.0), st.integers(0, 60 * NS_PER_MS).map(lambda ns: ns / NS_PER_MS))
jitters = st.one_of(st.just(ZERO), st.just(ZERO), st.floats(0, 40).map(
    lambda ms: Duration(kind="uniform", low_ms=0.0, high_ms=ms)))
executions = st.one_of(st.just(ZERO), st.just(ZERO), st.floats(0, 5).map(
    lambda ms: Duration(kind="uniform", low_ms=0.0, high_ms=ms)))
grids = st.one_of(st.none(), rates.map(RateClock.from_rate), st.just(RateClock.from_rate("1000")))


@dataclass(frozen=True, kw_only=True, eq=False)
class Probe:
    """A plant whose output is 1 at `impulse_ns` only; logs when each place of its input is first above 0."""

    shape: tuple[int, ...]
    unit: str
    impulse_ns: int = -1
    grid: RateClock | None = None
    outputs: tuple[Port, ...] = (Port("y"),)
    feedthrough = False

    @property
    def inputs(self):
        return (Port("u", self.shape, self.unit),)

    def init(self, context: Context) -> Memory:
        return Memory(x=0, log=[{}])

    def advance(self, state, inputs, start_ns, stop_ns):
        for place in zip(*np.nonzero(inputs[0]), strict=True):
            state.log[0].setdefault(tuple(map(int, place)), start_ns)
        state.x = stop_ns

    def read(self, state, inputs):
        one = 1.0 if state.x == self.impulse_ns else 0.0
        return (one if self.outputs[0].shape == () else np.array([one]),)


@dataclass(frozen=True, kw_only=True, eq=False)
class Command:
    """Pulses on every channel (or one only) while its input is 1, or at all times, but through other elements
    while it is."""

    channels: int
    switches: bool = False
    only: int | None = None
    inputs = (Port("u"),)

    @property
    def outputs(self):
        return (Port("stimulation", (self.channels, 2), "A,s"),
                Port("multiplexing", (self.channels, 2 * self.channels), "1"))

    def init(self, context: Context) -> None:
        return None

    def step(self, state, inputs, tick) -> tuple[Any, ...]:
        one = inputs[0].value
        pulses = np.tile((0.03, 300e-6), (self.channels, 1)) * (1.0 if self.switches else one)
        if self.only is not None:
            pulses[np.arange(self.channels) != self.only] = 0.0
        return pulses, np.eye(self.channels, 2 * self.channels, k=self.channels if one else 0)


@st.composite
def stimulated(draw):
    """A probe sampled into a block, that commands a stimulator, whose pulses or charges act on the probe."""
    channels = draw(st.integers(1, 8))
    preset = draw(st.sampled_from(sorted(PRESETS)))
    latency_ms = draw(st.one_of(st.none(), milliseconds))
    frequency = draw(st.one_of(st.sampled_from(["20", "25", "40", "50", "100/3"]),
                               st.fractions(20, 50, max_denominator=89).map(str)))
    stimulator = Stimulator(preset=preset, frequency_hz=frequency, latency_ms=latency_ms,
                            elements=2 * channels)
    by = draw(st.sampled_from(["stimulation", "stimulation", "multiplexing"]))
    out = "elements" if by == "multiplexing" else draw(st.sampled_from(["elements", "charge"]))
    command = Command(channels=channels, switches=by == "multiplexing")
    nodes = [Node(name, part, rate=draw(st.one_of(rates, st.just("1000"))), offset_ms=draw(milliseconds),
                  execution=draw(executions)) for name, part in (("block", Pass()), ("command", command))]
    nodes.append(Node("stimulator", stimulator, execution=draw(executions)))
    ends = ["plant.y", "block.u", "block.y", "command.u", f"command.{by}", f"stimulator.{by}",
            f"stimulator.{out}", "plant.u"]
    wires = [Wire(ends[2 * i], ends[2 * i + 1], latency_ms=draw(milliseconds), jitter=draw(jitters),
                  loss=draw(st.sampled_from([0.0, 0.0, 0.3])),
                  late=draw(st.sampled_from(["keep-newest", "in-order"]))) for i in range(4)]
    if draw(st.booleans()):
        wires[0] = replace(wires[0], rate=draw(rates), offset_ms=draw(milliseconds))
    if by == "multiplexing":
        wires.append(Wire("command.stimulation", "stimulator.stimulation"))
    shape, unit = ((channels,), "C") if out == "charge" else ((2 * channels, 3), "A,s,Hz")
    probe = Probe(shape=shape, unit=unit, grid=draw(grids))
    return probe, draw(st.permutations(nodes)), wires, draw(st.integers(0, 2**32)), by


def captured_alone(path, grid, k):
    """Instant of sample k, where no other sample is of the same step of the plant."""
    sampled = path._sampling.tick(k)
    if grid is None:
        return sampled
    captured = grid.tick(grid.last_at_or_before(sampled))
    around = [path._sampling.tick(j) for j in (max(k - 1, 0), k + 1)]
    assume(all(grid.tick(grid.last_at_or_before(t)) != captured for t in around if t != sampled))
    return captured


def first_acts(probe, nodes, wires, seed, captured_ns):
    """When each place of the probe's input is first above 0, its output having been 1 at an instant only."""
    until_ns = captured_ns + 3 * NS_PER_S
    wiring = Wiring([Node("plant", replace(probe, impulse_ns=captured_ns)), *nodes], wires, seed)
    loop = Loop(wiring)
    loop.run_until(until_ns)
    list(loop._plants["plant"].values_through((until_ns,)))
    return loop.states()["plant"].log[0]


@pytest.mark.slow
@given(stimulated(), st.integers(0, 20))
@settings(max_examples=120, deadline=None)
def test_from_capture_to_pulse_is_what_an_impulse_takes_by_every_channel(loop, k):
    probe, nodes, wires, seed, by = loop
    wiring = Wiring([Node("plant", probe), *nodes], wires, seed)
    path = next(path for path in LatencyReport(wiring).paths
                if path.connections[-2].wire.target == f"stimulator.{by}")
    if by == "multiplexing":  # once there are pulses to switch
        k += path._sampling.first_at_or_after(300 * NS_PER_MS)
    captured = captured_alone(path, probe.grid, k)
    acted = first_acts(probe, nodes, wires, seed, captured)
    channels = wiring.node("command").part.channels
    assert path.lanes == tuple(f"channel {c}" for c in range(channels))
    for channel, name in enumerate(path.lanes):
        place = channel + channels if by == "multiplexing" else channel
        latency = path.of_tick(k, channel)
        measured = acted.get((place,) if len(probe.shape) == 1 else (place, 0))
        assert measured == (None if latency is None else latency.acts_ns), name
        if latency is not None:
            assert (latency.lane, latency.captured_ns) == (name, captured)
            assert sum(latency.stages_ns) == latency.total_ns
            assert min(latency.stages_ns) >= 0
            assert len(latency.stages_ns) == len(path.stages)


@pytest.mark.slow
@given(stimulated())
@settings(max_examples=30, deadline=None)
def test_a_summary_is_of_all_samples_that_act_by_all_channels(loop):
    probe, nodes, wires, seed, _ = loop
    wiring = Wiring([Node("plant", probe), *nodes], wires, seed)
    for path in LatencyReport(wiring, horizon_ns=NS_PER_S // 2).paths:
        totals = [[latency.total_ns for latency in path.ticks(lane)] for lane in range(len(path.lanes))]
        assert [path.least_ns(lane) for lane in range(len(path.lanes))] == [
            min(each, default=None) for each in totals]
        every = [total for each in totals for total in each]
        summary = path.summary()
        assert bool(summary) == bool(every)
        if every:
            total = summary[-1]
            assert (total.least_ns, total.most_ns) == (min(every), max(every))
            assert total.mean_ns == pytest.approx(np.mean(every))
            assert total.mean_ns == pytest.approx(sum(stage.mean_ns for stage in summary[:-1]))


@pytest.mark.slow
@given(st.data())
@settings(max_examples=25, deadline=None)
def test_electrodes_remember_a_pulse_until_the_next_of_its_train(data):
    """So that recruitment which is lost on its way, or late, comes with the next message of theirs."""
    draw, channels = data.draw, 3
    stimulator = Stimulator(frequency_hz=draw(st.sampled_from(["20", "40", "50", "100/3"])),
                            latency_ms=draw(milliseconds), elements=59,
                            electrodes=tuple(VirtualElectrode(elements=each)
                                             for each in ((22, 29), (16, 9), (44,))))
    slots = stimulator.clock.rate
    rate = draw(st.sampled_from([stimulator.clock, str(2 * slots), str(slots * Fraction(29, 17))]))
    command = Command(channels=channels, only=draw(st.integers(0, channels - 1)))
    nodes = [Node("command", command, rate=draw(rates)), Node("stimulator", stimulator),
             Node("electrodes", Electrodes(), rate=rate)]
    wires = [Wire("plant.y", "command.u", latency_ms=draw(milliseconds)),
             Wire("command.stimulation", "stimulator.stimulation", latency_ms=draw(milliseconds)),
             Wire("stimulator.elements", "electrodes.elements", latency_ms=draw(st.sampled_from([0.0, 1.0]))),
             Wire("electrodes.recruitment", "plant.u", loss=draw(st.sampled_from([0.0, 0.6])),
                  jitter=draw(jitters))]
    probe, seed = Probe(shape=(29,), unit="1", grid=draw(grids)), draw(st.integers(0, 2**32))
    wiring = Wiring([Node("plant", probe), *nodes], wires, seed)
    path = LatencyReport(wiring).path("plant.y", "plant.u")
    k = draw(st.integers(0, 12))
    captured = captured_alone(path, probe.grid, k)
    acted = min(first_acts(probe, nodes, wires, seed, captured).values(), default=None)
    latency = path.of_tick(k, command.only)
    assert acted == (None if latency is None else latency.acts_ns)
    assert latency is None or sum(latency.stages_ns) == latency.total_ns


@given(st.sampled_from(["20", "40", "50"]), rates, rates, milliseconds, milliseconds, st.integers(1, 8))
@settings(max_examples=25, deadline=None)
def test_without_a_latency_of_the_device_the_pulses_stamps_are_the_budget(
        frequency, tracked, controlled, upstream_ms, downstream_ms, channels):
    nodes = [Node("plant", Probe(shape=(2 * channels, 3), unit="A,s,Hz")),
             Node("tracker", Pass(), rate=tracked),
             Node("command", Command(channels=channels, switches=True), rate=controlled),
             Node("stimulator", Stimulator(frequency_hz=frequency, latency_ms=0.0, elements=2 * channels))]
    wires = [Wire("plant.y", "tracker.u"), Wire("tracker.y", "command.u", latency_ms=upstream_ms),
             Wire("command.stimulation", "stimulator.stimulation", latency_ms=downstream_ms),
             Wire("stimulator.elements", "plant.u")]
    wiring, recorder = Wiring(nodes, wires), Recorder(None)
    Loop(wiring, recorder=recorder).run_until(NS_PER_S)
    stamped: list[dict[int, int]] = [{} for _ in range(channels)]
    for acts_ns, _, oldest_ns, _, elements in recorder.inputs["plant"]:
        if elements.any() and oldest_ns >= 300 * NS_PER_MS:  # before, some pulses derive from no capture
            stamped[int(np.flatnonzero(elements[:, 0])[0])].setdefault(oldest_ns, acts_ns)
    path = LatencyReport(wiring, horizon_ns=NS_PER_S + 1).path("plant.y", "plant.u")
    for channel in range(channels):
        assert stamped[channel] == {
            latency.captured_ns: latency.acts_ns for latency in path.ticks(channel)
            if latency.captured_ns >= 300 * NS_PER_MS and latency.acts_ns <= NS_PER_S}


@pytest.mark.slow
@given(st.integers(1, 120 * NS_PER_MS), rates, milliseconds, jitters, executions, grids, st.integers(0, 20))
@settings(max_examples=80, deadline=None)
def test_a_trackers_delay_is_a_stage_though_no_stamp_shows_it(delay_ns, rate, late_ms, late, takes, grid, k):
    nodes = [Node("tracker", IdealTracker(delay_ms=delay_ns / NS_PER_MS), rate=rate, execution=takes)]
    wires = [Wire("plant.y", "tracker.angles", latency_ms=late_ms, jitter=late),
             Wire("tracker.angles", "plant.u", latency_ms=late_ms)]
    probe = Probe(shape=(1,), unit="rad", grid=grid, outputs=(Port("y", (1,), "rad"),))
    path = LatencyReport(Wiring([Node("plant", probe), *nodes], wires)).path("plant.y", "plant.u")
    k += path._sampling.first_at_or_after(400 * NS_PER_MS)  # what is read first stands in for older truth
    captured = captured_alone(path, grid, k)
    acted = first_acts(probe, nodes, wires, 0, captured)
    latency = path.of_tick(k)
    assert acted.get((0,)) == (None if latency is None else latency.acts_ns)
    if latency is not None:
        inside = latency.stages_ns[path.stages.index("tracker: delay, in whole ticks")]
        assert delay_ns <= inside
        assert sum(latency.stages_ns) == latency.total_ns


def test_the_stages_of_a_known_stimulator():
    """Channel 0 has its slot on the tick of a controller at 40 Hz: 1 ms of latency costs it a period."""
    nodes = [Node("plant", Probe(shape=(6, 3), unit="A,s,Hz")),
             Node("command", Command(channels=3), rate="40"),
             Node("stimulator", Stimulator(preset="generation3", elements=6))]
    wires = [Wire("plant.y", "command.u"), Wire("command.stimulation", "stimulator.stimulation"),
             Wire("stimulator.elements", "plant.u")]
    path = LatencyReport(Wiring(nodes, wires)).path("plant.y", "plant.u")
    assert path.stages == (
        "wire plant.y->command.u", "command waits for its tick", "command executes",
        "wire command.stimulation->stimulator.stimulation", "stimulator: latency of the device",
        "stimulator: wait for the channel's slot", "stimulator executes", "wire stimulator.elements->plant.u")
    assert [path.of_tick(2, channel).stages_ns[4:6] for channel in range(3)] == [
        (1_000_000, 24_000_000), (1_000_000, 2_125_000), (1_000_000, 5_250_000)]
    assert [path.least_ns(channel) for channel in range(3)] == [25_000_000, 3_125_000, 6_250_000]
    assert (path.summary()[-1].least_ns, path.summary()[-1].most_ns) == (3_125_000, 25_000_000)
    assert [(lane.name, lane.mean_ns) for lane in path.by_lane()] == [
        ("channel 0", 25e6), ("channel 1", 3.125e6), ("channel 2", 6.25e6)]


def test_a_command_is_in_force_until_the_next_that_the_device_has_read_is():
    """Of commands every 1 ms the slots, each 3.125 ms, read numbers 0, 3, 6: 3 is in force from 4 to 7 ms."""
    nodes = [Node("command", Command(channels=3), rate="1000"),
             Node("stimulator", Stimulator(preset="generation3", elements=6))]
    wires = [Wire("plant.y", "command.u"), Wire("command.stimulation", "stimulator.stimulation"),
             Wire("stimulator.elements", "plant.u")]
    probe = Probe(shape=(6, 3), unit="A,s,Hz")
    path = LatencyReport(Wiring([Node("plant", probe), *nodes], wires)).path("plant.y", "plant.u")
    acts = [path.of_tick(3, channel) for channel in range(3)]
    assert [latency and latency.acts_ns for latency in acts] == [None, None, 6_250_000]
    assert first_acts(probe, nodes, wires, 0, 3 * NS_PER_MS)[2, 0] == 6_250_000


@given(stimulated(), st.integers(100, 1000))
@settings(max_examples=60, deadline=None)
def test_a_summary_by_channel_is_of_every_sample_of_the_run(loop, duration_ms):
    """At rates that meet again within the run, a round of samples stands for all."""
    probe, nodes, wires, seed, _ = loop
    nodes = [replace(node, rate=None if node.rate is None else "50", execution=ZERO) for node in nodes]
    wires = [replace(wire, jitter=ZERO, loss=0.0, rate=wire.rate and "100") for wire in wires]
    wiring = Wiring([Node("plant", probe), *nodes], wires, seed)
    for path in LatencyReport(wiring, horizon_ns=duration_ms * NS_PER_MS).paths:
        samples = range(path._sampling.first_at_or_after(duration_ms * NS_PER_MS))
        for lane in range(len(path.lanes)):
            every = [found.total_ns for k in samples if (found := path.of_tick(k, lane)) is not None]
            summary = path.summary(lane)
            assert bool(summary) == bool(every)
            if every:
                total = summary[-1]
                assert (total.least_ns, total.most_ns) == (min(every), max(every))
                assert total.mean_ns == sum(every) / len(every)
