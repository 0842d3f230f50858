"""Published recordings: torque, scatter and size are those that their own arrays and baselines have."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.streams.stimulation import open_stimulation

PEOPLE = ("S9002", "S9003", "S9004", "S9006", "S9007")


@pytest.mark.parametrize("person", PEOPLE)
def test_evoked_torque_is_that_of_the_published_arrays(recordings, person):
    path = recordings / "fes_exo" / f"{person}.npz"
    found, arrays = open_stimulation(path), np.load(path)
    np.testing.assert_allclose(found.steady.evoked_nm, arrays["steady_evoked_nm"], rtol=0.0, atol=3e-7)
    np.testing.assert_array_equal(found.steady.muscle + 1, arrays["steady_muscle"])
    np.testing.assert_array_equal(found.steady.posture, arrays["steady_posture"])
    np.testing.assert_allclose(1e6 * found.steady.pulse_width_s, arrays["steady_pulse_width_us"], rtol=1e-12)
    ended = np.isfinite(found.steady.trace_nm[..., 0]).sum(axis=1)
    np.testing.assert_array_equal(ended, (arrays["steady_trace_exo_mnm"][..., 0] > -32768).sum(axis=1))


@pytest.mark.parametrize("person", PEOPLE)
def test_scatter_and_size_are_those_of_the_baselines(recordings, peers, person):
    published = json.loads((peers / "people" / "baselines_developers.json").read_text())["repeatability"]
    expected = published[f"{person} steady_evoked_nm"]
    found = open_stimulation(recordings / "fes_exo" / f"{person}.npz").steady.repeatability()
    np.testing.assert_allclose(found.sd_nm, expected["sd"], rtol=1e-5)
    np.testing.assert_allclose(found.rms_nm, expected["rms"], rtol=1e-4)


@pytest.mark.parametrize("person", PEOPLE)
def test_torque_relative_to_the_passive_trial_is_that_of_the_published_arrays(recordings, person):
    path = recordings / "fes_exo" / f"{person}.npz"
    found, expected = open_stimulation(path).steady, np.load(path)["steady_evoked_passive_nm"]
    np.testing.assert_allclose(replace(found, baseline="passive").evoked_nm, expected, rtol=0.0, atol=3e-7)


def test_courses_and_movements_have_their_rows(recordings):
    path = recordings / "fes_exo" / "S9004.npz"
    found, arrays = open_stimulation(path), np.load(path)
    ramp, movement = found.courses[1], found.movements[3]
    assert found.muscles[ramp.muscle] == "flexor carpi radialis"
    assert (ramp.current_a, ramp.period_s) == (0.045, 0.005)
    assert len(ramp.time_s) == 7600
    at = 4321
    for values, key in ((1e3 * ramp.device_torque_nm, "ramp_exo_torque_mnm"),
                        (np.degrees(100.0 * ramp.angle_rad), "ramp_angle_cdeg")):
        np.testing.assert_allclose(values[at], arrays[key][1, at], atol=1e-9)
    row = arrays["loop_first"][3] + 55
    np.testing.assert_allclose(1e3 * movement.planned_nm[55], arrays["loop_planned_fes_torque_mnm"][row])
    np.testing.assert_allclose(1e6 * movement.pulse_width_s[55], arrays["loop_pulse_width_us"][row])
    assert movement.settings["fes_share"] == pytest.approx(0.5)
    assert len(found.movements) == 40


def test_a_short_pilot_ends_where_it_was_broken_off(recordings):
    found = open_stimulation(recordings / "fes_exo" / "S9001.npz")
    assert found.steady is None
    assert len(found.courses[0].time_s) * found.courses[0].period_s == pytest.approx(8.73, abs=0.01)


def test_forces_of_rats_begin_after_their_first_pulse(recordings):
    found = open_stimulation(recordings / "rat_gm" / "GMe1.npz")
    kinds = [course.kind for course in found.forces]
    assert [kinds.count(kind) for kind in ("ISOM", "QR", "SR", "SSC")] == [12, 11, 11, 54]
    course = found.forces[3]
    np.testing.assert_allclose(np.diff(course.pulses_s), 0.01, atol=2 * course.period_s)
    before = course.time_s < course.pulses_s[0] + 0.005
    peak = np.nanmax(course.force_n)
    assert peak > 5.0
    assert course.force_n[before].max() < course.force_n[before].mean() + 0.02 * peak
    assert 0.03 < course.length_m.mean() < 0.05


def test_trains_of_a_biceps_have_thirty_pulses(recordings):
    found = open_stimulation(recordings / "biceps_force" / "biceps_force.npz")
    pulses = [course.pulses_s.size for course in found.forces]
    assert pulses == [29 if n in (0, 9) else 30 for n in range(20)]
    assert sum(pulses) == 598
    assert found.forces[1].start_s == pytest.approx(7.1867)


def _archive(**changed):
    whole = {"rat": np.array("GMx"), "kind": np.array(["QR"]), "name": np.array(["QR1"]),
             "first": np.array([0]), "count": np.array([4]), "step_s": np.array(5e-4),
             "length_um": np.full(4, 40000), "force_mn": np.arange(4), "pulse": np.array([0, 1, 1, 0])}
    return {key: value for key, value in {**whole, **changed}.items() if value is not None}


def test_a_small_archive_is_read_by_its_keys(tmp_path):
    np.savez(tmp_path / "rat.npz", **_archive())
    course = open_stimulation(tmp_path / "rat.npz").forces[0]
    np.testing.assert_allclose(course.force_n, [0.0, 1e-3, 2e-3, 3e-3])
    np.testing.assert_allclose(course.pulses_s, [5e-4])


@pytest.mark.parametrize(("changed", "fault"), [
    ({"force_mn": np.arange(3)}, "has 4 samples, others have 3"),
    ({"step_s": None}, "is no whole archive of rat_gm (KeyError: 'step_s')"),
    ({"name": np.array(["QR1", "QR2"])}, "is no whole archive of rat_gm"),
    ({"step_s": np.array(0.0)}, "period_s: 0.0"),
    ({"name": np.array(["QR\ud800"])}, "name: 'QR\\ud800' is no UTF-8 text"),
    ({"rat": None}, "is no archive of a known set, it holds kind, name"),
])
def test_archives_with_faults_are_refused_in_one_line(tmp_path, changed, fault):
    np.savez(tmp_path / "rat.npz", **_archive(**changed))
    with pytest.raises(InputError) as caught:
        open_stimulation(tmp_path / "rat.npz")
    assert fault in str(caught.value)
    assert "\n" not in str(caught.value)
