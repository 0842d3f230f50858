"""Streams through liblsl itself, within this machine (some 20 s)."""

import threading
import time
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pylsl", reason="pylsl is not installed")

from streams_live_parts import present, tick_at

from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import run
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import Sample
from fesloop.streams.live.events import LslEvents
from fesloop.streams.live.inlet import LslInlet
from fesloop.streams.live.library import open_library
from fesloop.streams.live.outlet import LslOutlet
from fesloop.streams.live.sender import SenderFault, StreamSender, inertial
from fesloop.streams.recording import MotionRecording
from fesloop.streams.timebase import stamps_of_rate

pytestmark = pytest.mark.realtime

RATE = 100


@pytest.fixture
def name(request):
    """A name that no other stream has."""
    return f"{request.node.name} {time.monotonic_ns()}"


def recording(samples=3000, sensors=("hand", "F2p")):
    """Sensors nearly at rest, every sample different from every other."""
    rng = np.random.default_rng(3)
    shape = (samples, len(sensors), 3)
    gyr, acc, mag = rng.normal(0.0, 0.3, (3, *shape))
    gyr[:, 0, 0] = np.arange(samples) / samples
    return MotionRecording(path=Path("made up"), source_format="made up", sensor_set=None, sensors=sensors,
                           rate=Fraction(RATE), stamps_ns=stamps_of_rate(samples, Fraction(RATE)), gyr=gyr,
                           acc=acc + np.array([0.0, 0.0, 9.8]), mag=4e-5 + 1e-6 * mag, reference=None,
                           pairs=())


@contextmanager
def streaming(played, name, **parameters):
    """A sender at work in a thread."""
    ending = threading.Event()
    sender = StreamSender(played=inertial(played), stream=name, **parameters)
    thread = threading.Thread(target=sender.send, kwargs={"going_on": lambda: not ending.is_set()})
    thread.start()
    try:
        yield
    finally:
        ending.set()
        thread.join()


def live_experiment(name, seconds):
    """An inlet alone, recorded."""
    return from_document({
        "experiment": {"name": "heard", "description": "", "duration_s": seconds},
        "blocks": {"sensors": {"kind": "lsl_inlet", "stream": name, "sensors": 2, "magnetometers": True},
                   "nothing": {"kind": "minimum_jerk", "rate": "50", "times_s": [0.1, 0.2],
                               "angles_deg": [[0.0], [1.0]]}}}, "heard")


@pytest.mark.slow
def test_samples_come_as_they_were_sent_and_stamps_say_when(name, tmp_path):
    played = recording()
    with streaming(played, name):
        result = run(live_experiment(name, 3.0), tmp_path, realtime=True)
    assert result.status == "done"
    with Recording(result.recording) as heard:
        gyr, acc, mag = (heard.signal(f"sensors.{kind}") for kind in ("gyr", "acc", "mag"))
        oldest, told = gyr.oldest_ns, {event.status for event in heard.events if event.where == "sensors"}
    sample = np.isfinite(np.asarray(gyr.values)[:, 0, 0])  # a busy machine may have been silent for 30 ms
    rows = np.rint(np.asarray(gyr.values)[sample, 0, 0] * played.samples).astype(int)
    assert len(rows) > 250
    assert (np.diff(rows) > 0).all()
    assert (np.diff(rows) == 1).all() or told & {"rate_changed", "samples_missing"}, "none is lost in silence"
    for found, sent in ((gyr, played.gyr), (acc, played.acc), (mag, played.mag)):
        np.testing.assert_allclose(np.asarray(found.values)[sample], sent[rows], rtol=1e-6)
    assert (np.diff(oldest) >= 0).all()
    assert (np.diff(oldest[sample]) > 0).all()
    late = (gyr.times_ns - oldest)[sample]
    assert (late >= 0).all()
    assert np.median(late) < 20e6


