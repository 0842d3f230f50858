import pytest
from study_stores import write_store

from fesloop.show.figures.content import Overlay
from fesloop.show.figures.theory_overlays import keep_overlays

LATENCIES, JITTERS, LAWS = [0, 20, 40], [0, 5], ["pid", "mpc"]
AXES = {"latency_ms": {"levels": LATENCIES, "label": "latency", "unit": "ms"}, "jitter_ms": JITTERS,
        "law": LAWS}
MAP = {"name": "map", "kind": "heat_map", "metric": "error_deg", "x": "latency_ms", "y": "jitter_ms",
       "panels": "law", "label": "error"}
BY_LAW = {"name": "laws", "kind": "heat_map", "metric": "error_deg", "x": "latency_ms", "y": "law"}
CURVES = {"name": "curves", "kind": "curves", "metric": "error_deg", "x": "latency_ms", "by": "law"}
OVER_LAWS = {"name": "over_laws", "kind": "curves", "metric": "error_deg", "x": "law", "by": "jitter_ms"}
CREATED = "2026-01-01T00:00:00+00:00"


def error(levels, replicate=0):
    """Least at no latency, no jitter, under mpc; noise that is the same in all cells."""
    late = 0.1 * levels["latency_ms"] + 0.01 * levels["jitter_ms"]
    return 1.0 + late + (levels["law"] == "pid") + 0.5 * replicate


def outcome(levels, replicate):
    if levels["law"] == "pid" and levels["latency_ms"] == 40 and replicate == 0:
        return "the QP is infeasible"
    return {"error_deg": error(levels, replicate), "held": float(levels["law"] == "mpc")}


@pytest.fixture
def make(tmp_path):
    """Writes a store in a folder of its own; its path."""
    def made(outcome=outcome, axes=AXES, figures=(MAP, BY_LAW, CURVES, OVER_LAWS), replicates=2, **more):
        study = {"figures": list(figures), **more.pop("study", {})}
        return write_store(tmp_path / "study.sqlite", axes, replicates, outcome, ("error_deg", "held"),
                           study=study, **more)
    return made


@pytest.fixture
def with_theory(make):
    """A store beside which theory's lines were kept."""
    path = make()
    keep_overlays(path.parent, CREATED, {
        "map": [Overlay(label="theory", x=[30.0, 10.0], y=[0.0, 5.0], panel="pid")],
        "curves": [Overlay(label="theory", x=[25.0], line="mpc")]})
    return path
