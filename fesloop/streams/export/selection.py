"""Which trials and signals of a recording are exported."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.reading import Event, Recording
from fesloop.experiment.signal_table import Piece, SignalTable, TableSignal
from fesloop.streams.export.channels import Channel, channels


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
    signals: names.
    progress: is kept up to date by `pieces`.
    """

    recording: Recording
    trials: tuple[int, ...]
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
        return "" if self.recording.trials == 1 else f"trial-{trial}_"


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
    where, count = str(recording.path), recording.trials
    if count == 0:
        raise InputError(where, "holds no row of any trial", "a run that got as far as its first tick")
    if trial is not None and not 0 <= trial < count:
        raise InputError("--trial", f"{trial}", "0" if count == 1 else f"0 to {count - 1}")
    trials = tuple(range(count)) if trial is None else (trial,)
    known = recording.signals + recording.inputs
    if signals is not None:
        _require_known(signals, known)
        return _selection(recording, trials, tuple(dict.fromkeys(signals)), tell)
    chosen = tuple(signal.name for table in recording.tables(known, trials[0])
                   for signal in table.signals if wanted(signal))
    if not chosen:
        raise InputError(where, f"records no {what}", "such a signal, or --signals",
                         f"recorded are {', '.join(known) or 'none'}")
    return _selection(recording, trials, chosen, tell)


def _selection(recording: Recording, trials: tuple[int, ...], signals: tuple[str, ...],
               tell: Callable[[float], object]) -> Selection:
    rows = sum(table.count * len(table.signals) for trial in trials
               for table in recording.tables(signals, trial))
    return Selection(recording, trials, signals, Progress(tell, rows))


def _require_known(signals: Sequence[str], known: Sequence[str]) -> None:
    if not signals:
        raise InputError("--signals", "no name", ", ".join(known))
    for name in signals:
        if name not in known:
            raise InputError("--signals", f"{name!r} is not recorded", ", ".join(known),
                             did_you_mean(name, known))


def file_name(name: str) -> str:
    """A name that any file system takes: what is no letter, digit, dot, dash or underscore is one."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", name).lstrip(".") or "_"


def unique(names: Sequence[str], between: str = "_") -> list[str]:
    """The same names, those that stand there already, in small or capital letters, with a number behind."""
    found: list[str] = []
    for name in names:
        number, tried = 1, name
        while tried.lower() in {other.lower() for other in found}:
            number += 1
            tried = f"{name}{between}{number}"
        found.append(tried)
    return found
