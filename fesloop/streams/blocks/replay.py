"""A recording as a block: its samples leave at its own stamps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, StampClock, duration_ns
from fesloop.loop.signals import Port, Sensors, Value
from fesloop.streams.doubts import doubts, missing_text
from fesloop.streams.files import open_recording
from fesloop.streams.pace import Gap, timeline
from fesloop.streams.recording import MotionRecording, require_the_same


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Replay:
    """Plays a recording of inertial sensors with its own stamps.

    Outputs `gyr` (n, 3) rad/s, `acc` (n, 3) m/s^2 and, where the recording has it, `mag` (n, 3) T, one
    sample a tick of the block's own clock, which stops after the last sample. NaN is a sample that the
    recording lost, of that sensor alone. In a gap of the recording's stamps the clock ticks on at the
    pace of the samples (`fesloop.streams.pace`), and all outputs are NaN.

    Status: with the first sample `channels_left_out`, of a file with channels that are not understood,
    `recording_incomplete`, which says how much the recording lacks, `rates_disagree`, which names sensors
    whose gyroscope and accelerometer do not show the same turn, `mounting_disagrees`, which names those whose
    axes are not those of their segments, `range_too_small`, where samples are clipped, `repeated_samples`,
    which names sensors that repeat a sample for long; `gap` at the start of each gap.

    Attributes
    ----------
    recording: path of the file (see `fesloop.streams.files.open_recording`).
    sensor_set: set of sensors, where the file holds several; None takes the first.
    layout: path of a layout file, for a recording that says too little of itself.
    start_s: beginning of the recording to leave out; the first sample at or after it plays at t = 0.
    duration_s: length to play; None plays to the end.
    fingerprint: SHA-256 of the whole recording as it was read (samples, stamps, sensors, pairs, reference);
        left out: it is filled in. Where it is given, as in the recording of a run, the file must have it.
    clock: instants of the samples, those that gaps lack among them (not a parameter).
    start_ns: stamp, in the recording, of the sample that plays at t = 0 (not a parameter).
    source: the recording itself (not a parameter).
    """

    recording: str
    sensor_set: str | None = None
    layout: str | None = None
    start_s: float = 0.0
    duration_s: float | None = None
    fingerprint: str = ""
    clock: StampClock = field(init=False, repr=False)
    start_ns: int = field(init=False, repr=False)
    source: MotionRecording = field(init=False, repr=False)
    _rows: NDArray[np.int64] = field(init=False, repr=False)
    _gaps: dict[int, Gap] = field(init=False, repr=False)
    _missing: str = field(init=False, repr=False)
    _doubts: tuple[tuple[str, str], ...] = field(init=False, repr=False)
    _nothing: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        source = open_recording(self.recording, self.sensor_set, self.layout)
        fingerprint = source.fingerprint()
        require_the_same(self.recording, self.fingerprint, fingerprint)
        start = duration_ns(self.start_s, NS_PER_S, "start_s")
        first = int(np.searchsorted(source.stamps_ns, start))
        if first == source.samples:
            raise InputError("start_s", f"{self.start_s} is past the last sample of {self.recording}",
                             f"at most {source.duration_ns / NS_PER_S:g}")
        start_ns = int(source.stamps_ns[first])
        end_ns = source.duration_ns
        if self.duration_s is not None:
            length = duration_ns(self.duration_s, NS_PER_S, "duration_s")
            if length == 0:
                raise InputError("duration_s", f"{self.duration_s:g} plays nothing",
                                 "above 0, or left out to play to the end")
            end_ns = min(end_ns, start_ns + length)
        stop = int(np.searchsorted(source.stamps_ns, end_ns, side="right"))
        # With the first sample after the part, a part that ends in a gap is as long as it should be.
        line = timeline(source.stamps_ns[first:stop + 1] - start_ns, self.recording)
        within = line.stamps_ns <= end_ns - start_ns
        nothing = np.full((len(source.sensors), 3), np.nan)
        nothing.flags.writeable = False
        for name, value in (
                ("fingerprint", fingerprint), ("source", source), ("start_ns", start_ns),
                ("_nothing", nothing), ("_gaps", line.gaps),
                ("clock", StampClock(line.stamps_ns[within], self.recording)),
                ("_rows", np.where(line.rows < 0, line.rows, line.rows + first)[within]),
                ("_doubts", doubts(source, first, stop)),
                ("_missing", missing_text(source, first, stop, list(line.gaps.values())))):
            object.__setattr__(self, name, value)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """No inputs."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """gyr, acc and, where there is one, mag."""
        shape = (len(self.source.sensors), 3)
        sensors = Sensors(self.source.sensors, self.source.pairs)
        ports = (Port("gyr", shape, "rad/s", gaps=True, sensors=sensors),
                 Port("acc", shape, "m/s^2", gaps=True, sensors=sensors))
        return ports if self.source.mag is None else (
            *ports, Port("mag", shape, "T", gaps=True, sensors=sensors))

    def cautions(self, context: Context) -> tuple[tuple[str, str], ...]:
        """Faults that the samples show, and what the recording lacks."""
        return self._reports()

    def _reports(self) -> tuple[tuple[str, str], ...]:
        return (*self._doubts, *((("recording_incomplete", self._missing),) if self._missing else ()))

    def init(self, context: Context) -> None:
        """No state: the sample is a function of the tick."""

    def step(self, state: Any, inputs: Any, tick: Tick) -> tuple[Value, ...]:
        """The sample of this tick, read-only."""
        source = self.source
        if tick.index == 0:
            tick.reports.extend(self._reports())
        if tick.index in self._gaps:
            tick.report("gap", str(self._gaps[tick.index]))
        at = int(self._rows[tick.index])
        if at < 0:
            return (self._nothing,) * len(self.outputs)
        if source.mag is None:
            return source.gyr[at], source.acc[at]
        return source.gyr[at], source.acc[at], source.mag[at]


def replay_of(table: Mapping[str, Any]) -> Replay:
    """The replay in a block's table of a recorded experiment, whatever other keys it has.

    Raises InputError for a recording that is not there any more, or has changed.
    """
    parameters = {each.name for each in fields(Replay) if each.init}
    return Replay(**{key: value for key, value in table.items() if key in parameters})
