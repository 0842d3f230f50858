"""Errors that a user sees as one line: where, what was found, what is allowed, what to do."""

from __future__ import annotations

import traceback
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

_LONGEST, _LONGEST_LINE, _END = 400, 3000, 100
"""Characters of a place or a value in a message, of a message, and of the end that a cut one keeps."""

RENAMED = {
    "about_z_share": "flexion_axis_share",
    "asked": "intended",
    "fingertip_force": "force_sensors",
    "fingertips": "places",
    "found_quality": "found_true_quality",
    "found_selectivity": "found_true_selectivity",
    "not_known": "missing",
    "of_optimum": "optimum_share",
    "sensors": "places",
    "thumb": "places",
    "unseen_deg_s": "untracked_deg_s",
    "unsure_deg": "uncertain_deg",
    "wanted": "target",
    "wanted_n": "target_n",
}
"""Former names that users' files may hold (keys, kinds, ports, metrics), each with its present name."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Remedy for an unknown name: its present name, or the known name most like it; empty if none is."""
    known = list(known)
    if RENAMED.get(name) in known:
        return f"{name!r} is now called {RENAMED[name]!r}"
    close = get_close_matches(name, known, 1)
    return f"did you mean {close[0]!r}?" if close else ""


def where_it_broke(fault: Exception) -> str:
    """Exception and the line of code that raised it."""
    frames = traceback.extract_tb(fault.__traceback__)
    at = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    return f"{type(fault).__name__}: {fault}{at}"


def in_one_line(text: str, longest: int = _LONGEST) -> str:
    """A text as one line that a terminal shows as it is: control characters escaped, too long a text cut."""
    line = "".join(each if each.isprintable() else ascii(each)[1:-1] for each in " ".join(text.split()))
    return line if len(line) <= longest else f"{line[:longest - _END]} ... {line[-_END:]}"


class FesloopError(Exception):
    """Base of every error that fesloop raises on purpose; its text is one line."""

    def _render_traceback_(self) -> list[str]:
        """Lines that a notebook shows: the text, which says what to do, without the library's own lines."""
        return [f"{type(self).__name__}: {self}"]


class InputError(FesloopError, ValueError):
    """Something the user gave cannot be used (exit code 2).

    Parameters
    ----------
    where: file, key path, block or wire that is at fault; or the whole text, with nothing else: so Gymnasium
        makes an error of a worker process anew.
    found: the value found.
    allowed: the values expected.
    remedy: what to do about it.
    """

    def __init__(self, where: str, found: str = "", allowed: str = "", remedy: str = "") -> None:
        self.where, self.found, self.allowed, self.remedy = where, found, allowed, remedy
        text = f"{in_one_line(where)}: {in_one_line(found)}" if found else in_one_line(where, _LONGEST_LINE)
        if allowed:
            text += f"; allowed: {allowed}"
        if remedy:
            text += f"; {remedy}"
        super().__init__(in_one_line(text, _LONGEST_LINE))

    def within(self, place: str) -> InputError:
        """The same, its place led by another: the file that it is in, or the key of that file."""
        return InputError(f"{place}: {self.where}", self.found, self.allowed, self.remedy)

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str, str]]:
        return InputError, (self.where, self.found, self.allowed, self.remedy)


class InputErrors(InputError):
    """Several faults of one file, all named at once; `faults` holds them, one line each."""

    def __init__(self, faults: list[InputError]) -> None:
        self.faults = faults
        first = faults[0]
        super().__init__(first.where, first.found, first.allowed, first.remedy)

    def within(self, place: str) -> InputErrors:
        """The same, every place led by another."""
        return InputErrors([fault.within(place) for fault in self.faults])

    def __reduce__(self) -> tuple[type[InputErrors], tuple[list[InputError]]]:  # type: ignore[override]
        return InputErrors, (self.faults,)

    def __str__(self) -> str:
        return "\n".join(str(fault) for fault in self.faults)


class RunError(FesloopError, RuntimeError):
    """A run failed for a reason of its own (exit code 1); what was recorded until then is kept."""


class SnapshotError(FesloopError, RuntimeError):
    """A running loop contains a state that cannot be saved or restored."""
