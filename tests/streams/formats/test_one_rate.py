"""Streams on several clocks come to one time base on request: known signals keep their values."""

import json
from fractions import Fraction

import numpy as np
import pytest
import xdf_files as xdf
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.streams.files import open_recording
from fesloop.streams.motion_file import read_motion_file

QUICK = settings(max_examples=20, deadline=None, phases=[Phase.generate],
                 suppress_health_check=[HealthCheck.function_scoped_fixture])
LABELS = [f"{{0}}_{kind}_{axis}" for kind in ("gyr", "acc") for axis in "xyz"]
UNITS = ["rad/s"] * 3 + ["m/s^2"] * 3
HZ, LEVEL = 1.5, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.81])
PHASE = np.arange(6) * 0.7
START, LASTS_S = 5000.0, 12.0


def signal(times_s):
    """What every sensor measures at instants of the recorder's clock, (n, 6)."""
    return LEVEL + np.sin(2.0 * np.pi * HZ * times_s[:, np.newaxis] + PHASE)


def lab_file(folder, streams, labelled=True):
    """An XDF file of (rate, nominal, begins, drift, offset, gaps) each; and the instants that each has."""
    chunks, instants = [], []
    for number, (rate, nominal, begins_s, drift, offset_s, gaps) in enumerate(streams, 1):
        times = START + begins_s + np.arange(int(LASTS_S * rate)) / rate
        for gap_from, gap_s in gaps:
            times = times[(times < START + gap_from) | (times > START + gap_from + gap_s)]
        instants.append(times)
        sender = (times - offset_s - START) * (1.0 + drift) + 100.0
        labels = [label.format(f"S{number}") for label in LABELS] if labelled else [""] * 6
        chunks.append(xdf.header(number, name=f"imu{number}", labels=labels, units=UNITS, rate=nominal,
                                 form="double64"))
        measured = np.arange(START - 2.0, START + LASTS_S + 4.0, 2.0)
        at_sender = (measured - offset_s - START) * (1.0 + drift) + 100.0
        chunks += [xdf.clock_offset(number, at, there - at)
                   for at, there in zip(at_sender, measured, strict=True)]
        jitter = np.random.default_rng(number).normal(0.0, 2e-5, times.size)
        chunks.append(xdf.samples(number, sender + jitter, signal(times)))
    path = folder / "lab.xdf"
    path.write_bytes(xdf.file_of(*chunks))
    return path, instants


STREAM = st.tuples(st.floats(96.0, 104.0), st.just(100.0), st.floats(0.0, 1.0), st.floats(-1e-4, 1e-4),
                   st.floats(-50.0, 50.0), st.lists(st.tuples(st.floats(2.0, 9.0), st.floats(0.1, 2.0)),
                                                    max_size=2))


def near_a_gap(instants, times, more_s):
    """Instants within gaps of stamps (n,), and those that are within `more_s` of the end of one."""
    within, edge = np.zeros((2, instants.size), dtype=bool)
    for k in np.flatnonzero(np.diff(times) > 1.6 * np.median(np.diff(times))):
        within |= (instants > times[k] + more_s) & (instants < times[k + 1] - more_s)
        edge |= np.any(np.abs(instants - times[k:k + 2, np.newaxis]) <= more_s, axis=0)
    return within, edge


@given(streams=st.lists(STREAM, min_size=2, max_size=3),
       rate=st.sampled_from(["100", "2000/19", "103.5", "150"]))
