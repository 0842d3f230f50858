"""How far a study is: a line that renews itself on a terminal, and now and then a line elsewhere."""

from __future__ import annotations

import shutil
import sys
import time
from collections import deque
from collections.abc import Mapping

from fesloop.analysis.study.results.quantities import duration_text

_EVERY_S = 15.0
"""Between lines where there is no terminal."""
_RENEW_S = 0.5
_LOOK_BACK_S = 60.0
_SHOWN = 60


class StudyProgress:
    """A `fesloop.analysis.study.engine.pump.Watch` that tells on standard error."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._terminal = sys.stderr.isatty()
        self._told_at = -_EVERY_S
        self._stage = ""
        self._past: deque[tuple[float, int]] = deque()

    def stage(self, text: str, fraction: float | None = None) -> None:
        """What is being done before the runs."""
        line = f"{self._name}: {text}"
        if self._terminal and fraction is not None:
            line += f" {100.0 * fraction:.0f} %"
        if self._terminal or text != self._stage:
            self._tell(line, at_once=text != self._stage)
        self._stage = text

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """Runs that are done, that failed by cause, and all."""
        over = done + sum(failed.values())
        self._past.append((time.monotonic(), over))
        while self._past[-1][0] - self._past[0][0] > _LOOK_BACK_S:
            self._past.popleft()
        line = f"{self._name}: {over} of {total} runs"
        rate = self._rate()
        if rate > 0.0 and over < total:
            line += f", {_rate_text(rate)}, {duration_text((total - over) / rate)} left"
        if failed:
            worst = max(failed, key=failed.__getitem__)
            line += f", {sum(failed.values())} failed, most: {worst[:_SHOWN]}"
        self._tell(line, at_once=over == total)

    def finish(self) -> None:
        """Take the line away."""
        if self._terminal:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    def _rate(self) -> float:
        """Runs a second, of the last minute."""
        (first_s, first), (last_s, last) = self._past[0], self._past[-1]
        return (last - first) / (last_s - first_s) if last_s > first_s else 0.0

    def _tell(self, line: str, *, at_once: bool) -> None:
        now = time.monotonic()
        if not at_once and now - self._told_at < (_RENEW_S if self._terminal else _EVERY_S):
            return
        self._told_at = now
        if self._terminal:
            # A line that wraps could not be taken away again.
            line = line[:shutil.get_terminal_size().columns - 1]
            print(f"\r\x1b[K{line}", end="", file=sys.stderr, flush=True)
        else:
            print(line, file=sys.stderr, flush=True)


def _rate_text(rate: float) -> str:
    return f"{rate:.1f} a second" if rate >= 1.0 else f"{60.0 * rate:.1f} a minute"
