"""Output of commands: one JSON object or path on standard output; tables and progress on standard error."""

from __future__ import annotations

import json
import math
import shlex
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any, TextIO

from fesloop.errors import InputError

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

_QUIET_S = 2.0
_REFRESH_HZ = 2.0


def print_json(table: Any) -> None:
    """Print one JSON object; numbers that are not finite become null."""
    print(as_json(table))


def print_made(kind: str, path: Path, report: dict[str, Any], show: Callable[[dict[str, Any]], None], *,
               as_json: bool) -> None:
    """Print the file that a command wrote and its report, as one JSON object or by `show`."""
    if as_json:
        print_json({kind: str(path), **report})
    else:
        show(report)
        print(path)


def print_doubts(recording: str, doubts: Iterable[tuple[str, str]]) -> None:
    """Print doubtful properties of a recording (`fesloop.streams.doubts`) to standard error, a line each."""
    for status, text in doubts:
        what = "channels left out, " if status == "channels_left_out" else ""
        print(f"fesloop: {recording}: {what}{text}", file=sys.stderr)


def as_json(table: Any) -> str:
    """Return the text of one JSON object; numbers that are not finite become null."""
    return json.dumps(_json_value(table), indent=2, allow_nan=False)


def _json_value(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _json_value(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_json_value(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], file: TextIO) -> None:
    """Print a table under its title; columns of numbers are aligned to the right."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    for number, column in enumerate(columns):
        numeric = bool(rows) and all(_is_number(row[number]) for row in rows)
        table.add_column(Text(column), justify="right" if numeric else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console = Console(file=file, width=None if file.isatty() else 120)
    console.print(Text(title, style="table.title"))
    console.print(table)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return text in ("", "-")
    return True


class _Bar:
    """A progress bar on a terminal that appears after two seconds of work.

    A timer shows it, so that it also appears while no progress is reported, as when code is compiled or a
    file is read.
    """

    def __init__(self, title: str) -> None:
        self._title = title
        self._fraction = 0.0
        self._over = False
        self._bar: tuple[Progress, TaskID] | None = None
        self._lock = threading.Lock()
        self._timer = threading.Timer(_QUIET_S, self._show)
        self._timer.daemon = True
        if sys.stderr.isatty():
            self._timer.start()

    def __call__(self, fraction: float) -> None:
        """Show that this fraction of the work is done."""
        with self._lock:
            self._fraction = fraction
            if self._bar is not None:
                bar, task = self._bar
                bar.update(task, completed=fraction, refresh=True)

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        with self._lock:
            if self._over:
                return
            bar = Progress(TextColumn(self._title), BarColumn(), TextColumn("{task.percentage:3.0f} %"),
                           TimeElapsedColumn(), TimeRemainingColumn(), console=Console(file=sys.stderr),
                           refresh_per_second=_REFRESH_HZ, transient=True)
            self._bar = bar, bar.add_task("", total=1.0)
            bar.update(self._bar[1], completed=self._fraction)
            bar.start()

    def finish(self) -> None:
        """Remove the bar."""
        self._timer.cancel()
        with self._lock:
            self._over = True
            if self._bar is not None:
                self._bar[0].stop()


@contextmanager
def progress_bar(title: str) -> Iterator[_Bar]:
    """Context with a function that takes the fraction done; prints to a terminal only, after two seconds."""
    bar = _Bar(title)
    try:
        yield bar
    finally:
        bar.finish()


def print_next_commands(results: Path, commands: Iterable[str]) -> None:
    """Print the command that makes a report of these results, and those to try next, to standard error."""
    print(f"report: fesloop report {shlex.quote(str(results))}", file=sys.stderr)
    for command in commands:
        print(f"next:   {command}", file=sys.stderr)


def free_target(given: str, where: str) -> Path:
    """Return the path of a file to be written, checked before the work starts; makes its folders.

    Parameters
    ----------
    given: the path. where: name of the argument, for messages.

    Raises InputError if the file exists or cannot be made.
    """
    path = Path(given)
    try:
        there = path.exists() or path.is_symlink()
        path.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=path.parent):
            pass
    except OSError as fault:
        raise InputError(where, f"cannot be written: {fault.strerror or fault}",
                         "a path in a writable folder") from None
    if there:
        raise InputError(where, "exists already", "a new name", "give another name, or remove the file")
    return path
