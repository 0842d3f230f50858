"""The block at the end of the loop: what it refuses, what it sends, and how a run ends. About 12 s."""

import threading
import time
from contextlib import closing

import device_parts as parts
import numpy as np
import pytest

import fesloop
from controllers.safety import Safety
from fesloop.errors import InputError, RunError, SnapshotError
from fesloop.experiment.files.parse import from_document
from fesloop.loop.abilities import Present, Surroundings
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.devices.stimulator_device import StimulatorDevice
from plants.stimulator import PRESETS

NAME = "hil_dry_stimulator"
PERIOD_NS = 20_000_000


@pytest.fixture(scope="module", autouse=True)
def _loaded():
    """The kernels of the safety block, as a run loads them before it begins."""
    nodes = [Node("source", Currents(*parts.PULSES), "50"), Node("safety", Safety(), "50")]
    Loop(Wiring(nodes, [Wire("source.stimulation", "safety.stimulation")])).run_until(0)


class Currents:
    """Puts out the same pulses for ever."""

    inputs = ()

    def __init__(self, *pulses):
        from fesloop.loop.signals import Port

        self.pulses = np.array(pulses)
        self.outputs = (Port("stimulation", self.pulses.shape, "A,s"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (self.pulses,)


def loop_of(device, *pulses, recorder=None):
    nodes = [Node("source", Currents(*pulses), "50"), Node("safety", Safety(charge_rise_uc=20.0), "50"),
             Node("device", device, "50")]
    wires = [Wire("source.stimulation", "safety.stimulation"),
             Wire("safety.stimulation", "device.stimulation")]
    return Loop(Wiring(nodes, wires), recorder=recorder)


def paced(loop, ticks, from_tick=0):
    """In step with the wall clock, until the last command has been taken."""
    origin = time.monotonic_ns() - from_tick * PERIOD_NS
    loop.wiring.node("device").part.attach(loop.states()["device"], Present(origin, threading.Event()))
    for number in range(from_tick, from_tick + ticks):
        time.sleep(max(0.0, (origin + number * PERIOD_NS - time.monotonic_ns()) / 1e9))
        loop.run_until(number * PERIOD_NS)
    time.sleep(PERIOD_NS / 1e9)


def lagging(loop, ticks):
    """Each tick takes half as long again as it should."""
    for number in ticks:
        loop.run_until(number * PERIOD_NS)
        time.sleep(1.5 * PERIOD_NS / 1e9)


@pytest.mark.realtime
def test_pulses_go_out_in_the_devices_steps_and_what_is_cut_is_told(tmp_path):
    log, recorder = parts.Log(tmp_path / "dry.log"), Recorder()
    device = StimulatorDevice(hold_ms=400.0, port=str(log.path), charge_max_uc=8.0)
    pulses = (0.0213, 300.4e-6), (0.03, 400e-6), (0.01, 5e-6)
    with closing(loop_of(device, *pulses, recorder=recorder)) as loop:
        paced(loop, 5)
        rows = recorder.blocks["device"]
        np.testing.assert_allclose(rows[-1][-1][0], [[0.020, 300e-6], [0.03, 266e-6], [0.0, 0.0]], atol=1e-12)
        assert 0.0 < rows[-1][-1][1] < 0.02  # the answer to one before
    assert [row[1:] for row in log.rows()] == [
        ("open", ""), *[("give", "20/300 30/266 0/0")] * 5, ("stop", "")]
    told = {(status, detail.split(":")[0])
            for _, where, status, detail in recorder.events if where == "device"}
    assert told == {("charge_limited", "channel 1"), ("width_too_short", "channel 2"),
                    ("keeper_ready", "memory")}


@pytest.mark.realtime
def test_a_fault_of_the_device_ends_the_run_and_is_recorded(tmp_path):
    pytest.importorskip("pysciencemode")
    recorder = Recorder()
    with parts.device(tmp_path) as device:
        block = StimulatorDevice(hold_ms=400.0, driver="science_mode", port=str(device.port))
        with closing(loop_of(block, *parts.PULSES, recorder=recorder)) as loop:
            paced(loop, 10)
            device.go_wrong("electrode_error")
            with pytest.raises(RunError, match="device: the device is stopped: electrode_error"):
                paced(loop, 50, 10)
    assert recorder.events[-1][1:3] == ("loop", "failed")
    assert "electrode_error" in recorder.events[-1][3]


@pytest.mark.realtime
def test_a_run_whose_device_fails_at_the_end_does_not_end_in_silence(tmp_path):
    pytest.importorskip("pysciencemode")
    with parts.device(tmp_path) as device:
        block = StimulatorDevice(hold_ms=400.0, driver="science_mode", port=str(device.port))
        loop = loop_of(block, *parts.PULSES)
        paced(loop, 5)
        device.go_wrong("electrode_error")
        time.sleep(0.05)
        with pytest.raises(RunError, match="failed at the end: electrode_error"):
            loop.close()


@pytest.mark.realtime
def test_each_trial_has_the_device_anew(tmp_path):
    log = parts.Log(tmp_path / "dry.log")
    with closing(loop_of(StimulatorDevice(hold_ms=400.0, port=str(log.path)), *parts.PULSES)) as loop:
        paced(loop, 3)
        time.sleep(0.5)  # what lies between trials may take longer than `hold_ms`
        loop.next_trial()
        paced(loop, 3)
    assert [event for _, event, _ in log.rows()] == ["open", *["give"] * 3, "stop"]


def test_a_loop_that_runs_as_fast_as_it_can_sends_nothing(tmp_path):
    log = parts.Log(tmp_path / "dry.log")
    with closing(loop_of(StimulatorDevice(hold_ms=400.0, port=str(log.path)), *parts.PULSES)) as loop, \
            pytest.raises(RunError, match="in real time only"):
        loop.run_until(PERIOD_NS)
    assert [event for _, event, _ in log.rows()] == ["open", "stop"]


@pytest.mark.realtime
def test_a_device_in_use_cannot_be_saved(tmp_path):
    with closing(loop_of(StimulatorDevice(hold_ms=400.0), *parts.PULSES)) as loop:
        paced(loop, 2)
        with pytest.raises(SnapshotError):
            loop.snapshot()


def test_the_cause_comes_with_its_instant(tmp_path):
    device = StimulatorDevice(hold_ms=60.0, channels=1)
    state = device.init(Context("device", clock=RateClock.from_rate("50")))
    device.attach(state, Present(time.monotonic_ns(), threading.Event()))
    state.device.send([(0.02, 3e-4)])
    time.sleep(0.15)
    # On a busy machine the device may notice late.
    told = r"command_timeout: no fresh command for 60 ms \(at 0\.(0[6-9]|1)\d+ s\)"
    with pytest.raises(RunError, match=told):
        state.device.hear()
    device.close(state)
    device.close(state)


@pytest.mark.parametrize(("parameters", "fault"), [
    ({"driver": "dri"}, "no stimulator driver is named 'dri'.*did you mean 'dry'"),
    ({"hold_ms": 5.0}, "hold_ms: 5; allowed: 20 to 1000"),
    ({"hold_ms": -5}, "hold_ms: -5; allowed: 20 to 1000"),
    *(({"hold_ms": float(text)}, f"hold_ms: {text}; allowed: 20 to 1000") for text in ("nan", "inf")),
    ({"channels": 9}, "channels: 9"), ({"frequency_hz": "100"}, "frequency_hz: 100"),
    ({"frequency_hz": "fast"}, "frequency_hz"), ({"charge_max_uc": 0.0}, "charge_max_uc")])
def test_bad_parameters_are_named(parameters, fault):
    with pytest.raises(InputError, match=fault):
        StimulatorDevice(**parameters)


def test_a_hold_shorter_than_two_periods_is_a_fault():
    context = Context("device", clock=RateClock.from_rate("20"))
    faults = StimulatorDevice(hold_ms=60.0, channels=2).faults(context, Surroundings())
    assert [str(fault) for fault in faults] == [
        "hold_ms: 60, with a command every 50 ms; allowed: at least two periods, 100"]


def test_check_states_the_time_to_zero_current():
    device = StimulatorDevice(driver="science_mode", port="/dev/x", channels=2)
    (_, told), (status, missing) = device.cautions(Context("device"))
    assert status == "not_ready"
    assert missing.startswith("port: there is no /dev/x; ")
    assert told == ("commands go to `science_mode` at /dev/x; zero current at most 250 ms after the last "
                    "fresh command, 1250 ms without keeper or line")


def test_the_stand_in_has_the_same_ports_and_touches_nothing():
    device = StimulatorDevice(channels=3)
    stand_in = device.stand_in()
    assert (stand_in.inputs, stand_in.outputs, stand_in.guarded) == (
        device.inputs, device.outputs, device.guarded)
    assert not hasattr(stand_in, "attach")
    assert not hasattr(stand_in, "close")


def test_an_experiment_without_its_safety_block_is_refused():
    document = fesloop.load(NAME).document()
    for wire in document["wires"]:
        if wire["to"] == "device.stimulation":
            wire["from"] = "controller.stimulation"
    with pytest.raises(InputError, match="a safety block directly before a device"):
        from_document(document)


def test_a_run_that_is_not_paced_is_refused(tmp_path):
    with pytest.raises(InputError, match="--realtime"):
        fesloop.load(NAME).run(tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


def test_a_device_that_does_not_open_leaves_no_recording(tmp_path):
    pytest.importorskip("pysciencemode")
    with pytest.raises(InputError, match=r"blocks\.device\.port: there is no .*nothing"):
        fesloop.load(NAME, ["driver=science_mode", f"port={tmp_path / 'nothing'}"]).run(
            tmp_path / "runs", realtime=True)
    (tmp_path / "no_line").touch()
    with pytest.raises(RunError, match="device: the device does not open: unplugged"):
        fesloop.load(NAME, ["driver=science_mode", f"port={tmp_path / 'no_line'}"]).run(
            tmp_path / "runs", realtime=True)
    assert not list(tmp_path.glob("runs/*"))


@pytest.mark.realtime
def test_the_shipped_rehearsal_sends_what_safety_lets_through(tmp_path):
    log = parts.Log(tmp_path / "given.log")
    settings = [f"log={log.path}", "hold_ms=400", "experiment.duration_s=1.5"]
    result = fesloop.load(NAME, settings).run(tmp_path, realtime=True)
    assert result.status == "done"
    with fesloop.Recording(result.recording) as recording:
        allowed = recording.signal("safety.stimulation").values
        sent = recording.signal("device.sent").values
    given = [[[float(number) for number in pulse.split("/")] for pulse in pulses.split()]
             for _, event, pulses in log.rows() if event == "give"]
    assert log.rows()[-1][1] == "stop"
    assert len(sent) == 75
    np.testing.assert_allclose(given[-1], sent[-1] * (1e3, 1e6), atol=1e-6)
    step = PRESETS["generation1"]
    on = sent[..., 1] > 0.0
    assert on.any()
    assert np.abs(sent - allowed)[on].max(axis=0)[0] <= 1e-3 * step.current_step_ma / 2.0 + 1e-12
    assert np.abs(sent - allowed)[on].max(axis=0)[1] <= 1e-6 * step.width_step_us


@pytest.mark.realtime
def test_nobody_gets_more_than_the_safety_block_let_through(tmp_path):
    pulses = (0.0219, 300.9e-6), (0.0019, 300e-6)
    recorder = Recorder()
    with closing(loop_of(StimulatorDevice(port=str(tmp_path / "dry.log")), *pulses,
                         recorder=recorder)) as loop:
        paced(loop, 2)
        let_through, sent = (np.array([row[-1][0] for row in recorder.blocks[name]])
                             for name in ("safety", "device"))
    assert (sent <= let_through).all()
    np.testing.assert_allclose(sent[-1], [[0.020, 300e-6], [0.0, 0.0]], atol=1e-12)


@pytest.mark.realtime
def test_commands_of_a_loop_that_lags_behind_the_wall_clock_are_not_given(tmp_path):
    log = parts.Log(tmp_path / "dry.log")
    with closing(loop_of(StimulatorDevice(port=str(log.path)), *parts.PULSES)) as loop:
        paced(loop, 3)
        with pytest.raises(RunError, match="device is stopped: command_timeout: no fresh command for 100 ms"):
            lagging(loop, range(3, 60))
    assert log.rows()[-1][1] == "stop"
    assert [event for _, event, _ in log.rows()].count("give") < 20


@pytest.mark.realtime
def test_a_loop_that_begins_late_gives_nothing_until_it_has_caught_up(tmp_path):
    log, recorder = parts.Log(tmp_path / "dry.log"), Recorder()
    with closing(loop_of(StimulatorDevice(port=str(log.path)), *parts.PULSES, recorder=recorder)) as loop:
        began = Present(time.monotonic_ns() - 20 * PERIOD_NS, threading.Event())
        loop.wiring.node("device").part.attach(loop.states()["device"], began)
        loop.run_until(20 * PERIOD_NS)
        time.sleep(0.05)
    sent = np.array([row[-1][0] for row in recorder.blocks["device"]])
    assert not sent[:15].any()
    assert sent[-1].all()
    assert ("device", "loop_late") in {event[1:3] for event in recorder.events}
    assert {event for _, event, _ in log.rows()} == {"open", "give", "stop"}


def test_a_safety_block_that_counts_other_pulses_than_the_device_gives_is_refused():
    with pytest.raises(InputError, match=r"device\.frequency_hz: 25, but the safety block counts 40 pulses"):
        fesloop.load(NAME, ["blocks.device.frequency_hz=25"])
