"""Section of a report on statuses, events and lost messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from fesloop.experiment.recording.reading import Event
from fesloop.experiment.trouble import graveness
from fesloop.show.report.parts import Fold, Paragraph, Part, Section, Table
from fesloop.show.report.run.known import Known, seconds
from fesloop.show.report.run.words import counted

_MOST_TOLD = 400
"""Events listed one by one (chosen)."""


def events_section(known: Known) -> Section:
    """Section with the counts of all reported statuses, and the first events one by one."""
    return Section(key="events", title="Statuses and events",
                   parts=[*_events(known.recording.events), *_messages(known)])


def _events(events: Sequence[Event]) -> Iterator[Part]:
    if not events:
        yield Paragraph(text="No block or wire reported a status.")
        return
    first: dict[tuple[str, str], Event] = {}
    last: dict[tuple[str, str], Event] = {}
    counts = Counter((event.where, event.status) for event in events)
    for event in events:
        first.setdefault((event.where, event.status), event)
        last[event.where, event.status] = event
    gravest = sorted(first.items(), key=lambda entry: graveness(entry[0][1]))
    rows = [[_what(event), str(counts[key]), _when(event), _when(last[key])] for key, event in gravest]
    yield Table(title="By block and status, with the first message", rows=rows,
                columns=["what", "times", "first (trial: time)", "last"])
    shown = events[:_MOST_TOLD]
    which = counted(len(events), "event") if len(shown) == len(events) else \
        f"The first {len(shown)} of {len(events)} events"
    yield Fold(title=which, parts=[Table(columns=["trial: time", "what"], rows=[
        [_when(event), _what(event)] for event in shown])])


def _what(event: Event) -> str:
    detail = f": {event.detail}" if event.detail else ""
    return f"{event.where} `{event.status}`{detail}"


def _when(event: Event) -> str:
    # Spaces that no line breaks at: columns are narrow on a telephone.
    return f"{event.trial}:\N{NO-BREAK SPACE}{seconds(event.time_ns):.3f}\N{NO-BREAK SPACE}s"


def _messages(known: Known) -> Iterator[Part]:
    """Table of wires with lost or late messages, summed over the completed trials."""
    sums: dict[str, Counter[str]] = {}
    for trial in known.recording.messages:
        for wire, counts in trial.items():
            sums.setdefault(wire, Counter()).update(counts)
    rows = [[wire, *(str(counts[key]) for key in ("sent", "lost", "late"))]
            for wire, counts in sums.items() if counts["lost"] or counts["late"]]
    if rows:
        yield Table(title="Messages that were lost, or dropped because they were late",
                    columns=["wire", "sent", "lost", "late"], rows=rows)
    elif sums:
        yield Paragraph(text="No message was lost or late.")
