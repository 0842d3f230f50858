"""What a reader hands to the loop, whatever its source does; the loop's inlet on top of it."""

import time
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from streams_live_parts import PlannedSource, present, pulled, tick_at

from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.streams.live import inlet as inlet_module
from fesloop.streams.live.description import Picked
from fesloop.streams.live.inlet import InletState, LslInlet
from fesloop.streams.live.reader import _BACKLOG, StreamReader
from fesloop.streams.live.source import StreamLost

PERIOD = 10 * NS_PER_MS
ORIGIN = 100 * NS_PER_S


class Now:
    """A wall clock that a test moves."""

    def __init__(self, now_ns=ORIGIN):
        self.now_ns = now_ns

    def __call__(self):
        return self.now_ns


def inlet_over(reader, **parameters):
    """An inlet of one sensor (gyr on channels 0..2, acc on 3..5) whose stream is `reader`'s."""
    block = LslInlet(stream="imus", sensors=1, **parameters)
    channels = [np.arange(3).reshape(1, 3), np.arange(3, 6).reshape(1, 3)]
    state = InletState(reader, tuple(Picked(c, np.ones((1, 3))) for c in channels))
    block.attach(state, present(ORIGIN))
    return block, state


def sound_reader(now):
    return StreamReader(PlannedSource(), PERIOD, clock=now)


@st.composite
def histories(draw):
    """What happens to a stream, one after the other: (ms until then, stamp's lie in ns, value)."""
    lies = st.just(0) | st.integers(-2 * NS_PER_S, 2 * NS_PER_S) | st.integers(-2**61, 2**61)
    values = st.floats(allow_nan=True, allow_infinity=True, width=32)
    return draw(st.lists(st.tuples(st.integers(0, 3000), lies, values), min_size=1, max_size=40))


@given(histories(), st.integers(1, 5))
def test_no_fault_makes_time_go_back_or_raises(history, eagerness):
    now = Now()
    reader = sound_reader(now)
    block, state = inlet_over(reader)
    captured, index, before = -1, 0, -1
    for number, (wait_ms, lie, value) in enumerate(history):
        now.now_ns += wait_ms * NS_PER_MS
        reader.hear(np.append(np.full(5, value), number), now.now_ns - 300_000 + lie, now.now_ns)
        if number % eagerness:
            continue
        while (due := block.waiting(state)) is not None:
            due = max(due, before + 1)
            now.now_ns = max(now.now_ns, ORIGIN + due)
            tick = tick_at(due, index)
            values = block.step(state, (), tick)
            assert captured <= tick.captured_ns <= tick.time_ns <= now.now_ns - ORIGIN
            assert all(v.shape == (1, 3) and not np.isinf(v).any() for v in values)
            captured, before, index = tick.captured_ns, due, index + 1


def test_what_was_captured_before_the_trial_is_not_of_it():
    now = Now()
    reader = sound_reader(now)
    block, state = inlet_over(reader)
    reader.hear(np.zeros(6), ORIGIN - 1, ORIGIN + 100)
    assert block.waiting(state) is None
    reader.hear(np.zeros(6), ORIGIN + 50, ORIGIN + 200)
    assert block.waiting(state) == 200


def test_a_sample_rings_the_bell_and_is_taken_once():
    reader = sound_reader(Now())
    bell = present(ORIGIN)
    reader.attach(bell)
    reader.hear(np.arange(6.0), ORIGIN + 1, ORIGIN + 2)
    assert bell.bell.is_set()
    assert reader.take().values.tolist() == [0, 1, 2, 3, 4, 5]
    assert reader.take() is None


