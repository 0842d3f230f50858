"""The hand in motion."""

from __future__ import annotations

from fesloop.show.report.parts import Section
from fesloop.show.report.run.known import Known


def hand_section(known: Known) -> Section | None:
    """None for a run without a hand of which postures are recorded."""
    from fesloop.show.report.motion import hand_motion

    figure = hand_motion(known.recording)
    return None if figure is None else Section(key="hand", title="The hand", parts=[figure])
