"""Opening a run's file for its report, also one that is damaged or from another version."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from fesloop.experiment.recording.reading import Recording


@contextmanager
def readable(path: Path) -> Iterator[tuple[Recording, Sequence[str]]]:
    """A recording, and what is known to be missing of its file, a sentence each."""
    with Recording(path) as recording:
        yield recording, ()
