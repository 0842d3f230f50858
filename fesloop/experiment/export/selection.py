"""Selection of the trials and signals of a recording that are exported."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.export.channels import Channel, channels
from fesloop.experiment.recording.reading import Event, Piece, Recording, SignalTable, TableSignal


@dataclass(slots=True)
class Progress:
    """Progress of an export, reported by `tell(fraction)`.

    Attributes
    ----------
    rows: rows of all signals and trials.
    done: rows that are written.
    """

    tell: Callable[[float], object]
    rows: int
    done: int = 0

    def note(self, rows: int) -> None:
        """Count written rows."""
        self.done += rows
        self.tell(self.done / self.rows)


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """The part of a recording that is exported.

    Attributes
    ----------
    recording: open for reading.
    trials: counted from 0.
    among: trials of the recording when the export began.
    signals: names.
    progress: updated by `pieces`.
    """

    recording: Recording
    trials: tuple[int, ...]
    among: int
    signals: tuple[str, ...]
    progress: Progress

    def tables(self, trial: int) -> list[SignalTable]:
        """Selected signals of a trial, node by node."""
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

    def name_of(self, table: SignalTable) -> str:
        """Name of a table: that of its node, or of the plant's input."""
        first = table.signals[0]
        return first.name if first.name in self.recording.inputs else first.node

    def events(self, trial: int) -> list[Event]:
        """Events of a trial, all at once: a recording has them in memory too."""
        return [event for event in self.recording.events if event.trial == trial]

    def prefix(self, trial: int) -> str:
        """Prefix of the names of a trial's files; empty for a run of one trial."""
        return "" if self.among == 1 else f"trial-{trial}_"

    def onset(self, trial: int) -> str:
        """UTC of t = 0 of a trial: to the us for a run in real time, else to the s and for the first trial.

        Empty if unknown.
        """
        for origin in self.recording.origins:
            if origin["trial"] == trial:
                moment = datetime.fromtimestamp(int(origin["utc_ns"]) // 1000 / 1e6, UTC)
                return f"{moment.replace(tzinfo=None).isoformat(timespec='microseconds')}Z"
        started = str(self.recording.wall.get("started", ""))
        return f"{started[:19]}Z" if trial == 0 and started else ""


def select(recording: Recording, trial: int | None, signals: Sequence[str] | None,
           takes: Callable[[TableSignal], bool], what: str, tell: Callable[[float], object]) -> Selection:
    """Make the selection that a user names, or the one that a format takes by itself.

    Parameters
    ----------
    trial: None for all.
    signals: names; None for all outputs and plant inputs that the format `takes`.
    takes: whether the format takes a signal if none is named.
    what: noun for the signals of the format, in the message if there is none.
    tell: receives the fraction that is written.

    Raises InputError for trials and signals that the recording does not have, and for one without any.
    """
    count = recording.trials
    if count == 0:
        raise InputError(str(recording.path), "has no row of any trial",
                         "a run that reached its first tick")
    if trial is not None and not 0 <= trial < count:
        raise InputError("--trial", f"{trial}", "0" if count == 1 else f"0 to {count - 1}")
    trials = tuple(range(count)) if trial is None else (trial,)
    known = recording.signals + recording.inputs
    if signals is not None:
        _require_known(signals, known)
        chosen = tuple(dict.fromkeys(signals))
    else:
        chosen = _all_taken(recording, known, trials[0], takes, what)
    rows = sum(table.count * len(table.signals) for number in trials
               for table in recording.tables(chosen, number))
    return Selection(recording, trials, count, chosen, Progress(tell, rows))


def _all_taken(recording: Recording, known: Sequence[str], trial: int,
               takes: Callable[[TableSignal], bool], what: str) -> tuple[str, ...]:
    chosen = tuple(signal.name for table in recording.tables(known, trial)
                   for signal in table.signals if takes(signal))
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