@QUICK
def test_known_signals_keep_their_values_at_the_common_instants_and_gaps_stay(tmp_path, streams, rate):
    path, instants = lab_file(tmp_path, streams)
    recording = open_recording(path, resample=rate)
    assert recording.sensors == tuple(f"S{number}" for number in range(1, len(streams) + 1))
    start, stop = max(times[0] for times in instants), min(times[-1] for times in instants)
    common = start + recording.stamps_ns * 1e-9
    grid = (recording.stamps_ns * 1e-9) * float(Fraction(rate))
    np.testing.assert_allclose(grid, np.rint(grid), atol=1e-6)
    assert stop - 1.01 / float(Fraction(rate)) <= common[-1] <= stop + 1e-4
    absent = np.ones(recording.samples, dtype=bool)
    for number, ((own, *_), times) in enumerate(zip(streams, instants, strict=True)):
        found = np.concatenate([recording.gyr[:, number], recording.acc[:, number]], axis=1)
        within, edge = near_a_gap(common, times, 2e-4)
        there = np.isfinite(found).all(axis=1)
        assert np.isnan(found[within]).all(), "a value where no sample was"
        assert there[~within & ~edge].all(), "no value between samples"
        absent &= ~there
        # Linear interpolation is off by h^2 / 8 times the second derivative; the rest is what the jitter of
        # the stamps leaves of the clock.
        w = 2.0 * np.pi * HZ
        allowed = (1.02 / own) ** 2 / 8.0 * w ** 2 + 1e-4 * w
        assert np.abs(found[there] - signal(common)[there]).max() < allowed
        assert recording.resampled_hz[f"imu{number + 1}"] == pytest.approx(own, rel=3e-4)
    assert not absent.any(), "an instant at which no stream has a sample"
    whole = round((common[-1] - common[0]) * float(Fraction(rate))) + 1
    lacking = np.all([near_a_gap(start + np.arange(whole) / float(Fraction(rate)), times, 0.0)[0]
                      for times in instants], axis=0)
    assert abs(recording.samples - (whole - lacking.sum())) <= 2 * sum(len(each[5]) for each in streams)


@given(streams=st.lists(STREAM, min_size=2, max_size=2), rate=st.sampled_from([100, 110]))
@settings(QUICK, max_examples=8)
def test_a_layout_brings_streams_to_one_time_base_as_the_option_does(tmp_path, streams, rate):
    streams = [streams[0], (streams[1][0] + 0.01, *streams[1][1:])]
    path, _ = lab_file(tmp_path, streams)
    sensors = "".join(
        f'[sensors.S{number}]\n' + "".join(f'{kind} = {{variable = "imu{number}", columns = {columns}}}\n'
                                           for kind, columns in (("gyr", [1, 2, 3]), ("acc", [4, 5, 6])))
        for number in (1, 2))
    layout = tmp_path / "layout.toml"
    layout.write_text(f'time = "imu1"\nresample = {rate}\n{sensors}')
    by_layout, by_option = open_recording(path, layout=layout), open_recording(path, resample=rate)
    for name in ("stamps_ns", "gyr", "acc"):
        np.testing.assert_array_equal(getattr(by_layout, name), getattr(by_option, name))
    assert by_layout.resampled_hz == by_option.resampled_hz
    layout.write_text(f'time = "imu1"\n{sensors}')
    with pytest.raises(InputError, match=r"write `resample = 1?[0-9]{2}` into the layout"):
        open_recording(path, layout=layout)


TWO = [(99.7, 100.0, 0.2, 2e-5, 3.0, [(4.0, 1.0)]), (100.2, 100.0, 0.0, -3e-5, -7.0, [(4.5, 1.0)])]


