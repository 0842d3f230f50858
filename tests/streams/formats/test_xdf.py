"""XDF: samples and instants are pyxdf's, units come out in SI, and what is damaged is refused at its byte."""

import logging
import struct

import numpy as np
import pytest
import pyxdf
import xdf_files as xdf
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.loop.block import Tick
from fesloop.streams.blocks.replay import Replay
from fesloop.streams.files import open_recording
from fesloop.streams.formats.xdf import instants_s, read_streams
from fesloop.streams.pace import gaps_of, on_lines, pace_of, set_back

LABELS, UNITS = xdf.MOTION_LABELS, xdf.MOTION_UNITS


def written(tmp_path, content):
    path = tmp_path / "lab.xdf"
    path.write_bytes(content)
    return path


def refused(path, *words, sensor_set=None):
    with pytest.raises(InputError) as caught:
        open_recording(path, sensor_set)
    text = str(caught.value)
    assert "\n" not in text
    for word in words:
        assert word in text, text
    return text


def test_samples_and_instants_are_those_of_pyxdf(tmp_path):
    path = written(tmp_path, xdf.motion_file())
    (theirs,), _ = pyxdf.load_xdf(path)
    (ours,) = read_streams(path)
    np.testing.assert_array_equal(ours.values, theirs["time_series"])
    np.testing.assert_allclose(instants_s(ours, ""), theirs["time_stamps"], rtol=0, atol=1e-9)
    (raw,), _ = pyxdf.load_xdf(path, synchronize_clocks=False, dejitter_timestamps=False)
    np.testing.assert_array_equal(ours.stamps_s, raw["time_stamps"])
    recording = open_recording(path)
    scale = np.repeat([np.pi / 180.0, 9.80665, 1e-6], 3)
    expected = theirs["time_series"].astype(float) * scale
    assert recording.sensors == ("imu",)
    for samples, columns in ((recording.gyr, slice(0, 3)), (recording.acc, slice(3, 6)),
                             (recording.mag, slice(6, 9))):
        np.testing.assert_array_equal(samples[:, 0], expected[:, columns])
    np.testing.assert_allclose(recording.stamps_ns * 1e-9, theirs["time_stamps"] - theirs["time_stamps"][0],
                               atol=1e-6)
    assert recording.source_units == {"gyr": "deg/s", "acc": "g", "mag": "uT"}
    assert float(recording.rate) == pytest.approx(theirs["info"]["effective_srate"], rel=1e-6)


@pytest.mark.slow
@given(offsets=st.lists(st.tuples(st.floats(0.5, 8.0), st.floats(-2e-3, 2e-3)), min_size=1, max_size=12),
       gap=st.sampled_from([0.0, 0.3, 3.0, 7.0]), rate=st.sampled_from([0.0, 100.0]), drops=st.booleans(),
       seed=st.integers(0, 5))
@example(offsets=[(step, -0.0018041563678062964) for step in (1.0, 1.0, 2.0)], gap=0.0,
         rate=0.0, drops=False, seed=0)  # what is left beside the line falls towards nothing
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_clocks_breaks_and_irregular_streams_are_as_in_pyxdf(tmp_path, offsets, gap, rate, drops, seed):
    times, values = xdf.motion(150, seed)
    times[80:] += gap
    extra = "<synchronization><can_drop_samples>true</can_drop_samples></synchronization>" if drops else ""
    clock = np.cumsum([step for step, _ in offsets]) + 990.0
    path = written(tmp_path, xdf.file_of(
        xdf.header(1, labels=LABELS, units=UNITS, rate=rate, extra=extra),
        *(xdf.clock_offset(1, time, 3.0 + offset) for time, (_, offset) in zip(clock, offsets, strict=True)),
        xdf.samples(1, times, values)))
    logging.disable()
    (theirs,), _ = pyxdf.load_xdf(path, jitter_break_threshold_seconds=0.2, jitter_break_threshold_samples=5)
    logging.disable(logging.NOTSET)
    (ours,) = read_streams(path)
    # pyxdf fits each stretch a period of its own, from jitter of 0.1 ms; without a gap both are the same.
    apart = 2e-4 if gap and rate and not drops else 1e-7
    np.testing.assert_allclose(instants_s(ours, ""), theirs["time_stamps"], rtol=0, atol=apart)


