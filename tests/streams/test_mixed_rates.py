"""Several rates in the rows of one file: refused by name, or held as a layout says; losses stay losses."""

import re

import bids_files
import numpy as np
import pytest
import xdf_files as xdf
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.streams.files import open_recording

LABELS = xdf.MOTION_LABELS
COLUMNS = {"gyr": slice(0, 3), "acc": slice(3, 6), "mag": slice(6, 9)}
LAYOUT = ('rate = 100\n[units]\ngyr = "deg/s"\nacc = "g"\nmag = "uT"\n[sensors.imu]\n'
          + "".join(f"{kind} = [{s.start + 1}, {s.start + 2}, {s.stop}]\n" for kind, s in COLUMNS.items()))


def filled_rows(count, numerator, denominator, offset=0):
    """Rows (count,) that a rate of numerator / denominator of the table's fills."""
    number = np.arange(count) + offset
    return number * numerator // denominator != (number - 1) * numerator // denominator


def as_table(folder, rows, every=""):
    layout = folder / "layout.toml"
    layout.write_text(every + LAYOUT)
    (folder / "lab.csv").write_text("\n".join([",".join(LABELS), *(
        ",".join("" if np.isnan(cell) else f"{cell:.9g}" for cell in row) for row in rows)]))
    return open_recording(folder / "lab.csv", layout=layout)


def as_xdf(folder, rows):
    path = folder / "lab.xdf"
    path.write_bytes(xdf.file_of(
        xdf.header(1, labels=LABELS, units=xdf.MOTION_UNITS), xdf.samples(
            1, 5.0 + 0.01 * np.arange(len(rows)), rows.astype("<f4"))))
    return open_recording(path)


def as_bids(folder, rows):
    types = {"gyr": "GYRO", "acc": "ACCEL", "mag": "MAGN"}
    channels = [(label, label[-1], types[label[:3]], "hand", unit)
                for label, unit in zip(LABELS, xdf.MOTION_UNITS, strict=True)]
    return open_recording(bids_files.write_system(folder, "imu", channels, list(rows.T), 100.0))


FORMS = (as_table, as_xdf, as_bids)


@given(form=st.sampled_from(FORMS), kinds=st.sets(st.sampled_from(sorted(COLUMNS)), min_size=1, max_size=2),
       ratio=st.tuples(st.integers(1, 9), st.integers(2, 12)), offset=st.integers(0, 11),
       others_fill_the_rest=st.booleans())
@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_kinds_of_another_rate_than_the_rows_are_refused_by_name(tmp_path, form, kinds, ratio, offset,
                                                                 others_fill_the_rest):
    assume(ratio[0] < ratio[1])
    there = filled_rows(400, *ratio, offset)
    rows = xdf.motion(400)[1].astype(float)
    for kind, columns in COLUMNS.items():
        if kind in kinds:
            rows[~there, columns] = np.nan
        elif others_fill_the_rest:
            rows[there, columns] = np.nan  # as of two tables that were joined by their instants
    if others_fill_the_rest:
        kinds = set(COLUMNS)
    with pytest.raises(InputError, match="it has a rate of its own") as caught:
        form(tmp_path, rows)
    assert re.search(": (imu|hand): (gyr|acc|mag): ", str(caught.value))[2] in kinds
    assert "\n" not in str(caught.value)


@given(form=st.sampled_from(FORMS), lost=st.floats(0.0, 0.8), burst=st.integers(1, 30),
       seed=st.integers(0, 99), alone=st.floats(0.0, 0.1))
@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_samples_that_a_sensor_loses_at_random_are_lost_samples(tmp_path, form, lost, burst, seed, alone):
    """All its kinds in bursts, and now and then one kind alone."""
    rng = np.random.default_rng(seed)
    rows = xdf.motion(400)[1].astype(float)
    starts = rng.random(400) < lost / burst
    gone = np.convolve(starts, np.ones(burst))[:400] > 0.0
    gone[5] = False
    rows[gone] = np.nan
    rows[(rng.random(400) < alone) & (np.arange(400) != 5), 6:] = np.nan
    recording = form(tmp_path, rows)
    np.testing.assert_array_equal(np.isnan(recording.gyr[:, 0]), np.isnan(rows[:, :3]))
    np.testing.assert_array_equal(np.isnan(recording.mag[:, 0]), np.isnan(rows[:, 6:]))


@pytest.mark.slow
@given(acc=st.integers(1, 6), mag=st.integers(1, 20), seed=st.integers(0, 9),
       offsets=st.tuples(st.integers(0, 5), st.integers(0, 19)))
@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_layout_that_says_how_often_holds_values_until_the_next_alone(tmp_path, acc, mag, offsets, seed):
    rows, rng = xdf.motion(400)[1].astype(float), np.random.default_rng(seed)
    whole = rows.copy()
    lost = rng.random(400) < 0.02
    lost[:60] = False
    for every, offset, kind in ((acc, offsets[0], "acc"), (mag, offsets[1], "mag")):
        rows[(np.arange(400) - offset) % every != 0, COLUMNS[kind]] = np.nan
    rows[lost] = np.nan
    found = as_table(tmp_path, rows, f"every = {{acc = {acc}, mag = {mag}}}\n")
    for every, offset, kind in ((acc, offsets[0], "acc"), (mag, offsets[1], "mag")):
        scale = {"acc": 9.80665, "mag": 1e-6}[kind]
        for row in range(400):
            source = row - (row - offset) % every
            is_lost = source < 0 or lost[source]
            got = getattr(found, kind)[row, 0]
            assert np.isnan(got).all() == is_lost
            if not is_lost:
                np.testing.assert_allclose(got, whole[source, COLUMNS[kind]] * scale, rtol=1e-8)


