"""Ranges of motion of the hand's joints, in one table.

Degrees; positive are flexion, ulnar deviation (of a finger: towards the little finger's side) and pronation,
from the pose in which every segment is parallel to the palm's middle line. Trackers clip to these, so where
a source gives a typical range of the population and not a limit, it stands with the tolerance named.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

SALCHOW = "Salchow-Hoemmen 2019, doi 10.3390/s19010208, section 2.4.3: from anatomy texts, with tolerance"
TEXTBOOK = "Electronic Textbook of Hand Surgery, e-hand.com: typical range of motion"
CHOSEN_DEVIATION = ("20 of abduction (clinical norm, gpnotebook.com) and a chosen tolerance of 15, by which "
                    "fingers at rest lie off the palm's middle line (An and Cooney 1991)")
CHOSEN_THUMB = ("chosen: 45 of palmar and 60 of radial abduction (e-hand.com) with a tolerance of 15; "
                "pronation 22 beyond the 88 in which Sancho-Bru 2012 has the thumb at rest")


class Range(NamedTuple):
    """Lowest and highest angle, degrees, and where they come from."""

    low_deg: float
    high_deg: float
    source: str


RANGES: dict[str, tuple[Range, ...]] = {
    "wrist": (Range(-70.0, 75.0, TEXTBOOK), Range(-20.0, 35.0, TEXTBOOK)),
    "thumb_cmc": (Range(-25.0, 60.0, CHOSEN_THUMB), Range(-75.0, 15.0, CHOSEN_THUMB),
                  Range(-30.0, 110.0, CHOSEN_THUMB)),
    "thumb_mcp": (Range(-10.0, 55.0, TEXTBOOK),),
    "thumb_ip": (Range(-15.0, 80.0, TEXTBOOK),),
    "mcp": (Range(-45.0, 90.0, TEXTBOOK), Range(-35.0, 35.0, CHOSEN_DEVIATION)),
    "pip": (Range(-20.0, 100.0, SALCHOW),),
    "dip": (Range(-20.0, 100.0, SALCHOW),),
}
"""By joint: flexion, then abduction, then pronation, as far as the joint has them."""


def radians(joint: str) -> tuple[tuple[float, float], ...]:
    """Ranges of a joint of the table, rad."""
    return tuple((float(np.deg2rad(row.low_deg)), float(np.deg2rad(row.high_deg))) for row in RANGES[joint])
