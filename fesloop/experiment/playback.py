"""Playback of a signal of an earlier run: its values leave at the instants at which they left then."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording, Signal
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import StampClock
from fesloop.loop.signals import Port, Value
from fesloop.streams.recording import content_hash, require_the_same


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Playback:
    """Plays one signal of a run's recording, such as the stimulation that a patient received.

    Output `signal`, of the recorded shape and unit, one value a tick of the block's own clock, which stops
    after the last. Values carry the newest capture that they were made of. NaN, where the recorded signal
    had gaps, is played as NaN.

    Attributes
    ----------
    recording: path of the run (.h5).
    signal: "node.port".
    trial: which, counted from 0.
    fingerprint: SHA-256 of the signal as it was read (values, stamps, unit); left out: it is filled in. Where
        it is given, as in the recording of a run, the file must still say the same.
    clock: instants at which the values left (not a parameter).
    played: the signal itself (not a parameter).
    """

    recording: str
    signal: str
    trial: int = 0
    fingerprint: str = ""
    clock: StampClock = field(init=False, repr=False)
    played: Signal = field(init=False, repr=False)

    def __post_init__(self) -> None:
        with Recording(self.recording) as run:
            if not run.trials:
                raise InputError("recording", f"{self.recording} holds no row of any trial",
                                 "one with values")
            if not 0 <= self.trial < run.trials:
                raise InputError("trial", f"{self.trial}, but {self.recording} has {run.trials}",
                                 f"0 to {run.trials - 1}")
            played = run.signal(self.signal, self.trial)
        if not played.times_ns.size:
            raise InputError("signal", f"{self.signal!r} is empty in trial {self.trial} of {self.recording}",
                             "a signal with values")
        found = content_hash([played.unit], [played.values, played.left_ns, played.newest_ns])
        require_the_same(self.recording, self.fingerprint, found)
        object.__setattr__(self, "fingerprint", found)
        played.values.flags.writeable = False
        object.__setattr__(self, "played", played)
        object.__setattr__(self, "clock", StampClock(played.left_ns, f"{self.recording}: {self.signal}"))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """No inputs."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """signal."""
        values: NDArray[np.float64] = self.played.values
        return (Port("signal", values.shape[1:], self.played.unit, gaps=bool(np.isnan(values).any())),)

    def init(self, context: Context) -> None:
        """No state: what is played is a function of the tick."""

    def step(self, state: Any, inputs: Any, tick: Tick) -> tuple[Value, ...]:
        """The value of this tick, read-only."""
        value = self.played.values[tick.index]
        tick.captured_ns = int(self.played.newest_ns[tick.index])
        return (value if value.ndim else float(value),)