def test_what_a_layout_says_wrongly_is_still_refused(tmp_path):
    rows = xdf.motion(400)[1].astype(float)
    rows[np.arange(400) % 3 != 0, 3:6] = np.nan
    for every, words in (("", r"usually every 3rd.*every = \{acc = 3\}"), ("every = {acc = 2}\n", "own"),
                         ("every = {acc = 0}\n", "every.acc: 0; allowed: 1 to 1000"),
                         ("every = {gyro = 2}\n", "gyro")):
        with pytest.raises(InputError, match=words):
            as_table(tmp_path, rows, every)
    as_table(tmp_path, rows, "every = {acc = 3}\n")


def test_a_slower_sensor_leaves_the_losses_of_others_lost(tmp_path):
    """Stated for all, a lost row of the quick sensor was filled with the row before."""
    rng, lost = np.random.default_rng(1), np.zeros(400, bool)
    lost[rng.choice(np.arange(1, 400), 30, replace=False)] = True
    rows = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 9.81], (400, 2)) + 0.1 * rng.random((400, 12))
    rows[np.ix_(np.arange(400) % 2 == 1, range(6, 12))] = np.nan
    rows[lost, :6] = np.nan
    np.savetxt(tmp_path / "two.csv", rows, delimiter=",")
    quick, slow = ("[sensors.quick]\ngyr = [1, 2, 3]\nacc = [4, 5, 6]\n",
                   "[sensors.slow]\ngyr = [7, 8, 9]\nacc = [10, 11, 12]\n")
    own = "every = {gyr = 2, acc = 2}\n"

    def imported(text):
        (tmp_path / "two.toml").write_text("rate = 100\n" + text)
        return open_recording(tmp_path / "two.csv", layout=tmp_path / "two.toml")

    head = "[text]\nheader = 0\n"
    with pytest.raises(InputError, match=r"slow: gyr.*`sensors\.slow\.every = \{gyr = 2\}`"):
        imported(head + quick + slow)
    found = imported(head + quick + slow + own)
    np.testing.assert_array_equal(np.isnan(found.gyr[:, 0]).any(axis=1), lost)
    np.testing.assert_array_equal(found.gyr[1::2, 1], found.gyr[::2, 1])
    assert np.isnan(imported(own + head + quick + slow).gyr[:, 0]).any(axis=1).sum() < lost.sum()


@pytest.mark.parametrize("tracker", ["vqf", "vqf9", "seel_ruppin"])
@pytest.mark.parametrize(("acc", "mag"), [(2, 1), (4, 8)])
def test_angles_of_a_table_of_several_rates_are_the_true_ones(tmp_path, tracker, acc, mag):
    """Bent to 60 deg and kept there: what empties for lost samples made 49 deg of."""
    times = np.arange(1200) / 100.0
    angle = np.radians(60.0) * np.clip((times - 2.0) / 2.0, 0.0, 1.0)
    turn, zero, g = np.gradient(angle, 0.01), np.zeros_like(times), 9.80665
    field = (0.0, 20e-6, -40e-6)  # the hinge's axis z points north, so that both sensors' x is up at first
    sensors = []
    for bent, rate in ((zero, zero), (angle, turn)):
        c, s = np.cos(bent), np.sin(bent)
        gyr, force = np.column_stack([zero, zero, rate]), np.column_stack([g * s, g * c, zero])
        mag_field = np.column_stack([field[2] * s, field[2] * c, field[1] + zero])
        sensors += [gyr, force, mag_field]
    rows = np.hstack(sensors) + 1e-9
    rng = np.random.default_rng(3)
    rows += rng.standard_normal(rows.shape) * np.tile(np.repeat([1e-3, 1e-2, 1e-8], 3), 2)
    number = np.arange(1200)
    for sensor in (0, 9):
        rows[number % acc != 0, sensor + 3:sensor + 6] = np.nan
        rows[number % mag != 0, sensor + 6:sensor + 9] = np.nan
    text = f"rate = 100\npairs = [['a', 'b']]\nevery = {{acc = {acc}, mag = {mag}}}\n[text]\nheader = 0\n"
    for name, first in (("a", 1), ("b", 10)):
        text += f"[sensors.{name}]\n" + "".join(
            f"{kind} = {list(range(first + at, first + at + 3))}\n"
            for kind, at in (("gyr", 0), ("acc", 3), ("mag", 6)))
    (tmp_path / "layout.toml").write_text(text)
    np.savetxt(tmp_path / "lab.csv", rows, delimiter=",")
    result = load("replay", [f"recording={tmp_path / 'lab.csv'}", f"tracker={tracker}",
                             f"blocks.recording.layout={tmp_path / 'layout.toml'}"]).run(tmp_path / "runs")
    with Recording(result.recording) as run:
        seen = np.degrees(run.signal("tracker.angles").values[:, 0])
        told = {event.status for event in run.events}
    assert abs(np.median(seen[-200:]) - 60.0) < 1.5
    assert not told & {"recording_incomplete", "lost_sample", "frozen_sample"}
    assert sum(np.abs(seen - np.degrees(angle)) > 4.0) < 60
