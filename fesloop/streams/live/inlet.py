"""A live stream as a block, whose samples leave as they arrive."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.skeleton import pairs_of_names
from fesloop.loop.abilities import Present
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Port, Sample, Sensors, Value, is_finite
from fesloop.streams.checks import plausible_acc, plausible_gyr, plausible_mag
from fesloop.streams.labels import GRAVITY, Kind
from fesloop.streams.live.description import Declared, Picked, channels_of, pick_angles, pick_inertial
from fesloop.streams.live.library import Network
from fesloop.streams.live.query import StreamQuery, announce_absence, find
from fesloop.streams.live.reader import StreamReader
from fesloop.streams.live.source import LslSource, Pulled, Source, StreamLost

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class InletState:
    """An open stream.

    Attributes
    ----------
    reader: its thread and the samples that wait.
    picked: channels of each output.
    origin_ns: t = 0 of the trial by the monotonic clock; NEVER before the first.
    heard_ns: loop time of the newest tick; 0 before the first.
    captured_ns: loop time of the newest capture put out.
    silent_since_ns: loop time of the last sample before the stream fell silent; NEVER while it is not.
    before, same: numbers of the newest sample, and the count of samples in a row that had them before it.
    channels, factors: of all outputs in a row.
    """

    reader: StreamReader
    picked: tuple[Picked, ...]
    origin_ns: int = NEVER
    heard_ns: int = 0
    captured_ns: int = 0
    silent_since_ns: int = NEVER
    before: Array = field(default_factory=lambda: np.empty(0))
    same: int = 0
    latch: StatusLatch = field(default_factory=StatusLatch)
    channels: NDArray[np.int64] = field(init=False)
    factors: Array = field(init=False)

    def __post_init__(self) -> None:
        self.channels = np.concatenate([picked.channels.ravel() for picked in self.picked])
        self.factors = np.concatenate([picked.factors.ravel() for picked in self.picked])

    def outputs(self, numbers: Array) -> tuple[Value, ...]:
        """A row of numbers as the outputs."""
        parts, first = [], 0
        for picked in self.picked:
            size = picked.channels.size
            parts.append(numbers[first:first + size].reshape(picked.channels.shape))
            first += size
        return tuple(parts)


_AT_REST = {"gyr": (0.0, 0.0, 0.0), "acc": (0.0, 0.0, GRAVITY), "mag": (0.0, 2e-5, -4e-5)}
"""Gravity, and a field of mid latitudes, 45 uT (IGRF: 25 to 65 uT)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InletStandIn:
    """Replaces an inlet in rehearsals and checks: sensors at rest, or joints at zero, at an exact rate.

    Attributes
    ----------
    outputs: ports of the inlet that it replaces.
    rate: Hz.
    """

    outputs: tuple[Port, ...]
    rate: str
    inputs: tuple[Port, ...] = ()
    clock: RateClock = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "clock", RateClock.from_rate(self.rate))

    def init(self, context: Context) -> None:
        """No state."""

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The same at every tick."""
        return tuple(port.initial_value() + np.array(_AT_REST.get(port.name, 0.0)) for port in self.outputs)


_SAMPLES, _WAIT_S = 10, 2.0
_CLOCKS_AGREE_NS = NS_PER_S // 2
"""Age of a sample, or lead, above which its stamps count as those of another clock (chosen: the default age
at which a safety block stops)."""
_RATE_AGREES = 0.01
"""Relative difference allowed between stated and nominal rate (chosen: sensors' clocks are better)."""
_PLAUSIBLE: Mapping[str, Callable[[NDArray[np.float64], str], None]] = {
    "gyr": plausible_gyr, "acc": plausible_acc, "mag": plausible_mag}


def check_rate(stated_hz: float, clock: RateClock, where: str) -> None:
    """Raise InputError where a stream states another rate than the nominal one; 0 states none."""
    if stated_hz > 0.0 and abs(stated_hz * clock.period_s - 1.0) > _RATE_AGREES:
        raise InputError(where, f"states a rate of {stated_hz:g} Hz", f"nominal_rate = {float(clock.rate):g}",
                         f'say nominal_rate = "{stated_hz:g}"')


def check_first_samples(source: Source, picked: Mapping[str, Picked], where: str, *, by_sender: bool) -> None:
    """Raise InputError where a stream is silent, its numbers cannot be in its units, or its clock is another.

    Parameters
    ----------
    source: opened; ten samples of it are read.
    picked: channels of "gyr", "acc" and "mag", (n, 3) each.
    where: the stream, for messages.
    by_sender: whether its stamps are to be used.
    """
    pulled = _read(source, where)
    values = np.stack([sample.values for sample in pulled])
    for kind, channels in picked.items():
        readings = np.stack([channels.of(row) for row in values])
        if np.isfinite(readings).all(axis=2).any():
            _PLAUSIBLE[kind](readings.reshape(-1, 3), f"{where}: {kind}")
    age_ns = time.monotonic_ns() - pulled[-1].stamp_ns
    if by_sender and abs(age_ns) > _CLOCKS_AGREE_NS:
        off = f"{abs(age_ns) / NS_PER_S:.3g} s {'old' if age_ns > 0 else 'ahead of this machine'}"
        raise InputError(where, f"its samples are stamped {off}", f"up to {_CLOCKS_AGREE_NS / NS_PER_S:g} s",
                         'its stamps are of another clock: say stamps = "arrival"')


def _read(source: Source, where: str) -> list[Pulled]:
    pulled: list[Pulled] = []
    until = time.monotonic() + _WAIT_S
    while len(pulled) < _SAMPLES and (left := until - time.monotonic()) > 0.0:
        try:
            sample = source.pull(left)
        except StreamLost:
            raise InputError(where, "was lost as it was opened", remedy="start its sender again") from None
        if sample is not None:
            pulled.append(sample)
    if not pulled:
        raise InputError(where, f"is there, but sends nothing within {_WAIT_S:g} s", "samples")
    return pulled


_UNITS = {"gyr": "rad/s", "acc": "m/s^2", "mag": "T"}
_UNDECLARED = Declared()
_FROZEN = 5
"""Identical samples in a row that count as frozen (chosen: noise changes the last bit of some channel)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LslInlet:
    """Receives a live stream of inertial sensors, or of joint angles, from Lab Streaming Layer.

    It ticks when a sample arrives, and so does every block on its clock (`clock = "inlet"` where the inlet's
    name is that). One sample a tick; its capture is the sender's stamp, brought to the loop's time by LSL's
    measure of the offset between the clocks. Captures increase strictly and are never later than arrivals:
    samples whose stamps cannot be so are left out, with a status (`fesloop.streams.live.reader`).

    Outputs of inertial sensors: `gyr` (n, 3) rad/s, `acc` (n, 3) m/s^2 and, with magnetometers, `mag` (n, 3)
    T. Of a posture: `angles` (k,) rad. NaN is a lost number: the sender says so, or it is infinite.

    When no sample has arrived for `silent_ms`, it ticks at its nominal rate all the same, so that blocks on
    its clock, such as a safety block, still act: the outputs are then NaN, and the capture is that of the
    last sample, which grows older. The same holds for samples of NaN alone, for samples of inertial sensors
    that are equal to the last bit six times in a row, and while samples come at a wrong rate.

    Statuses: `stream_silent`, `stream_resumed`; `stream_lost` (its sender is gone), `stream_found`,
    `stream_differs`; `stamp_behind`, `stamp_repeated`, `stamp_ahead`, `clock_reset`, `samples_missing`,
    `rate_changed`, `rate_restored`, `overrun`, each with the time at which it arose; `infinite`,
    `empty_sample`, `stream_frozen`.

    Attributes
    ----------
    stream, stream_type, source_id: name, type and source_id of the stream; one at least.
    holds: "imu" or "posture".
    sensors: n.
    sensor_names: sensors to put out, in the order of the outputs; empty takes all, in the stream's order.
    pairs: names of (parent, child) sensors on neighbouring segments, for trackers; of `sensor_names`. Empty:
        as the hand has them, where all names are of its segments.
    magnetometers: whether `mag` is put out.
    joints: names of the k angles, as the channels are labelled.
    nominal_rate: of the stream, Hz.
    layout: of a stream that does not describe its channels.
    stamps: "sender" for the stamps of the samples, "arrival" for senders whose stamps mean something else.
    silent_ms: see above (chosen: three samples of 100 Hz, and in time for a watchdog of 50 ms).
    timeout_s: duration of the search for the stream when the run begins.
    network: "loopback" for streams of this machine; "lab" for streams of the local network.
    """

    stream: str = ""
    stream_type: str = ""
    source_id: str = ""
    holds: Literal["imu", "posture"] = "imu"
    sensors: int = 0
    sensor_names: tuple[str, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()
    magnetometers: bool = False
    joints: tuple[str, ...] = ()
    nominal_rate: str = "100"
    layout: Declared = _UNDECLARED
    stamps: Literal["sender", "arrival"] = "sender"
    silent_ms: float = 30.0
    timeout_s: float = 5.0
    network: Network = "loopback"
    clock: RateClock = field(init=False, repr=False)
    query: StreamQuery = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.holds == "imu" and self.sensors < 1:
            raise InputError("sensors", f"{self.sensors}", "1 or more")
        if self.holds == "imu" and self.sensor_names and len(self.sensor_names) != self.sensors:
            raise InputError("sensor_names", f"{len(self.sensor_names)} names",
                             f"{self.sensors}, one a sensor")
        if self.holds == "posture" and not self.joints:
            raise InputError("joints", "no joint is named", "one or more names")
        for key in ("sensor_names", "joints"):
            names = getattr(self, key)
            if len(set(names)) < len(names):
                raise InputError(key, f"a name is listed twice: {', '.join(names)}", "different names")
        for name in (name for pair in self.pairs for name in pair):
            if name not in self.sensor_names:
                raise InputError("pairs", f"{name!r} is none of sensor_names",
                                 ", ".join(self.sensor_names) or "sensor_names that are given",
                                 did_you_mean(name, self.sensor_names))
        self._stated()
        if not self.silent_ms >= 1.0:
            raise InputError("silent_ms", f"{self.silent_ms:g}", "1 or more")
        duration_ns(self.silent_ms, NS_PER_MS, "silent_ms")
        query = StreamQuery(name=self.stream, type=self.stream_type, source_id=self.source_id,
                        timeout_s=self.timeout_s, network=self.network)
        arrivals = " ".join(["lsl:" + (self.stream or self.source_id or self.stream_type),
                             *self.sensor_names, *self.joints])
        clock = RateClock.from_rate(self.nominal_rate, where="nominal_rate", arrivals=arrivals)
        object.__setattr__(self, "query", query)
        object.__setattr__(self, "clock", clock)

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """Kinds of inertial samples that are put out; none of a posture."""
        if self.holds == "posture":
            return ()
        return ("gyr", "acc", "mag") if self.magnetometers else ("gyr", "acc")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """No inputs."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """gyr, acc, mag; or angles."""
        if self.holds == "posture":
            return (Port("angles", (len(self.joints),), "rad", gaps=True),)
        stated = self._stated()
        return tuple(Port(kind, (self.sensors, 3), _UNITS[kind], gaps=True, sensors=stated)
                     for kind in self.kinds)

    def _stated(self) -> Sensors | None:
        """The sensors and their pairs, where names are given; a stream's own are known once it is open."""
        names = self.sensor_names
        if not names:
            return None
        pairs = tuple((names.index(parent), names.index(child)) for parent, child in self.pairs)
        return Sensors(names, pairs or pairs_of_names(names))

    def stand_in(self) -> InletStandIn:
        """Sensors at rest, at the nominal rate."""
        return InletStandIn(outputs=self.outputs, rate=self.nominal_rate)

    def seek(self) -> None:
        """Print a line where the stream does not answer yet, before the run is rehearsed."""
        announce_absence(self.query)

    def init(self, context: Context) -> InletState:
        """Find and open the stream; raises InputError where there is none, or it does not fit."""
        source = LslSource(self.query, find(self.query))
        try:
            check_rate(source.info.nominal_srate(), self.clock, str(self.query))
            picked = self._pick(source.info)
            check_first_samples(source, dict(zip(self.kinds, picked, strict=False)), str(self.query),
                                by_sender=self.stamps == "sender")
        except InputError:
            source.close()
            raise
        reader = StreamReader(source, self.clock.shortest_ns, by_sender=self.stamps == "sender")
        reader.start()
        return InletState(reader, picked)

    def _pick(self, info: Any) -> tuple[Picked, ...]:
        channels, count, where = channels_of(info), info.channel_count(), str(self.query)
        if self.holds == "posture":
            return (pick_angles(channels, count, self.joints, self.layout, where),)
        picked = pick_inertial(channels, count, self.kinds, self.sensors, self.sensor_names, self.layout,
                               where)
        return tuple(picked[kind] for kind in self.kinds)

    def next_trial(self, state: InletState, context: Context) -> InletState:
        """The same stream, open for all trials."""
        return InletState(state.reader, state.picked)

    def attach(self, state: InletState, present: Present) -> None:
        """Take the instant t = 0 of the trial; earlier samples do not belong to it."""
        state.origin_ns = present.origin_ns
        state.reader.attach(present)

    def waiting(self, state: InletState) -> int | None:
        """Instant at which the oldest sample arrived, or at which the stream has been silent for too long."""
        sample = state.reader.oldest()
        if sample is not None:
            return sample.arrived_ns - state.origin_ns
        silent = state.heard_ns + (round(self.silent_ms * NS_PER_MS) if state.silent_since_ns < 0
                                   else self.clock.shortest_ns)
        return silent if state.reader.now_ns() - state.origin_ns >= silent else None

    def step(self, state: InletState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """One sample, or NaN for none."""
        for note in state.reader.notes():
            at_s = (note.time_ns - state.origin_ns) / NS_PER_S
            tick.report(note.status, f"at {at_s:.3f} s: {note.detail}")
        sample = state.reader.take()
        before, state.heard_ns = state.heard_ns, tick.time_ns
        if sample is None:
            if state.silent_since_ns < 0:
                state.silent_since_ns = before
                tick.report("stream_silent", f"nothing since {before / NS_PER_S:.3f} s")
            tick.captured_ns = state.captured_ns
            return state.outputs(np.full(state.channels.size, np.nan))
        if state.silent_since_ns >= 0:
            away_ms = (sample.arrived_ns - state.origin_ns - state.silent_since_ns) / NS_PER_MS
            tick.report("stream_resumed", f"after {away_ms:.0f} ms")
            state.silent_since_ns = NEVER
        numbers, nothing = self._believed(state, sample.values[state.channels] * state.factors, tick)
        if not nothing:
            state.captured_ns = min(sample.captured_ns - state.origin_ns, tick.time_ns)
        tick.captured_ns = state.captured_ns
        return state.outputs(numbers)

    def _believed(self, state: InletState, numbers: Array, tick: Tick) -> tuple[Array, bool]:
        """The numbers with NaN for lost ones, and whether nothing at all was captured."""
        same = self.holds == "imu" and np.array_equal(numbers, state.before)
        state.same, state.before = state.same + 1 if same else 0, numbers
        frozen = state.same >= _FROZEN
        if not (frozen or state.latch.holding) and is_finite(numbers):
            return numbers, False
        infinite = np.isinf(numbers)
        numbers = np.where(infinite | frozen, np.nan, numbers)
        empty = bool(np.isnan(numbers).all())
        state.latch.put(tick, "infinite", bool(infinite.any()), "infinite numbers count as lost")
        state.latch.put(tick, "stream_frozen", frozen, "the same numbers over and over: nothing is captured")
        state.latch.put(tick, "empty_sample", empty and not frozen, "no number at all: nothing is captured")
        return numbers, empty

    def close(self, state: InletState) -> None:
        """Close the stream."""
        state.reader.close()
