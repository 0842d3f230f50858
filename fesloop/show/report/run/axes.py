"""Ends of axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fesloop.show.report.parts import Line


def from_zero(lines: Sequence[Line]) -> tuple[float, float]:
    """Of an axis of what is never below 0: from there to a little above all that is drawn."""
    values = [line.y if line.high is None else line.high for line in lines]
    known = [float(each[np.isfinite(each)].max(initial=0.0)) for each in values]
    return 0.0, 1.05 * max(known, default=0.0) or 1.0