@pytest.mark.slow
@given(data=st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_gaps_stay_where_they_are_whatever_their_length_rate_and_jitter(tmp_path, data):
    """Against the true instants, and pyxdf that is told where to break its lines."""
    rate = data.draw(st.floats(15.0, 500.0), "rate")
    stated = rate * data.draw(st.floats(0.97, 1.03), "stated / rate")
    stretches = data.draw(st.lists(st.integers(20, 150), min_size=1, max_size=5), "samples between gaps")
    lost = data.draw(st.lists(st.floats(2.0, 2000.0), min_size=4, max_size=4), "periods of each gap")
    jitter = data.draw(st.sampled_from([0.0, 0.02, 0.1]), "jitter / period")
    clock = 1e-6 * data.draw(st.integers(-50_000_000, 50_000_000), "offset, us")  # pyxdf divides by it
    seed = data.draw(st.integers(0, 9))
    number = np.concatenate([np.arange(n, dtype=float) for n in stretches])
    starts = np.cumsum([0.0, *(n - 1 + gap for n, gap in zip(stretches[:-1], lost, strict=False))])
    true = 100.0 + (number + np.repeat(starts, stretches)) / rate
    rng = np.random.default_rng(seed)
    stamps = true + jitter / rate * rng.uniform(-1.0, 1.0, true.size)
    _, values = xdf.motion(true.size)
    path = written(tmp_path, xdf.file_of(
        xdf.header(1, labels=LABELS, units=UNITS, rate=stated),
        *(xdf.clock_offset(1, 100.0 + 5.0 * k, clock) for k in range(3)), xdf.samples(1, stamps, values)))
    (ours,) = read_streams(path)
    found = instants_s(ours, "") - clock
    assert np.abs(found - true).max() <= (jitter + 1e-6) / rate
    logging.disable()
    (theirs,), _ = pyxdf.load_xdf(path, jitter_break_threshold_seconds=0.0,
                                  jitter_break_threshold_samples=1.5)
    logging.disable(logging.NOTSET)
    assert np.abs(found + clock - theirs["time_stamps"]).max() <= (2.0 * jitter + 1e-6) / rate
    recording = open_recording(path)
    gaps = gaps_of(recording.stamps_ns * 1e-9, pace_of(recording.stamps_ns * 1e-9))
    assert len(gaps) == len(stretches) - 1
    for gap, periods in zip(gaps, lost, strict=False):
        assert gap.to_s - gap.from_s == pytest.approx(periods / rate, abs=(2.0 * jitter + 1e-3) / rate)
        assert abs(gap.missing + 1 - periods) <= 0.5 + 1e-3 + jitter * (2.0 + 0.1 * periods)


@given(late=st.integers(2, 40), at=st.integers(50, 300), rate=st.floats(20.0, 200.0), seed=st.integers(0, 9))
@settings(max_examples=30, deadline=None)
def test_samples_that_come_late_and_catch_up_are_no_gap(late, at, rate, seed):
    """A radio that is held up and then sends what it kept: as many samples as there should be."""
    rng = np.random.default_rng(seed)
    true = np.arange(400) / rate
    stamps = true + 0.05 / rate * rng.random(400)
    stamps[at:at + late] = np.maximum(stamps[at:at + late], true[at + late] + 1e-5 * np.arange(late))
    stamps = np.maximum.accumulate(stamps)
    pace = pace_of(stamps, rate)
    assert not pace.breaks.size
    assert pace.rate_hz == pytest.approx(rate, rel=0.02)


@pytest.mark.slow
@given(stated=st.floats(10.0, 300.0), wrong=st.one_of(st.floats(0.3, 0.93), st.floats(1.07, 3.0)),
       gap=st.sampled_from([0.0, 1.5, 30.0]), seed=st.integers(0, 9))
@example(stated=60.0, wrong=0.9, gap=0.0, seed=0)
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_nominal_rate_that_the_stamps_contradict_is_refused(tmp_path, stated, wrong, gap, seed):
    rate = stated * wrong
    times = 5.0 + np.arange(300) / rate + np.random.default_rng(seed).uniform(-0.05, 0.05, 300) / rate
    times[120:] += gap
    _, values = xdf.motion(300)
    path = written(tmp_path, xdf.file_of(xdf.header(1, labels=LABELS, units=UNITS, rate=stated),
                                         xdf.samples(1, times, values)))
    refused(path, f"states {stated:g} Hz", "the stamps are at", "layout")
    layout = tmp_path / "layout.toml"
    layout.write_text('time = "imu"\n[units]\ngyr = "deg/s"\nacc = "g"\n[sensors.hand]\n'
                      "gyr = [1, 2, 3]\nacc = [4, 5, 6]\n")
    recording = open_recording(path, layout=layout)  # which takes the stamps alone
    assert abs(recording.duration_ns * 1e-9 - (299 / rate + gap)) < 0.2 / rate


@pytest.mark.parametrize("gap", [0.0, 2.0])
def test_a_rate_that_changes_on_the_way_is_not_put_on_a_line(tmp_path, gap):
    times = 3.0 + np.concatenate([np.arange(600) / 60.0, 10.0 + gap + np.arange(580) / 58.0])
    _, values = xdf.motion(times.size)
    path = written(tmp_path, xdf.file_of(xdf.header(1, labels=LABELS, units=UNITS, rate=60.0),
                                         xdf.samples(1, times, values)))
    np.testing.assert_allclose(open_recording(path).stamps_ns * 1e-9, times - times[0], rtol=0, atol=1e-8)
    with pytest.raises(InputError, match=r"rate changes from 60 Hz to 58 Hz .*start_s and duration_s"):
        Replay(recording=str(path))
    Replay(recording=str(path), duration_s=9.9)
    Replay(recording=str(path), start_s=10.0 + gap)


def test_a_clock_that_was_set_anew_is_refused(tmp_path):
    times, values = xdf.motion(100)
    steps = [(1000.0 + 5.0 * k, 1.0) for k in range(6)] + [(1100.0 + 5.0 * k, 60.0) for k in range(6)]
    path = written(tmp_path, xdf.file_of(xdf.header(1, labels=LABELS, units=UNITS),
                                         *(xdf.clock_offset(1, *step) for step in steps),
                                         xdf.samples(1, times, values)))
    refused(path, "stream imu", "was reset")


def reset_file(tmp_path, back_s, offset_jump_s, at, rate, jitter, seed):
    """A sender whose stamps step back, or forward, and whose clock's offset jumps, at a part of the whole."""
    rng, count = np.random.default_rng(seed), round(40 * rate)
    true, reset_s = np.arange(count) / rate, round(at * count) / rate
    _, values = xdf.motion(count)
    stamps = 1000.0 + true - back_s * (true >= reset_s) + rng.uniform(-jitter, jitter, count) / rate
    measured = np.arange(0.0, count / rate, 2.0)
    clock = 1000.0 + measured - back_s * (measured >= reset_s)
    offset = 5.0 - 3e-5 * measured + offset_jump_s * (measured >= reset_s)
    offset += 2e-4 * rng.normal(size=measured.size)
    return written(tmp_path, xdf.file_of(
        xdf.header(1, labels=LABELS, units=UNITS, rate=rate),
        *(xdf.clock_offset(1, *each) for each in zip(clock, offset, strict=True)),
        *(xdf.samples(1, stamps[k:k + 20], values[k:k + 20]) for k in range(0, count, 20)))), reset_s


@given(back=st.one_of(st.floats(0.05, 100.0), st.floats(-100.0, -0.05)), told=st.booleans(),
       at=st.floats(0.15, 0.85), rate=st.sampled_from([50.0, 100.0, 286.0]),
       jitter=st.sampled_from([0.0, 0.3]), seed=st.integers(0, 5))
@example(back=2.0, told=True, at=0.5, rate=100.0, jitter=0.05, seed=0)
@example(back=10.0, told=False, at=0.5, rate=50.0, jitter=0.05, seed=0)
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_clock_that_is_set_back_or_forward_is_refused_not_put_on_a_line(tmp_path, back, told, at, rate,
                                                                        jitter, seed):
    """Whether the offsets show it or not; stamps that go forward without a jump of offsets are a gap."""
    told = told or back < 0.0
    path, reset_s = reset_file(tmp_path, back, back if told else 0.0, at, rate, jitter, seed)
    text = refused(path, "stream imu", "was reset", "file of its own")
    assert float(text.split(" s at ")[1].split(" s")[0]) == pytest.approx(reset_s, abs=2.1)


@given(stall=st.floats(0.0, 0.05), drift=st.floats(-2e-4, 2e-4), chunk=st.sampled_from([1, 8, 32, 64]),
       seed=st.integers(0, 9))
@settings(max_examples=30, deadline=None)
def test_stamps_that_step_back_between_chunks_are_not_set_back(stall, drift, chunk, seed):
    """A chunk's last sample alone was stamped, each chunk late by another time."""
    late = stall * np.random.default_rng(seed).random(-(-4000 // chunk))
    stamps = 1000.0 + np.arange(4000) / 100.0 * (1.0 + drift) + np.repeat(late, chunk)[:4000]
    assert set_back(stamps) is None


@pytest.mark.parametrize("last", [(1000.0 + 300.0, 3.0), (1000.0 + 25.0, 900.0), (1000.0 + 25.0, 3.0)])
@pytest.mark.parametrize("counted", [99, 100, 0])
def test_samples_that_liblsl_adds_at_the_end_are_left_out_as_by_pyxdf(tmp_path, last, counted):
    times, values = xdf.motion(100)
    steps = [(1000.0 + 5.0 * k, 3.0 + 1e-4 * (k % 3)) for k in range(5)] + [last]
    path = written(tmp_path, xdf.file_of(
        xdf.header(1, labels=LABELS, units=UNITS), *(xdf.clock_offset(1, *step) for step in steps),
        xdf.samples(1, times, values), xdf.footer(1, counted)))
    logging.disable()
    (theirs,), _ = pyxdf.load_xdf(path, handle_clock_resets=False)
    logging.disable(logging.NOTSET)
    (ours,) = read_streams(path)
    np.testing.assert_array_equal(ours.values, theirs["time_series"])
    assert ours.clock_s.tolist() == theirs["clock_times"]


LAYOUT = """
time = "imu"
[units]
gyr = "deg/s"
acc = "g"
[sensors.hand]
gyr = ["wx", "wy", "wz"]
acc = {variable = "other", columns = ["a", 2, 3]}
"""


def test_streams_that_say_too_little_are_described_by_a_layout(tmp_path):
    times, values = xdf.motion(100)
    layout = tmp_path / "layout.toml"
    layout.write_text(LAYOUT)

    def opened(shift=0.0, text=LAYOUT):
        layout.write_text(text)
        content = xdf.file_of(
            xdf.header(1, labels=["wx", "wy", "wz"]), xdf.header(2, "other", labels=["a", "", ""]),
            xdf.samples(1, times, values[:, :3]), xdf.samples(2, times + shift, values[:, 3:6]))
        return open_recording(written(tmp_path, content), layout=layout)

    recording = opened()
    np.testing.assert_array_equal(recording.gyr[:, 0], values[:, :3].astype(float) * (np.pi / 180.0))
    np.testing.assert_array_equal(recording.acc[:, 0], values[:, 3:6].astype(float) * 9.80665)
    assert float(recording.rate) == pytest.approx(100.0, rel=1e-3)
    with pytest.raises(InputError, match="stream other: has other instants than stream imu"):
        opened(0.001)
    for old, new, words in [
            ('"wz"', '"wq"', "0 channels of stream imu are labelled 'wq'"),
            ("2, 3", "2, 4", "channel 4; allowed: 1 to 3"),
            ('"other"', '"othr"', "did you mean 'other'"),
            ('time = "imu"', "rate = 100", "time: names no stream")]:
        with pytest.raises(InputError, match=words) as caught:
            opened(text=LAYOUT.replace(old, new))
        assert "layout.toml" in str(caught.value)


@pytest.mark.parametrize(("form", "dtype"), [("float32", "<f4"), ("double64", "<f8"), ("int16", "<i2"),
                                             ("int32", "<i4"), ("int64", "<i8"), ("int8", "i1")])
def test_every_number_format(tmp_path, form, dtype):
    values = np.arange(90).reshape(10, 9).astype(dtype)
    path = written(tmp_path, xdf.file_of(xdf.header(1, labels=LABELS, form=form),
                                         xdf.samples(1, 5.0 + 0.01 * np.arange(10), values)))
    (theirs,), _ = pyxdf.load_xdf(path)
    np.testing.assert_array_equal(read_streams(path)[0].values, theirs["time_series"])


def test_streams_of_the_same_instants_are_one_set_and_others_are_to_be_chosen(tmp_path):
    times, values = xdf.motion(100)
    three = [("F2p.x", "F2p.y", "F2p.z")]
    content = [
        xdf.header(1, "gyr", labels=three[0], units=["rad/s"] * 3,
                   types=[f"AngularVelocity{axis}" for axis in "XYZ"]),
        xdf.header(2, "acc", labels=three[0], units=["m/s^2"] * 3,
                   types=[f"Acceleration{axis}" for axis in "XYZ"]),
        xdf.header(3, "wrist", labels=LABELS, units=UNITS, rate=50.0),
        xdf.header(4, "markers", kind="Markers", rate=0.0, form="string", labels=["text"]),
        xdf.header(5, "emg", kind="EMG", labels=["EMG_x"], units=["V"]),
        xdf.samples(1, times, values[:, :3]), xdf.samples(2, times, values[:, 3:6] * np.float32(9.81)),
        xdf.samples(3, times[::2], values[:50]),
        xdf.chunk(3, struct.pack("<I", 4) + b"\x01\x01\x08" + struct.pack("<d", 1.0) + b"\x01\x02hi"),
        xdf.samples(5, times, values[:, :1])]
    path = written(tmp_path, xdf.file_of(*content))
    text = refused(path, "wrist", "nothing is resampled", "sensor_set")
    assert "100 samples" in text
    assert "50 samples" in text
    hand = open_recording(path, "gyr, acc")
    assert hand.sensors == ("F2p",)
    np.testing.assert_array_equal(hand.gyr[:, 0], values[:, :3].astype(float))
    assert open_recording(path, "wrist").samples == 50
    refused(path, "no stream 'wrst'", "did you mean 'wrist'", sensor_set="wrst")
    refused(path, "'emg' has no channel of an inertial sensor", sensor_set="emg")


@given(late_us=st.integers(2, 9000), rate=st.sampled_from([0.0, 100.0]))
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_streams_of_other_instants_say_how_far_apart_they_are_and_what_chooses(tmp_path, late_us, rate):
    """As LSL has them: two devices never sample at one instant."""
    times, values = xdf.motion(100)
    path = written(tmp_path, xdf.file_of(
        xdf.header(1, "one", labels=LABELS, units=UNITS, rate=rate),
        xdf.header(2, "two", labels=[f"hand {label}" for label in LABELS], units=UNITS, rate=rate),
        xdf.samples(1, times, values), xdf.samples(2, times + 1e-6 * late_us, values)))
    text = refused(path, "stream two: has other instants than stream one, by up to ",
                   "(100 samples at 100 Hz)", "sensor_set one of 'one', 'two'")
    assert "\n" not in text
    told_ms = float(text.split("by up to ")[1].split(" ms")[0])
    assert told_ms == pytest.approx(1e-3 * late_us, rel=0.01, abs=1e-3)
    assert open_recording(path, "two").samples == 100


def test_streams_of_one_name_are_chosen_by_number(tmp_path):
    times, values = xdf.motion(100)
    path = written(tmp_path, xdf.file_of(
        xdf.header(1, "imu", labels=LABELS, units=UNITS), xdf.header(2, "imu", labels=LABELS, units=UNITS),
        xdf.samples(1, times, values), xdf.samples(2, times, values[::-1])))
    refused(path, "two channels of gyr x", "sensor_set, of 'imu#1', 'imu#2'")
    refused(path, "2 streams are named 'imu'; allowed: imu#1, imu#2", sensor_set="imu")
    for key, told in (("imu#1", values), ("imu#2", values[::-1])):
        np.testing.assert_allclose(open_recording(path, key).acc[0, 0],
                                   told[0, 3:6].astype(float) * 9.80665)
    layout = tmp_path / "layout.toml"
    layout.write_text(LAYOUT_OF_NAMED.replace('"imu"', '"imu#2"'))
    np.testing.assert_allclose(open_recording(path, layout=layout).acc[0, 0],
                               values[-1, 3:6].astype(float) * 9.80665)
    layout.write_text(LAYOUT_OF_NAMED)
    with pytest.raises(InputError, match=r"2 streams of .* are named 'imu'; allowed: imu#1, imu#2"):
        open_recording(path, layout=layout)


LAYOUT_OF_NAMED = ('time = "imu"\n[units]\ngyr = "deg/s"\nacc = "g"\n'
                   '[sensors.imu]\ngyr = [1, 2, 3]\nacc = [4, 5, 6]\n')


@pytest.mark.parametrize("form", ["{axis}_{kind}", "{kind}.{axis}.3", "{kind} hand {axis}"])
def test_labels_are_understood_as_those_of_live_streams(tmp_path, form):
    words = {"gyr": "omega", "acc": "acc", "mag": "magnetic"}
    labels = [form.format(kind=words[label[:3]], axis=label[-1]) for label in LABELS]
    recording = open_recording(written(tmp_path, xdf.motion_file(labels=labels)))
    plain = open_recording(written(tmp_path, xdf.motion_file()))
    for kind in ("gyr", "acc", "mag"):
        np.testing.assert_array_equal(getattr(recording, kind), getattr(plain, kind))
    assert recording.left_out == ()


def test_channels_that_are_not_understood_are_told(tmp_path):
    """Beside others in their stream, or in a whole stream that says what it is of; not those of an EMG."""
    times, values = xdf.motion(100)
    labels = [*LABELS[:6], "field 1", "", "temperature"]
    path = written(tmp_path, xdf.file_of(
        xdf.header(1, "hand", labels=labels, units=UNITS), xdf.header(2, "F2p", "Gyroscope", labels=["w1"]),
        xdf.header(3, "emg", "EMG", labels=["EMG_x"]), xdf.samples(1, times, values),
        xdf.samples(2, times, values[:, :1]), xdf.samples(3, times, values[:, :1])))
    assert open_recording(path).left_out == ("field 1", "hand channel 8", "temperature", "w1")
    assert open_recording(path, "hand").left_out == ("field 1", "hand channel 8", "temperature")
    replay, tick = Replay(recording=str(path)), Tick()
    replay.step(None, (), tick)
    assert tick.reports == [("channels_left_out",
                             "not understood: 'field 1', 'hand channel 8', 'temperature', 'w1'")]
    assert replay.cautions(None) == tuple(tick.reports)
    tick.index, tick.reports = 1, []
    replay.step(None, (), tick)
    assert tick.reports == []


FAULTS = [
    ({"units": ["deg/s"] * 3 + [""] * 3 + ["uT"] * 3}, ("imu: acc", "states no unit")),
    ({"units": ["V"] * 3 + ["g"] * 3 + ["uT"] * 3}, ("imu: gyr", "'V' is no unit of gyr", "deg/s")),
    ({"labels": ["gyr_x", "gyr_y", "gyr_y", *LABELS[3:]]}, ("two channels of gyr y",)),
    ({"labels": ["gyr_x", "gyr_y", "temperature", *LABELS[3:]]},
     ("imu: gyr", "has no axis z", "not understood: 'temperature'")),
    ({"labels": [f"c{k}" for k in range(9)]}, ("no stream whose channels", "imu (IMU)")),
    ({"labels": [*LABELS[:3], *(f"a{k}" for k in range(6))]}, ("imu: acc", "is missing", "'a0', 'a1'")),
    ({"rate": "nan"}, ("stream 1", "has the rate nan")),
    ({"form": "float16"}, ("cannot be decoded", "'float16'")),
]


@pytest.mark.parametrize(("changes", "words"), FAULTS)
def test_headers_that_say_too_little_are_named(tmp_path, changes, words):
    refused(written(tmp_path, xdf.motion_file(**changes)), "lab.xdf", *words)


def test_what_is_damaged_is_refused_at_its_byte(tmp_path):
    whole = xdf.motion_file()
    head = xdf.header(1, labels=LABELS, units=UNITS)
    huge = struct.pack("<I", 1) + b"\x08" + (2**50).to_bytes(8, "little")
    entities = b"<!DOCTYPE x [<!ENTITY a 'aaaa'>]><info>&a;</info>"
    for content, words in [
            (whole[:-20], ("chunk at byte", "are left")),
            (b"XDF:\x03", ("chunk at byte 4", "length of 3 bytes")),
            (xdf.file_of(head, head), ("a second time",)),
            (xdf.file_of(xdf.clock_offset(3, 1.0, 1.0)), ("no header before",)),
            (xdf.file_of(xdf.chunk(9, b"")), ("unknown kind 9",)),
            (xdf.file_of(head, xdf.chunk(3, huge)), ("chunk at byte", "is damaged", "1125899906842624")),
            (xdf.file_of(xdf.chunk(2, struct.pack("<I", 1) + entities)), ("cannot be decoded",)),
            (xdf.file_of(xdf.chunk(2, struct.pack("<I", 1) + b"<info>")), ("cannot be decoded",)),
            (xdf.file_of(head), ("stream imu", "holds no sample")),
            (xdf.file_of(), ("no stream",))]:
        refused(written(tmp_path, content), *words)


def packed(tmp_path, size, within_s, jitter_s, rate, count=1200):
    """A file of samples at 100 Hz that arrive in packets, and are stamped on arrival."""
    count -= count % size
    _, values = xdf.motion(count)
    number = np.arange(count)
    delay = np.random.default_rng(2).normal(0.0, jitter_s, count // size + 1)
    times = 1000.0 + 0.01 * (number // size * size + size - 1) + number % size * within_s \
        + delay[number // size]
    return written(tmp_path, xdf.file_of(xdf.header(1, labels=LABELS, units=UNITS, rate=rate),
                                         xdf.samples(1, times, values)))


@given(size=st.integers(2, 40), within_s=st.sampled_from([0.0, 2e-5, 1e-4]),
       jitter_s=st.sampled_from([0.0, 1e-3, 5e-3]))
@example(size=10, within_s=0.0, jitter_s=0.0)
@example(size=10, within_s=2e-5, jitter_s=5e-3)
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_packets_that_share_a_stamp_are_spread_as_by_pyxdf(tmp_path, size, within_s, jitter_s):
    path = packed(tmp_path, size, within_s, jitter_s, 100.0)
    (theirs,), _ = pyxdf.load_xdf(path)
    (ours,) = read_streams(path)
    found = instants_s(ours, "")
    # Samples of the first and last packet bend the line of least squares by some of their own length.
    np.testing.assert_allclose(found, theirs["time_stamps"], rtol=0.0, atol=2e-3 * size + 4.0 * jitter_s)
    assert np.ptp(np.diff(found)) < 1e-9
    assert float(open_recording(path).rate) == pytest.approx(100.0, rel=2e-3)


@pytest.mark.parametrize("within_s", [0.0, 2e-5])
@pytest.mark.parametrize("rate", [0.0, 400.0])
def test_packets_without_the_rate_of_their_samples_are_refused_with_what_helps(tmp_path, within_s, rate):
    text = refused(packed(tmp_path, 10, within_s, 0.0, rate), "packets of about 10", "100 Hz", "`rate`")
    assert "whose `time` takes the stamps" not in text


def test_packets_that_are_lost_leave_gaps(tmp_path):
    path = packed(tmp_path, 10, 2e-5, 1e-3, 100.0)
    (stream,) = read_streams(path)
    times = np.delete(np.array(stream.times_s), np.s_[500:530])
    on_time = on_lines(times, pace_of(times, 100.0))
    (gap,) = gaps_of(on_time, pace_of(on_time))
    assert gap.missing == 30