@pytest.mark.slow
def test_a_stream_that_vanishes_is_found_again(name, tmp_path):
    faults = (SenderFault.parse("vanish@4+1"),)
    with streaming(recording(), name, faults=faults):
        result = run(live_experiment(name, 8.0), tmp_path, realtime=True)
    with Recording(result.recording) as heard:
        told = [event.status for event in heard.events if event.where == "sensors"]
        values = np.asarray(heard.signal("sensors.gyr").values)
    assert result.status == "done"
    order = [status for status in told if status.startswith("stream")]
    assert set(order) == {"stream_lost", "stream_silent", "stream_found", "stream_resumed"}
    assert order.index("stream_found") > order.index("stream_lost")
    assert np.isnan(values).all(axis=(1, 2)).sum() > 10
    assert np.isfinite(values[-50:]).mean() > 0.5  # a busy machine may have been silent again


@pytest.mark.slow
def test_a_stream_that_does_not_fit_is_refused_by_name(name):
    with streaming(recording(), name):
        block = LslInlet(stream=name, sensors=3)
        with pytest.raises(InputError, match=r"has 2 sensors \(hand, F2p\)"):
            block.init(Context("sensors", clock=block.clock))
        other = LslInlet(stream="elsewhere", sensors=2, timeout_s=0.6)
        with pytest.raises(InputError) as absent:
            other.init(Context("sensors", clock=other.clock))
        slow = LslInlet(stream=name, sensors=2, nominal_rate="60")
        with pytest.raises(InputError, match=r'states a rate of 100 Hz.*say nominal_rate = "100"'):
            slow.init(Context("sensors", clock=slow.clock))
    assert name in str(absent.value)
    assert "18 channels, 100 Hz" in str(absent.value)


def test_stamps_of_another_clock_are_refused_unless_arrivals_count(name):
    played = recording()
    with streaming(played, name, faults=(SenderFault("clock", 0.0, 1e6, 1e9),)):
        block = LslInlet(stream=name, sensors=2)
        with pytest.raises(InputError, match=r"ahead of this machine.*arrival"):
            block.init(Context("sensors", clock=block.clock))
        trusting = LslInlet(stream=name, sensors=2, stamps="arrival")
        state = trusting.init(Context("sensors", clock=trusting.clock))
        trusting.attach(state, present(time.monotonic_ns()))
        time.sleep(0.2)
        tick = tick_at(trusting.waiting(state))
        trusting.step(state, (), tick)
        trusting.close(state)
    assert 0 < tick.captured_ns <= tick.time_ns


def test_commands_leave_with_the_capture_they_answer(name):
    pylsl = open_library()
    block = LslOutlet(stream=name, unit="A,s", columns=2, rows=2, labels=("flexor", "extensor"),
                      column_labels=("current", "width"))
    state = block.init(Context("outlet", clock=RateClock.from_rate(50)))
    inlet = pylsl.StreamInlet(pylsl.resolve_byprop("name", name, timeout=5.0)[0], recover=False)
    inlet.open_stream(timeout=5.0)
    origin = time.monotonic_ns()
    block.attach(state, present(origin))
    values = np.array([[0.01, 2e-4], [0.02, 3e-4]])
    block.step(state, (Sample(values, 7_000_000, 9_000_000, 9_000_000),), tick_at(10_000_000))
    block.step(state, (Sample(np.zeros((2, 2)), -1, -1, -1),), tick_at(20_000_000))
    received, stamp = inlet.pull_sample(timeout=5.0)
    assert inlet.pull_sample(timeout=0.2) == (None, None)
    info = inlet.info(timeout=5.0)
    channel = info.desc().child("channels").first_child()
    labels = []
    while not channel.empty():
        labels.append((channel.child_value("label"), channel.child_value("unit")))
        channel = channel.next_sibling()
    block.close(state)
    assert received == values.ravel().tolist()
    assert stamp * NS_PER_S == pytest.approx(origin + 7_000_000, abs=200_000)
    assert labels == [("flexor current", "A"), ("flexor width", "s"), ("extensor current", "A"),
                      ("extensor width", "s")]
    assert info.desc().child("synchronization").child_value("stamps").startswith("oldest capture")


def test_a_live_run_asks_for_real_time(name, tmp_path):
    with pytest.raises(InputError, match="--realtime"):
        run(live_experiment(name, 1.0), tmp_path)


