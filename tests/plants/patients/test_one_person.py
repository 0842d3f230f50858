"""One person, the same in every block: hand of each plant, sensors, arrays; nothing of it anywhere else."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import fesloop
from fesloop import InputError
from fesloop.forms.schema import plain
from fesloop.hand.anthropometry import BONES, FINGERS, JOINTED, HandSize
from fesloop.hand.movements import EXTRINSIC
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from plants.electrodes.axons import MOTOR_POINTS
from plants.imus.device import rotations
from plants.patients.files import from_table, load
from plants.patients.sections import CohortSpread, DaySpread

VARIED = CohortSpread(hand_mm=9.8, length=0.03, joint_mm=3.0, axis_deg=7.6, width_mm=4.5, motor_along_mm=8.0,
                      motor_around_deg=6.0, motor_depth_mm=1.5, rest_deg=8.0)
WORN = DaySpread(mounting_deg=7.6, sag_deg=1.0, pose_deg=5.0, ruler_mm=2.0)
EXPERIMENTS = ("array_search_gp", "identify_grasp", "salchow2019")
PLANTS = {"array_search_gp": ("hand",), "identify_grasp": ("hand",), "salchow2019": ("hand",)}


def kind_of_person(folder):
    """File of a patient whose members and days differ in everything."""
    tables = replace(load("able_bodied"), cohort=VARIED, day=WORN).table()
    path = folder / "varied.toml"
    lines = [f"{key} = {json.dumps(value)}" for key, value in tables.items() if not isinstance(value, dict)]
    for key, table in tables.items():
        if isinstance(table, dict):
            lines.append(f"[{key}]")
            lines += [f"{name} = {json.dumps(value)}" for name, value in table.items() if value is not None
                      and not isinstance(value, dict)]
    path.write_text("\n".join(lines))
    return path


def parts_of(name, path, member, day):
    settings = [f"patient.file={path}", "patient.cohort=1", f"patient.member={member}", f"patient.day={day}"]
    return {node.name: node.part for node in fesloop.load(_with_patient(name, path.parent), settings).nodes}


def _with_patient(name, folder):
    """The shipped experiment, without what its file says of hand and mounting."""
    path = folder / f"{name}_person.toml"
    own = ["blocks.hand.hand", "blocks.salchow_b.hand", "blocks.salchow_m1.hand", "blocks.salchow_m2.hand"]
    removed = [*own, "aliases.side", "aliases.hand_mm"] if name == "salchow2019" else []
    path.write_text(f'extends = "{name}"\nremove = {json.dumps(removed)}\n[patient]\nfile = "able_bodied"\n')
    return str(path)


def everywhere_the_same(folder, path, member, day):
    person = load(str(path)).member(cohort=1, number=member).on_day(day)
    tree, unlike = hand_tree(person.hand_size), HandSize(hand_mm=person.anthropometry.hand_mm)
    assert not np.array_equal(tree.geometry, hand_tree(unlike).geometry)
    mounting = {name: rotations(np.radians([turn]))[0] for name, turn in person.sensors.mounting_deg.items()}
    for name in EXPERIMENTS:
        parts = parts_of(name, path, member, day)
        for plant in PLANTS[name]:
            assert np.array_equal(hand_tree(parts[plant].hand).geometry, tree.geometry), (name, plant)
        sensors = parts["imus"]
        assert sensors.mounting_deg == person.sensors.mounting_deg
        assert sensors.soft_tissue.sag_deg == person.sensors.sag_deg
        state = sensors.init(Context("imus", 7))
        for row, site in enumerate(sensors.sites):
            turned = state.sensors.matrices[1, row] @ mounting[site].T
            assert np.abs(turned - np.eye(3)).max() < 0.1, site  # but for scale and axes of the sensor
        if name == "salchow2019":
            assert parts["hand"].pose_error_deg == person.calibration.pose_error_deg
        if "electrodes" in parts:
            assert parts["electrodes"].motor_points == person.electrodes()["motor_points"]
        told = [part for part in parts.values() if not hasattr(part, "advance") and part is not sensors]
        secrets = {repr(value) for table in (person.anatomy.axes_deg, person.anatomy.joints_mm,
                                             person.anatomy.motor_points, person.sensors.mounting_deg)
                   for row in table.values() for value in row}
        secrets |= {repr(value) for value in person.anatomy.lengths.values()}
        secrets |= {repr(value) for value in person.calibration.pose_error_deg.values()}
        for part in told:
            if type(part).__name__ in ("Electrodes", "Stimulator", "Imus"):
                continue
            known = json.dumps(plain(part))
            assert not [secret for secret in secrets if secret in known], type(part).__name__
        if "tracker" in parts:
            assert parts["tracker"].hand == person.measured_hand


@pytest.mark.parametrize("member", range(3))
def test_a_person_is_the_same_everywhere(tmp_path, member):
    everywhere_the_same(tmp_path, kind_of_person(tmp_path), member, 1)


@pytest.mark.slow
def test_a_hundred_persons_are_the_same_everywhere(tmp_path):
    path = kind_of_person(tmp_path)
    for member in range(100):
        everywhere_the_same(tmp_path, path, member, member % 7)


def test_members_differ_by_what_is_stated():
    kind = replace(load("able_bodied"), cohort=VARIED, day=WORN)
    people = [kind.member(cohort=3, number=number).on_day(0) for number in range(300)]
    bones = np.array([[one.anatomy.lengths[bone] for bone in BONES] for one in people])
    assert np.log(bones).std() == pytest.approx(0.03, rel=0.1)
    axes = np.array([[one.anatomy.axes_deg[name] for name in JOINTED] for one in people])
    assert np.sqrt((axes**2).sum(axis=-1).mean()) == pytest.approx(7.6, rel=0.08)
    shifts = np.array([[one.anatomy.joints_mm[name] for name in FINGERS] for one in people])
    assert shifts.std() == pytest.approx(3.0, rel=0.1)
    motor = np.array([[one.anatomy.motor_points[name] for name in EXTRINSIC] for one in people])
    np.testing.assert_allclose(motor.std(axis=(0, 1)), [8.0, 6.0, 1.5], rtol=0.1)
    turns = np.array([[one.sensors.mounting_deg[name] for name in JOINTED[1:]] for one in people])
    assert np.sqrt((turns**2).sum(axis=-1).mean()) == pytest.approx(7.6, rel=0.08)
    # Half of the variance is common to the three sensors of a strip.
    strips = turns.reshape(len(people), 5, 3, 3)
    shared = np.mean([np.corrcoef(strips[..., i, 0].ravel(), strips[..., j, 0].ravel())[0, 1]
                      for i, j in ((0, 1), (1, 2), (0, 2))])
    assert shared == pytest.approx(0.5, abs=0.08)
    known = np.array([one.measured_hand.hand_mm - one.hand_size.hand_mm * one.hand_size.reach
                      / one.anthropometry.size.reach for one in people])
    assert known.std() == pytest.approx(2.0, rel=0.15)


def test_days_change_the_sensors_and_not_the_bones():
    kind = replace(load("able_bodied"), cohort=VARIED, day=WORN).member(cohort=1, number=1)
    monday, tuesday = kind.on_day(1), kind.on_day(2)
    assert monday.hand_size == tuesday.hand_size
    assert monday.anatomy == tuesday.anatomy == kind.anatomy
    assert monday.sensors.mounting_deg != tuesday.sensors.mounting_deg
    assert monday.calibration != tuesday.calibration


def test_without_variation_everyone_is_of_average_proportions():
    kind = load("sci_c6")
    unvaried = {"length", "joint_mm", "axis_deg", "width_mm", "motor_along_mm", "motor_around_deg",
                "motor_depth_mm", "rest_deg"}
    cohort = replace(kind.cohort, **dict.fromkeys(unvaried, 0.0))
    one = replace(kind, cohort=cohort).member(cohort=1, number=2)
    assert {"anatomy", "sensors", "calibration"}.isdisjoint(one.table())
    assert one.measured_hand == one.hand_size
    assert [point.muscle for point in MOTOR_POINTS] == [point.muscle for point
                                                        in one.electrodes()["motor_points"]]


@pytest.mark.parametrize(("tables", "words"), [
    ({"anatomy": {"lengths": {"F2x": 1.0}}}, "patient: anatomy.lengths.F2x: is unknown"),
    ({"anatomy": {"lengths": {"F2p": 3.0}}}, "patient: anatomy.lengths.F2p: 3; allowed: 0.7 to 1.4"),
    ({"anatomy": {"axes_deg": {"F2p": [0.0, 80.0, 0.0]}}}, "axes_deg.F2p: 80 deg; allowed: -30 to 30 deg"),
    ({"anatomy": {"joints_mm": {"F2": [0.0, math.nan, 0.0]}}}, "anatomy.joints_mm.F2[1]: nan"),
    ({"anatomy": {"motor_points": {"THENAR": [0.0, 0.0, 0.0]}}}, "anatomy.motor_points.THENAR: is unknown"),
    ({"sensors": {"mounting_deg": {"palm": [0.0, 0.0, 0.0]}}}, "sensors.mounting_deg.palm: is unknown"),
    ({"calibration": {"pose_error_deg": {"F2_pip": 1.0}}}, "calibration.pose_error_deg.F2_pip: is unknown"),
    ({"calibration": {"hand_error_mm": 90.0}}, "calibration.hand_error_mm: 90 mm; allowed: -20 to 20")])
def test_persons_that_cannot_be_are_one_line_each(tables, words):
    with pytest.raises(InputError) as refused:
        from_table({"name": "odd", **tables})
    assert words in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1
