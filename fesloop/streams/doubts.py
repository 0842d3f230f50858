"""What a recording shows to be wrong with itself, in words that say what to do."""

from __future__ import annotations

from collections.abc import Sequence

from fesloop.streams.agreement import Agreement, agreements_in, disagreement_text, unjudged_text
from fesloop.streams.clipping import clipped_text
from fesloop.streams.labels import not_understood
from fesloop.streams.missing import lacking_in, repeated_text
from fesloop.streams.mounting import mounting_text
from fesloop.streams.recording import MotionRecording

Doubts = tuple[tuple[str, str], ...]


def doubts(recording: MotionRecording, first: int = 0, stop: int | None = None) -> Doubts:
    """Status and text of each doubt about samples `first` to `stop`."""
    return _doubts(recording, first, stop, agreements_in(recording, first, stop))


def all_doubts(recording: MotionRecording) -> Doubts:
    """Those about a whole recording, with what it lacks and what could not be judged."""
    found = agreements_in(recording)
    more = (("recording_incomplete", lacking_in(recording).text),
            ("rates_not_checked", unjudged_text(recording, found)))
    return *_doubts(recording, 0, None, found), *((status, text) for status, text in more if text)


def _doubts(recording: MotionRecording, first: int, stop: int | None, found: Sequence[Agreement]) -> Doubts:
    every = (("channels_left_out", not_understood(recording.left_out)),
             ("rates_disagree", disagreement_text(recording, found)),
             ("mounting_disagrees", mounting_text(recording, first, stop)),
             ("range_too_small", clipped_text(recording, first, stop)),
             ("repeated_samples", repeated_text(recording, first, stop)))
    return tuple((status, text) for status, text in every if text)
