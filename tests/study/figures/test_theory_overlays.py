"""Lines of theory over figures: those of the experiments of the very cells."""

import pytest

import fesloop
from fesloop.analysis.study import study_of
from fesloop.analysis.study.design.figure_specs import Figure
from fesloop.analysis.theory import critical_latency_ms, stationary_cost
from fesloop.errors import InputError
from fesloop.show.figures.theory_overlays import theory_overlays

WIRE = "tracker.angles->controller.measured"


def study(experiment, axes, **about):
    about = {"metrics": {"rms_deg": "joint_rmse_deg"}, **about}
    return study_of({"study": {"name": "theory", "experiment": experiment, **about},
                     "axes": axes})


def figure(**told):
    return Figure(name="cost", metric="rms_deg", x="latency_ms", **told)


def test_the_exact_cost_is_that_of_each_cell_and_ends_where_the_loop_is_unstable():
    asked = study("linear_loop", {"latency_ms": {"values": [0, 60, 200]}, "loss": {"values": [0.0, 0.3]}})
    overlays = theory_overlays(asked, figure(kind="curves", by="loss", theory="stationary_cost"))
    assert [overlay.line for overlay in overlays] == [0.0, 0.3]
    for overlay in overlays:
        assert list(overlay.x) == [0, 60]
        for latency_ms, rms_deg in zip(overlay.x, overlay.y, strict=True):
            experiment = fesloop.load("linear_loop", [f"latency_ms={latency_ms}", f"loss={overlay.line}"])
            assert rms_deg == pytest.approx(stationary_cost(experiment).joint_rms_deg, rel=1e-12)


def test_the_critical_latency_is_found_between_levels_and_only_of_linear_loops():
    axes = {"latency_ms": {"values": [0, 50, 100, 150]},
            "controller": {"options": {"pid": {"settings": ["control=pid"]}, "mpc": {}}}}
    overlays = theory_overlays(study("finger_control", axes), figure(
        kind="curves", by="controller", theory="critical_latency"))
    experiment = fesloop.load("finger_control", ["control=pid"])
    exact_ms = critical_latency_ms(experiment, WIRE)
    assert [(overlay.line, overlay.panel) for overlay in overlays] == [("pid", None)]
    assert exact_ms <= overlays[0].x[0] < exact_ms + 0.25


def test_in_a_heat_map_it_is_a_line_along_y_and_says_at_which_levels_others_stand():
    axes = {"latency_ms": {"values": [0, 100]}, "strength": {"values": [0.8, 1.2]},
            "speed": {"values": [1.0, 0.8]}}
    asked = study("finger_control", axes, settings=["control=pid"])
    overlay, = theory_overlays(asked, figure(kind="heat_map", y="strength", theory="critical_latency"))
    assert overlay.label == "critical latency (theory, speed 1)"
    assert list(overlay.y) == [1.2]
    assert theory_overlays(asked, figure(kind="heat_map", y="strength")) == []


def test_no_critical_latency_where_x_is_none_of_one_wire():
    asked = study("linear_loop", {"latency_ms": {"values": [0.0, 0.1], "key": "loss"}})
    with pytest.raises(InputError, match="latency_ms is the latency of 0 wires"):
        theory_overlays(asked, figure(kind="curves", theory="critical_latency"))


AXES = {"latency_ms": {"values": [0, 40]}}


def test_the_exact_cost_of_one_joint_is_that_of_the_joint():
    asked = study("linear_loop", AXES, metrics={"rms_deg": "joints.MCP.joint_rmse_deg"})
    overlay, = theory_overlays(asked, figure(kind="curves", theory="stationary_cost"))
    for latency_ms, rms_deg in zip(overlay.x, overlay.y, strict=True):
        cost = stationary_cost(fesloop.load("linear_loop", [f"latency_ms={latency_ms}"]))
        assert rms_deg == pytest.approx(float(cost.rms_deg[cost.names.index("MCP")]), rel=1e-12)


@pytest.mark.parametrize(("about", "told"), [
    ({"metrics": {"rms_deg": "tracker_rmse_deg"}}, "says nothing of tracker_rmse_deg"),
    ({"metrics": {"rms_deg": "joints.MCP.tracker_rmse_deg"}}, "says nothing of joints.MCP.tracker_rmse_deg"),
    ({"settings": ["blocks.tracker.bias_deg=1"]}, "tracker has a bias"),
    ({"settings": ["blocks.reference.times_s=[5.0, 40.0]",
                   "blocks.reference.angles_deg=[[20, 25, 15], [30, 35, 25]]"]}, "reference moves")])
def test_the_exact_cost_is_drawn_over_nothing_else(about, told):
    asked = study("linear_loop", AXES, **about)
    with pytest.raises(InputError, match=told):
        theory_overlays(asked, figure(kind="curves", theory="stationary_cost"))