def test_a_silent_stream_ticks_on_nothing_that_grows_old():
    now = Now()
    reader = sound_reader(now)
    block, state = inlet_over(reader, silent_ms=30.0)
    reader.hear(np.ones(6), ORIGIN + PERIOD, ORIGIN + PERIOD)
    tick = tick_at(PERIOD)
    block.step(state, (), tick)
    now.now_ns = ORIGIN + PERIOD + 29 * NS_PER_MS
    assert block.waiting(state) is None
    told = []
    for k, after in enumerate((3 * PERIOD, 4 * PERIOD, 5 * PERIOD), start=1):
        now.now_ns = ORIGIN + PERIOD + after
        assert block.waiting(state) == PERIOD + after
        tick = tick_at(PERIOD + after, k)
        values = block.step(state, (), tick)
        assert np.isnan(values).all()
        assert tick.captured_ns == PERIOD
        told += [status for status, _ in tick.reports]
    assert told == ["stream_silent"]
    now.now_ns += PERIOD
    reader.hear(np.ones(6), now.now_ns, now.now_ns)
    tick = tick_at(block.waiting(state), 4)
    assert np.isfinite(block.step(state, (), tick)).all()
    assert ("stream_resumed", "after 60 ms") in tick.reports


def test_a_sample_of_nothing_is_no_capture():
    now = Now()
    reader = sound_reader(now)
    block, state = inlet_over(reader)
    for k, value in enumerate([1.0, np.nan, np.inf, 2.0], start=1):
        reader.hear(np.full(6, value), ORIGIN + k * PERIOD, ORIGIN + k * PERIOD)
    captures, statuses = [], []
    for k in range(1, 5):
        tick = tick_at(k * PERIOD, k)
        block.step(state, (), tick)
        captures.append(tick.captured_ns)
        statuses.append({status for status, _ in tick.reports})
    assert captures == [PERIOD, PERIOD, PERIOD, 4 * PERIOD]
    assert statuses == [set(), {"empty_sample"}, {"infinite"}, set()]


