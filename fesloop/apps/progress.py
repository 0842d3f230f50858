"""Progress of runs and studies started from Python: on a terminal as from the command line, in a notebook as
a line below the cell, elsewhere none."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from html import escape
from importlib import import_module
from typing import Any

from fesloop.analysis.study.engine.tasks import Nobody, Watch
from fesloop.apps.cli.output import progress_bar

_REFRESH_S = 0.5
_QUIET_S = 2.0
"""As of the command line's bar."""


class NotebookLine:
    """A line of text in the output of a notebook's cell, shown after two seconds and removed at the end."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._handle: Any = None
        self._shown_at = time.monotonic() + _QUIET_S - _REFRESH_S

    def show(self, text: str) -> None:
        """Show a text, at most twice a second."""
        if time.monotonic() - self._shown_at < _REFRESH_S:
            return
        self._shown_at = time.monotonic()
        self._display(f"{self._title}: {text}")

    def _display(self, text: str) -> None:
        display: Any = import_module("IPython.display").display  # there in a notebook
        shown = {"text/html": f"<small>{escape(text)}</small>" if text else "", "text/plain": text}
        if self._handle is None:
            self._handle = display(shown, raw=True, display_id=True)
        else:
            self._handle.update(shown, raw=True)

    def close(self) -> None:
        """Remove the line."""
        if self._handle is not None:
            self._display("")

    def fraction(self, done: float) -> None:
        """Show the progress of a run."""
        self.show(f"{100.0 * done:.0f} %")

    def stage(self, text: str, fraction: float | None = None) -> None:
        """Show a stage of a study before its runs."""
        self.show(text if fraction is None else f"{text} {100.0 * fraction:.0f} %")

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """Show the progress of a study's runs."""
        lost = sum(failed.values())
        self.show(f"{done + lost} of {total} runs" + (f", {lost} failed" if lost else ""))


def in_notebook() -> bool:
    """Whether the code runs in a notebook's kernel."""
    ipython: Any = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return hasattr(shell, "kernel")


@contextmanager
def run_progress(title: str) -> Iterator[Callable[[float], None]]:
    """Context with a function that takes the fraction done of a run."""
    if not in_notebook():
        with progress_bar(title) as bar:
            yield bar
        return
    line = NotebookLine(title)
    try:
        yield line.fraction
    finally:
        line.close()


@contextmanager
def study_progress(name: str) -> Iterator[Watch]:
    """Context with the watch of a study."""
    if in_notebook():
        line = NotebookLine(name)
        try:
            yield line
        finally:
            line.close()
    elif sys.stderr.isatty():
        from fesloop.apps.cli.study_command import StudyProgress

        progress = StudyProgress(name)
        try:
            yield progress
        finally:
            progress.finish()
    else:
        yield Nobody()
