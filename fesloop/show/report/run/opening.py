"""Opening a run's file for its report, also one that is damaged or from another version."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording, open_file
from fesloop.experiment.recording.rescue import rescued
from fesloop.experiment.recording.writing import FORMAT
from fesloop.given_files import is_file


@contextmanager
def readable(path: Path) -> Iterator[tuple[Recording, Sequence[str]]]:
    """A recording, and what is known to be missing of its file, a sentence each.

    Of a damaged file, what is left of it. Raises InputError for one of which nothing is left that is known.
    """
    with ExitStack() as stack:
        try:
            recording, notices = _sound(path, stack), []
        except InputError as fault:
            if not is_file(path):
                raise
            try:
                found = stack.enter_context(rescued(path))
                recording = _sound(found.path, stack)
            except InputError:
                raise fault from None
            notices = [f"The file is damaged ({fault.found}). What is left of it is shown.", *found.losses]
        form = _form(recording.path)
        if form != FORMAT:
            notices = [f"The file says that it is a {form!r}; what is known of a {FORMAT!r} is shown, and "
                       "what another version added is not.", *notices]
        yield recording, notices


def _sound(path: Path, stack: ExitStack) -> Recording:
    """A recording whose tables can all be read."""
    recording = stack.enter_context(Recording(path))
    _ = recording.trials, recording.status, recording.wall, recording.events, recording.messages
    return recording


def _form(path: Path) -> str:
    with open_file(path) as file:
        return str(file.attrs["format"])
