"""Rats' muscles and a biceps in `fesloop reproduce people`: bars on recordings, formulas on made-up ones."""

import numpy as np
import pytest

from fesloop.analysis.muscle_fit import MuscleTrial
from fesloop.apps.reproduce import people
from fesloop.apps.reproduce.figures import draw
from fesloop.apps.reproduce.people import muscle, trains
from fesloop.apps.reproduce.people.trains import Shape
from fesloop.apps.reproduce.result import Reproduction
from fesloop.streams.stimulation import ForceCourse

HZ = 31.25


def train(shape=None, force=None, pulses=30, scale=20.0, samples=1200):
    """A train's course: that of a shape, or of a force."""
    course = ForceCourse(
        name="train", kind="train", muscle=0, start_s=0.0, period_s=1e-3, force_n=np.zeros(samples),
        length_m=np.full(samples, np.nan), pulses_s=np.arange(pulses) / HZ)
    made = scale * trains.active_course(shape, course, HZ) if shape is not None else force
    return ForceCourse(**{name: getattr(course, name) for name in ForceCourse.__slots__} | {"force_n": made})


def test_rise_and_decay_of_a_first_order_lag_are_its_closed_forms():
    times, tau, last = 1e-3 * np.arange(4000), 0.05, 1.0
    force = np.where(times < last, -np.expm1(-times / tau),
                     -np.expm1(-last / tau) * np.exp(-(times - last) / tau))
    rise, decay = trains.rise_and_decay(force, last, 1e-3)
    assert rise == pytest.approx(1e3 * tau * np.log(9.0), abs=0.5)
    assert decay == pytest.approx(1e3 * tau * np.log(2.0), abs=0.5)
    left = np.exp(-0.1 / tau)
    _, decay = trains.rise_and_decay(force[:1101], last, 1e-3)
    assert decay == pytest.approx(-1e3 * tau * np.log(0.5 * (1.0 + left)), abs=0.5)


def test_the_shape_of_trains_is_found_whatever_their_scales():
    courses = [train(Shape(120.0, 0.6), scale=scale, pulses=pulses)
               for scale, pulses in ((5.0, 30), (30.0, 29), (12.0, 20))]
    found = trains.fit_shape(courses, HZ)
    assert found.calcium_ms == pytest.approx(120.0, rel=1e-3)
    assert found.half == pytest.approx(0.6, rel=1e-3)


def test_active_state_is_that_of_the_muscle():
    """The closed form is that of `HillMuscle` at its optimal length with a tendon that hardly yields."""
    from fesloop.models.hill_muscle import HillMuscle

    rigid = HillMuscle(force_n=1.0, fibre_mm=50.0, slack_mm=100.0, strain=1e-3, passive=0.0, fastest=1e4,
                       calcium_ms=90.0, half=0.5)
    drive = (np.arange(1200) < 30 * 32).astype(float)
    force = rigid.force(np.full(1200, 0.1501), drive, 1e-3)
    np.testing.assert_allclose(trains.active_course(Shape(90.0, 0.5), train(Shape(90.0, 0.5)), HZ), force,
                               atol=0.01)


def test_peaks_that_fall_by_a_share_are_foreseen():
    peak = 30.0 * 0.98 ** np.arange(20)
    found = trains.peaks([train(force=each * np.ones(10)) for each in peak])
    ((_, (exponential, mean, fall)),) = found.rows
    assert exponential == pytest.approx(0.0, abs=1e-9)
    assert mean > 5.0
    assert fall == pytest.approx(-100.0 * np.log(0.98))


def test_rise_and_decay_of_trains_not_fitted_are_within_the_bar(recordings, tmp_path):
    rows, _, curves = trains.part(recordings / "biceps_force", 1)
    assert [row.holds for row in rows] == [True, True]
    written = draw(Reproduction("people", 1, rows, curves=dict(curves)), tmp_path)
    assert [path.name for path in written] == ["biceps.png"]


def test_absent_recordings_are_rows_that_do_not_hold(recordings, monkeypatch, tmp_path):
    (tmp_path / "biceps_force").symlink_to(recordings / "biceps_force")
    monkeypatch.setenv("FESLOOP_RECORDINGS", str(tmp_path))
    rows = people.run(10).rows
    assert [(row.table, row.holds) for row in rows if str(row.ours).startswith("absent")] == [
        ("fes_exo", False), ("rat_gm", False)]


def test_a_rat_without_cycles_is_a_row_that_does_not_hold(monkeypatch, tmp_path):
    trial = MuscleTrial("ISOM01", "ISOM", np.zeros(3), np.zeros(3), np.zeros(3))
    monkeypatch.setattr(muscle, "rats", lambda folder: {"GMe9": [trial]})
    ((row,), sweeps, curves) = muscle.part(tmp_path, 1)
    assert (row.row, row.ours, row.holds) == ("GMe9", "none of QR, SR, SSC", False)
    assert not curves["rats"]
    assert sweeps["rat_errors"].rows == ()


@pytest.mark.slow
def test_stretch_shortening_of_every_rat_is_predicted_within_the_bar(recordings, tmp_path):
    rows, sweeps, curves = muscle.part(recordings / "rat_gm", 1)
    assert len(rows) == len(curves["rats"]) == len(sweeps["rat_errors"].rows)
    assert all(row.holds for row in rows)
    for name, values in sweeps["rat_parameters"].rows:
        assert np.isfinite(values).all(), name
    draw(Reproduction("people", 1, rows, curves=dict(curves)), tmp_path)
    assert (tmp_path / "rats.png").is_file()
