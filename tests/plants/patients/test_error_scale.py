"""`error_scale`: more or less wrong knowledge of the same person, whose hand and nerves do not change."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fesloop
from fesloop import InputError
from fesloop.experiment.files.patients import describe, drawn_patient, patient_fingerprint
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from plants.patients.files import from_table, load

WHO = ["patient=sci_c6", "cohort=3", "member=4", "day=1"]
CHOICE = {"file": "sci_c6", "cohort": 3, "member": 4, "day": 1}


def person(number=4, scale=1.0):
    return load("sci_c6").member(cohort=3, number=number).on_day(1).with_error_scale(scale)


def parts(*more):
    return {node.name: node.part for node in fesloop.load("grasp_mpc", [
        "any_patient=true", *WHO, *more]).nodes}


def blocks(*more):
    return fesloop.load("grasp_mpc", ["any_patient=true", *WHO, *more]).document()["blocks"]


def measures(size):
    tilts = np.array([size.axes_deg.get(name, (0.0, 0.0, 0.0)) for name in hand_tree(size).names
                      if name != "F1m"])
    shifts = np.zeros((5, 3)) if size.joints_mm is None else np.array(size.joints_mm)
    return [size.hand_mm, size.forearm, size.segments, size.first_joints, size.tips, shifts, tilts]


def distances(hand, told):
    return [each - exact for exact, each in zip(measures(hand), measures(told), strict=True)]


def test_a_scale_of_one_is_the_person_to_the_bit():
    assert blocks() == blocks("error_scale=1.0")


def test_the_hand_and_its_nerves_do_not_change_and_the_tracker_is_told_more_or_less_of_it():
    tables, usual, exact, far = blocks(), parts(), parts("error_scale=0.0"), parts("error_scale=4.0")
    for scaled in (blocks("error_scale=0.0"), blocks("error_scale=4.0")):
        assert {name for name in tables if tables[name] != scaled[name]} == {"hand", "imus", "tracker"}
        assert tables["hand"]["hand"] == scaled["hand"]["hand"]
    truth = usual["hand"].hand
    assert all(np.allclose(error, 0.0, atol=1e-9) for error in distances(truth, exact["tracker"].hand))
    assert all(error == 0.0 for error in exact["hand"].assist.error_deg.values())
    held, farther = usual["hand"].assist.error_deg, far["hand"].assist.error_deg
    assert held
    assert all(farther[name] == 4.0 * error for name, error in held.items())


@settings(deadline=None, max_examples=10)
@given(st.floats(0.0, 2.0), st.integers(0, 50))
def test_ignorance_of_the_hand_grows_in_proportion(scale, number):
    one = person(number)
    told = person(number, scale).measured_hand
    assert person(number, scale).hand_size == one.hand_size
    for small, large in zip(distances(one.hand_size, one.measured_hand), distances(one.hand_size, told),
                            strict=True):
        assert np.allclose(large, scale * small, atol=1e-9)


def test_sensors_without_error_read_what_happens_and_others_err_in_proportion():
    def constants(scale):
        state = parts(f"error_scale={scale}")["imus"].init(Context(seed=3, name="imus"))
        sensors = state.sensors
        return sensors.matrices[:2], sensors.constants[:2], sensors.errors.noise_sd[:2], sensors.tissue

    exact, once, twice = constants(0.0), constants(1.0), constants(2.0)
    assert np.allclose(exact[0], np.eye(3), atol=1e-15)
    assert not exact[1].any()
    assert not exact[2].any()
    assert exact[3].natural_rad_s == 0.0
    assert np.allclose(twice[1], 2.0 * once[1])
    assert np.allclose(twice[2], 2.0 * once[2])
    assert twice[3].sag == pytest.approx(2.0 * once[3].sag)
    # Skew parts are axis times sine of the angle: of mountings of some degrees, and of crooked triads.
    skew = [each[0][0] - np.swapaxes(each[0][0], -1, -2) for each in (once, twice)]
    assert np.allclose(skew[1], 2.0 * skew[0], atol=0.1)
    assert np.abs(skew[0]).max() > 0.2


def test_it_is_no_other_patient_and_a_recording_keeps_it():
    scaled = {**CHOICE, "error_scale": 2.0}
    assert patient_fingerprint(scaled) == patient_fingerprint(CHOICE)
    assert describe(scaled) == "sci_c6, member 4 of cohort 3, day 1, errors x 2"
    assert from_table(person(scale=2.0).table(), "again") == drawn_patient(scaled)


@pytest.mark.parametrize("tracker", ["constrained", "salchow_m2", "salchow_m1", "salchow_b", "kortier"])
def test_every_tracker_takes_the_hand_that_it_is_told(tracker):
    for scale in (0.0, 4.0):
        told = parts(f"tracker={tracker}", f"error_scale={scale}")["tracker"].hand
        assert told == person(scale=scale).measured_hand


@pytest.mark.parametrize("wrong", ["-0.1", "4.1"])
def test_other_scales_are_refused(wrong):
    with pytest.raises(InputError, match=r"patient: calibration\.error_scale.*0 to 4"):
        fesloop.load("grasp_mpc", ["any_patient=true", *WHO, f"error_scale={wrong}"])