def test_the_refusal_names_the_option_and_the_option_works_as_named(tmp_path, capsys):
    path, _ = lab_file(tmp_path, TWO)
    target = tmp_path / "motion.h5"
    assert main(["import", str(path), str(target)]) == 2
    said = capsys.readouterr().err
    assert "`--resample 100`" in said
    assert main(["import", str(path), str(target), "--resample", "100", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["resampled_hz"] == {"imu1": pytest.approx(99.7, rel=1e-4),
                                    "imu2": pytest.approx(100.2, rel=1e-4)}
    assert read_motion_file(target).resampled_hz == told["resampled_hz"]
    assert len(told["gaps"]) == 1, "where both have none"
    assert told["gaps"][0]["to_s"] - told["gaps"][0]["from_s"] == pytest.approx(0.5, abs=0.03)
    assert all(45 <= lost <= 55 for lost in told["lost_samples"].values()), "where one of them has none"
    assert main(["import", str(path), str(tmp_path / "again.h5"), "--resample", "100"]) == 0
    assert "brought to common instants by straight lines" in capsys.readouterr().out


def test_a_lost_sample_is_not_filled_and_a_sample_of_its_own_instant_is_kept(tmp_path):
    times = START + np.arange(300) / 100.0
    values = signal(times)
    values[100] = np.nan
    chunks = [chunk for number in (1, 2) for chunk in (
        xdf.header(number, name=f"imu{number}", labels=[label.format(f"S{number}") for label in LABELS],
                   units=UNITS, rate=0.0, form="double64"),
        xdf.samples(number, times + 0.004 * (number - 1), values))]
    path = tmp_path / "lab.xdf"
    path.write_bytes(xdf.file_of(*chunks))
    recording = open_recording(path, resample=100)
    assert np.isnan(recording.gyr[:, 1]).all(axis=1).nonzero()[0].tolist() == [100]
    assert np.isnan(recording.gyr[:, 0]).all(axis=1).nonzero()[0].tolist() == [99, 100]
    np.testing.assert_array_equal(recording.gyr[:, 1][recording.stamps_ns == 0], values[:1, :3])


@pytest.mark.parametrize(("streams", "rate", "words"), [
    (TWO, "50", ("90.18 to 200.4 Hz", "100 fits")),
    (TWO, "1000", ("90.18 to 200.4 Hz",)),
    (TWO, "fast", ("resample", "'fast'")),
    (TWO, "0", ("resample",)),
    ([TWO[0], (100.2, 100.0, 30.0, 0.0, 0.0, [])], "100", ("not recorded at the same time", "sensor_set")),
])
def test_what_cannot_be_brought_to_one_rate_is_refused_with_what_can(tmp_path, streams, rate, words):
    path, _ = lab_file(tmp_path, streams)
    with pytest.raises(InputError) as refused:
        open_recording(path, resample=rate)
    assert all(word in str(refused.value) for word in words), str(refused.value)


def test_a_rate_that_changes_is_refused(tmp_path):
    times = START + np.concatenate([np.arange(500) / 100.0, 5.0 + np.arange(500) / 80.0])
    chunks = [chunk for number in (1, 2) for chunk in (
        xdf.header(number, name=f"imu{number}", labels=[label.format(f"S{number}") for label in LABELS],
                   units=UNITS, rate=0.0, form="double64"), xdf.samples(number, times, signal(times)))]
    (tmp_path / "lab.xdf").write_bytes(xdf.file_of(*chunks))
    with pytest.raises(InputError, match="rate changes from 100 Hz to 80 Hz"):
        open_recording(tmp_path / "lab.xdf", resample=100)


def test_files_of_one_time_base_have_nothing_to_resample(tmp_path):
    np.savetxt(tmp_path / "lab.csv", np.tile(LEVEL, (50, 1)), delimiter=",", header="a,b,c,d,e,f",
               comments="")
    layout = '[sensors.S]\ngyr = ["a", "b", "c"]\nacc = ["d", "e", "f"]\n'
    (tmp_path / "layout.toml").write_text(f"rate = 100\nresample = 100\n{layout}")
    with pytest.raises(InputError, match=r"layout.toml: resample: .*one rate, which the layout states"):
        open_recording(tmp_path / "lab.csv", layout=tmp_path / "layout.toml")
    (tmp_path / "layout.toml").write_text(f"rate = 100\n{layout}")
    with pytest.raises(InputError, match="write `resample = 100` into the layout"):
        open_recording(tmp_path / "lab.csv", layout=tmp_path / "layout.toml", resample=100)
    assert main(["import", str(tmp_path / "lab.csv"), str(tmp_path / "m.h5"), "--layout",
                 str(tmp_path / "layout.toml")]) == 0
    with pytest.raises(InputError, match="one time base"):
        open_recording(tmp_path / "m.h5", resample=100)
