"""Text of numbers, joints and metrics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from fesloop.analysis.study.results.quantities import called, with_unit

_MANNERS = {"flexion": "flexion", "abduction": "abduction", "pronation": "pronation",
            "extension": "extension"}


def rounded(value: Any) -> str:
    """Text of a value with three significant digits; "-" for none."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (list, tuple)):
        return ", ".join(rounded(item) for item in value)
    if not isinstance(value, float):
        return str(value)
    if not math.isfinite(value):
        return "-"
    size = abs(value)
    if size >= 1e6 or 0.0 < size < 1e-3:
        return f"{value:.2e}"
    return f"{value:.{0 if size >= 100.0 else 1 if size >= 10.0 else 2 if size >= 1.0 else 3}f}"


def metric_label(name: str) -> str:
    """Label of a metric: "joint RMSE, deg"."""
    return with_unit(*called(name))


def joint_label(freedom: str) -> str:
    """Title of a degree of freedom: "F2 MCP flexion" for "F2_mcp_flexion"; other names are unchanged."""
    parts = freedom.split("_")
    if len(parts) < 2 or parts[-1] not in _MANNERS:
        return freedom.replace("_", " ")
    where = [part.upper() if part in ("mcp", "pip", "dip", "cmc", "ip") else part for part in parts[:-1]]
    return " ".join([*where, parts[-1]])


def listed(items: Sequence[str]) -> str:
    """Items joined for a sentence: "a, b and c"."""
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)


def counted(number: int, what: str) -> str:
    """"1 trial", "3 trials"."""
    return f"{number} {what}{'' if number == 1 else 's'}"
