"""Which end of a metric is the good one."""

from __future__ import annotations

from typing import Literal

from fesloop.analysis.study.results.study_results import StudyResults

Better = Literal["low", "high"]
_HIGH = frozenset({"held", "held_s", "grip_margin", "grasps_until_fatigue", "found_quality",
                   "found_selectivity", "of_optimum", "fingertip_coverage"})
"""Metrics of runs (`fesloop.experiment.metrics`) of which more is better."""
_LOW = ("rmse", "rmse_deg", "rmse_mm", "rmse_n", "error_deg", "minutes", "queries", "charge_uc",
        "object_moved_mm", "unwanted_motion_deg", "decline_pct", "time_to_grasp_s")
"""Ends of the names of those of which less is better."""


def better_end(results: StudyResults, metric: str) -> Better | None:
    """The good end of a study's metric, by what it is in a run; None where that is not known."""
    kept = str(results.study.get("study", {}).get("metrics", {}).get(metric, metric))
    parts = kept.partition(":")[0].split(".")
    if any(part in _HIGH for part in parts):
        return "high"
    if any(part.endswith(_LOW) for part in (*parts, metric)):
        return "low"
    return None