def test_numbers_that_never_change_are_no_capture():
    now = Now()
    reader = sound_reader(now)
    block, state = inlet_over(reader)
    captures, told, lost = [], [], []
    for k in range(1, 21):
        value = 1.0 if 4 <= k <= 15 else float(k)
        reader.hear(np.full(6, value), ORIGIN + k * PERIOD, ORIGIN + k * PERIOD)
        tick = tick_at(k * PERIOD, k)
        lost.append(np.isnan(block.step(state, (), tick)).all())
        captures.append(tick.captured_ns // PERIOD)
        told += [(k, status) for status, _ in tick.reports]
    assert captures == [*range(1, 9), *[8] * 7, *range(16, 21)]
    assert lost == [8 < k < 16 for k in range(1, 21)]
    assert told == [(9, "stream_frozen")]


def test_samples_at_a_wrong_rate_are_not_handed_on():
    now = Now()
    reader = sound_reader(now)
    reader.attach(present(ORIGIN))
    steps = [PERIOD] * 50 + [2 * PERIOD] * 50 + [PERIOD] * 50
    for k, step in enumerate(steps):
        now.now_ns += step
        reader.hear(np.full(6, float(k)), now.now_ns, now.now_ns)
    taken = []
    while (sample := reader.take()) is not None:
        taken.append(int(sample.values[0]))
    missing = sorted(set(range(150)) - set(taken))
    assert missing == list(range(missing[0], missing[-1] + 1))
    assert 50 < missing[0] <= 70
    assert 100 < missing[-1] <= 120
    assert [note.status for note in reader.notes()] == ["rate_changed", "rate_restored"]


def test_the_thread_finds_a_lost_stream_again():
    now = ORIGIN
    plan = [pulled(now + 1, 0.0), StreamLost(), pulled(now + PERIOD, 1.0)]
    source = PlannedSource(plan, reopenings=["", "another stream", "another stream", None])
    reader = StreamReader(source, PERIOD, clock=count(now + NS_PER_S, 2 * NS_PER_S).__next__)
    reader.attach(present(ORIGIN))
    reader.start()
    until = time.monotonic() + 120.0
    while reader.oldest() is None or source.plan:
        assert time.monotonic() < until
        time.sleep(0.001)
    heard = [reader.take().values[0], reader.take().values[0]]
    reader.close()
    assert heard == [0.0, 1.0]
    notes = reader.notes()
    assert [note.status for note in notes if note.status.startswith("stream")] == [
        "stream_lost", "stream_differs", "stream_found"]
    assert "another stream" in notes[1].detail
    assert source.closed == 1


def test_a_loop_that_lags_far_behind_loses_the_oldest_samples_and_is_told():
    reader = sound_reader(Now())
    reader.attach(present(ORIGIN))
    for k in range(_BACKLOG + 3):
        reader.hear(np.full(1, float(k)), ORIGIN + k * PERIOD, ORIGIN + k * PERIOD)
    taken = []
    while (sample := reader.take()) is not None:
        taken.append(int(sample.values[0]))
    assert taken == list(range(3, _BACKLOG + 3))
    assert [note.status for note in reader.notes()] == ["overrun"]


def test_a_trial_hears_of_nothing_that_was_odd_before_it_but_of_what_still_is():
    reader = sound_reader(Now())
    for k in range(30):
        reader.hear(np.zeros(1), ORIGIN + 2 * k * PERIOD, ORIGIN + 2 * k * PERIOD)
    began = ORIGIN + 60 * PERIOD
    reader.hear(np.zeros(1), ORIGIN, began - 1)
    reader.attach(present(began))
    assert [note[:2] for note in reader.notes()] == [(began, "rate_changed")]
    reader.hear(np.zeros(1), ORIGIN, began + 1)
    assert [note.status for note in reader.notes()] == ["stamp_behind"]


def test_one_status_is_told_once_a_second_and_counted():
    now = Now()
    reader = sound_reader(now)
    reader.attach(present(ORIGIN))
    reader.hear(np.zeros(1), ORIGIN + 1, ORIGIN + 1)
    for k in range(150):
        reader.hear(np.zeros(1), ORIGIN + 1, ORIGIN + (k + 1) * PERIOD)
    notes = reader.notes()
    assert [note.status for note in notes] == ["stamp_repeated"] * 2
    assert "99 times more" in notes[1].detail


def test_a_stream_that_does_not_fit_is_let_go(monkeypatch):
    source = PlannedSource()
    source.info = SimpleNamespace(nominal_srate=lambda: 50.0)
    monkeypatch.setattr(inlet_module, "find", lambda wanted: source.info)
    monkeypatch.setattr(inlet_module, "LslSource", lambda wanted, info: source)
    with pytest.raises(InputError, match="states a rate of 50 Hz"):
        LslInlet(stream="imus", sensors=1).init(Context("sensors"))
    assert source.closed == 1


def test_a_stand_in_has_the_same_ports_and_a_clock_of_its_own():
    block = LslInlet(stream="imus", sensors=2, magnetometers=True)
    stand_in = block.stand_in()
    assert stand_in.outputs == block.outputs
    assert (stand_in.clock.arrivals, block.clock.arrivals) == ("", "lsl:imus")
    values = stand_in.step(stand_in.init(Context("sensors")), (), tick_at(0))
    assert [v.shape for v in values] == [(2, 3)] * 3
    assert np.linalg.norm(values[1], axis=1) == pytest.approx(9.80665)


@pytest.mark.parametrize(("parameters", "named"), [
    ({"sensors": 1}, "^stream: no stream is named; allowed: one or more of stream, stream_type, source_id"),
    ({"stream": "a", "sensors": 0}, "sensors"),
    ({"stream": "a", "sensors": 2, "sensor_names": ("x",)}, "sensor_names"),
    ({"stream": "a", "sensors": 2, "sensor_names": ("x", "x")}, "sensor_names: a name is listed twice"),
    ({"stream": "a", "holds": "posture"}, "joints"),
    ({"stream": "a", "holds": "posture", "joints": ("pip", "pip")}, "joints: a name is listed twice"),
    *(({"stream": "a", "sensors": 1, "silent_ms": ms}, f"silent_ms: {ms:g}; allowed: 1 or more")
      for ms in (0.5, -3.0, float("nan"))),
    ({"stream": "a", "sensors": 1, "silent_ms": float("inf")}, "silent_ms: inf"),
    ({"stream": "it's", "sensors": 1}, '^stream: "it\'s"; allowed: text without'),
    ({"stream_type": "it's", "sensors": 1}, "^stream_type: "),
    ({"stream": "a", "sensors": 1, "nominal_rate": "fast"}, "nominal_rate"),
])
def test_what_cannot_be_is_refused(parameters, named):
    with pytest.raises(InputError, match=named):
        LslInlet(**parameters)
