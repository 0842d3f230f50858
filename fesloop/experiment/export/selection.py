"""Which trials and signals of a recording are exported."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.export.channels import Channel, channels
from fesloop.experiment.recording.reading import Event, Recording
from fesloop.experiment.recording.signal_table import Piece, SignalTable, TableSignal


@dataclass(slots=True)
class Progress:
    """How far an export has come; `tell` is told the fraction.

    Attributes
    ----------
    rows: how many there are, those of each signal of a trial counted.
    done: how many of them are written.
    """

    tell: Callable[[float], object]
    rows: int
    done: int = 0

    def note(self, rows: int) -> None:
        """So many rows have been written."""
        self.done += rows
        self.tell(self.done / self.rows)


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """What of a recording is exported.

    Attributes
    ----------
    recording: open for reading.
    trials: counted from 0.
    among: how many trials the recording had at the start.
    signals: names.
    progress: is kept up to date by `pieces`.
    """

    recording: Recording
    trials: tuple[int, ...]
    among: int
    signals: tuple[str, ...]
    progress: Progress

    def tables(self, trial: int) -> list[SignalTable]:
        """The chosen signals of a trial, node by node."""
        return self.recording.tables(self.signals, trial)

    def pieces(self, table: SignalTable) -> Iterator[Piece]:
        """Rows of a table, piece by piece."""
        for piece in table.pieces():
            yield piece
            self.progress.note(len(piece.times_ns) * len(table.signals))

    def block(self, signal: TableSignal) -> dict[str, Any]:
        """Parameters of a signal's node."""
        found: dict[str, Any] = self.recording.experiment.get("blocks", {}).get(signal.node, {})
        return found

    def channels(self, signal: TableSignal) -> tuple[Channel, ...]:
        """Channels of a signal."""
        return channels(signal, self.block(signal))

    def told(self, table: SignalTable) -> str:
        """What a table is called: the node, or the plant's input."""
        first = table.signals[0]
        return first.name if first.name in self.recording.inputs else first.node

    def events(self, trial: int) -> list[Event]:
        """What was out of the ordinary in a trial; a recording holds that in memory as well."""
        return [event for event in self.recording.events if event.trial == trial]

    def prefix(self, trial: int) -> str:
        """What names of a trial's files begin with: nothing, where the run has but one trial."""
        return "" if self.among == 1 else f"trial-{trial}_"

    def onset(self, trial: int) -> str:
        """When t = 0 of a trial was, UTC: of a run in real time to the us; else of the first alone, to the s.

        Empty where the recording does not say.
        """
        for origin in self.recording.origins:
            if origin["trial"] == trial:
                moment = datetime.fromtimestamp(int(origin["utc_ns"]) // 1000 / 1e6, UTC)
                return f"{moment.replace(tzinfo=None).isoformat(timespec='microseconds')}Z"
        started = str(self.recording.wall.get("started", ""))
        return f"{started[:19]}Z" if trial == 0 and started else ""


def select(recording: Recording, trial: int | None, signals: Sequence[str] | None,
           wanted: Callable[[TableSignal], bool], what: str, tell: Callable[[float], object]) -> Selection:
    """The selection that a user asks for, or all that a format is for.

    Parameters
    ----------
    trial: None for all.
    signals: names; None for all outputs and plant inputs that are `wanted`.
    wanted: whether a format takes a signal where none is named.
    what: the format takes, in a fault where there is none.
    tell: is told the fraction that is written.

    Raises InputError for trials and signals that the recording does not have, and for one without any.
    """
    count = recording.trials
    if count == 0:
        raise InputError(str(recording.path), "holds no row of any trial",
                         "a run that got as far as its first tick")
    if trial is not None and not 0 <= trial < count:
        raise InputError("--trial", f"{trial}", "0" if count == 1 else f"0 to {count - 1}")
    trials = tuple(range(count)) if trial is None else (trial,)
    known = recording.signals + recording.inputs
    if signals is not None:
        _require_known(signals, known)
        chosen = tuple(dict.fromkeys(signals))
    else:
        chosen = _all_wanted(recording, known, trials[0], wanted, what)
    rows = sum(table.count * len(table.signals) for number in trials
               for table in recording.tables(chosen, number))
    return Selection(recording, trials, count, chosen, Progress(tell, rows))


def _all_wanted(recording: Recording, known: Sequence[str], trial: int,
                wanted: Callable[[TableSignal], bool], what: str) -> tuple[str, ...]:
    chosen = tuple(signal.name for table in recording.tables(known, trial)
                   for signal in table.signals if wanted(signal))
    if not chosen:
        raise InputError(str(recording.path), f"records no {what}", "such a signal, or --signals",
                         f"recorded are {', '.join(known) or 'none'}")
    return chosen


def _require_known(signals: Sequence[str], known: Sequence[str]) -> None:
    if not signals:
        raise InputError("--signals", "no name", ", ".join(known))
    for name in signals:
        if name not in known:
            raise InputError("--signals", f"{name!r} is not recorded", ", ".join(known),
                             did_you_mean(name, known))