@contextmanager
def pushing(block, rows):
    """An outlet block that sends row after row, 100 a second, for as long as is wanted."""
    state = block.init(Context("outlet", clock=RateClock.from_rate(RATE)))
    origin, ending = time.monotonic_ns(), threading.Event()
    block.attach(state, present(origin))

    def push():
        for k in range(10**6):
            if ending.wait(0.01):
                return
            now = time.monotonic_ns() - origin
            block.step(state, (Sample(rows[k % len(rows)], now, now, now),), tick_at(now, k))

    thread = threading.Thread(target=push)
    thread.start()
    try:
        yield
    finally:
        ending.set()
        thread.join()
        block.close(state)


@pytest.mark.slow
def test_a_posture_goes_out_and_comes_in_by_name_over_two_trials(name, tmp_path):
    rows = np.column_stack([np.linspace(0.0, 1.0, 500), np.linspace(2.0, 3.0, 500)])
    document = live_experiment(name, 3.0).document()
    document["experiment"]["trials"] = 2
    document["blocks"]["sensors"] = {"kind": "lsl_inlet", "stream": name, "holds": "posture",
                                     "joints": ["pip", "mcp"]}
    with pushing(LslOutlet(stream=name, unit="rad", rows=2, labels=("mcp", "pip")), rows):
        result = run(from_document(document, "heard"), tmp_path, realtime=True)
    with Recording(result.recording) as heard:
        for trial in (0, 1):
            signal = heard.signal("sensors.angles", trial)
            angles = np.asarray(signal.values)
            angles = angles[np.isfinite(angles[:, 0])]
            assert len(angles) > 10  # of 300, on a busy machine
            np.testing.assert_allclose(angles[:, 0] - angles[:, 1], 2.0)
            assert (np.diff(signal.oldest_ns) >= 0).all()
            assert signal.oldest_ns[0] < 3_000_000_000  # since the trial began, not the first one


def test_statuses_and_marks_leave_as_markers(name):
    pylsl = open_library()
    block = LslEvents(stream=name, blocks=("safety",), mark_name="phase")
    state = block.init(Context("events"))
    inlet = pylsl.StreamInlet(pylsl.resolve_byprop("name", name, timeout=5.0)[0], recover=False)
    inlet.open_stream(timeout=5.0)
    origin = time.monotonic_ns()
    block.attach(state, present(origin))
    block.heed(state, [(5_000_000, "safety", "emergency_stop", "for good"),
                       (6_000_000, "mpc", "saturated", "")])
    for k, phase in enumerate((1.0, 1.0, 2.0), start=7):
        block.step(state, (Sample(phase, k, k, k),), tick_at(k * 1_000_000))
    received = [inlet.pull_sample(timeout=5.0) for _ in range(3)]
    assert inlet.pull_sample(timeout=0.2) == (None, None)
    block.close(state)
    assert [text for (text,), _ in received] == ["safety emergency_stop: for good", "phase 1", "phase 2"]
    stamps = np.array([stamp for _, stamp in received]) * NS_PER_S
    np.testing.assert_allclose(stamps - origin, [5e6, 7e6, 9e6], atol=200_000)


@pytest.mark.slow
def test_what_a_loop_reports_is_sent_as_it_happens(name, tmp_path):
    document = live_experiment(name, 2.5).document()
    document["blocks"]["events"] = {"kind": "lsl_events", "stream": f"events of {name}", "rate": "50"}
    heard = []

    def listen():
        pylsl = open_library()
        found = pylsl.resolve_byprop("name", f"events of {name}", timeout=20.0)
        inlet = pylsl.StreamInlet(found[0], recover=False)
        while True:
            try:
                text, _ = inlet.pull_sample(timeout=5.0)
            except RuntimeError:
                return
            if text:
                heard.append(text[0])

    listener = threading.Thread(target=listen)
    listener.start()
    faults = tuple(SenderFault("nan", start, 0.2) for start in np.arange(0.5, 60.0, 0.5))
    with streaming(recording(), name, faults=faults):
        result = run(from_document(document, "heard"), tmp_path, realtime=True)
    listener.join()
    with Recording(result.recording) as recorded:
        told = [f"{e.where} {e.status}: {e.detail}" for e in recorded.events]
    assert sum("empty_sample" in text for text in heard) >= 2
    assert set(heard) <= set(told)
