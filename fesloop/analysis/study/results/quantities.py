"""Quantities and units from names of axes and metrics."""

from __future__ import annotations

_UNITS = {"deg": "deg", "ms": "ms", "s": "s", "min": "min", "mm": "mm", "cm": "cm", "hz": "Hz", "ma": "mA",
          "us": "µs", "ut": "µT", "n": "N", "nc": "nC", "uc": "µC",
          "pct": "%", "percent": "%"}
"""Units by the endings of names in fesloop."""


def called(name: str, label: str = "", unit: str = "") -> tuple[str, str]:
    """Quantity and unit, from `label` and `unit`, else from the name ("latency_ms")."""
    stem, _, end = name.rpartition("_")
    known = stem != "" and end in _UNITS
    text = label or (stem if known else name).replace("_", " ").replace("rmse", "RMSE")
    return text, unit or (_UNITS[end] if known else "")


def with_unit(quantity: str, unit: str) -> str:
    """Label of an axis: quantity and unit."""
    raised = unit.replace("^2", "²").replace("^3", "³")
    return f"{quantity}, {raised}" if unit else quantity


def duration_text(seconds: float) -> str:
    """A duration as text in a suitable unit."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 5400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h" if seconds < 172800.0 else f"{seconds / 86400.0:.1f} days"
