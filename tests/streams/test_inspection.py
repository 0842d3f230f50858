"""Inspection of files: a layout to start from gives what was written, whatever names, units and forms."""

import json

import numpy as np
import pytest
import xdf_files
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from recording_files import write
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.streams.files import open_recording
from fesloop.streams.inspection import inspect

SAFE = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
UNITS = {"gyr": {"rad/s": 1.0, "deg/s": 180.0 / np.pi}, "acc": {"m/s^2": 1.0, "g": 1.0 / 9.80665,
                                                               "mg": 1e3 / 9.80665},
         "mag": {"T": 1.0, "uT": 1e6, "gauss": 1e4}}
WORDS = {"gyr": ["gyr", "Gyro", "omega", "angular_velocity"], "acc": ["acc", "Accel", "acceleration"],
         "mag": ["mag", "Magn", "magnetometer"]}
TIMES = {"s": 1.0, "ms": 1e3, "us": 1e6}


def motion(rows, sensors, seed, hertz=100.0):
    """Samples of sensors that turn, SI: one {kind: (rows, 3)} for each."""
    rng = np.random.default_rng(seed)
    t = np.arange(rows + 1) / hertz
    found = []
    for _ in range(sensors):
        size, speed, begin = rng.uniform(0.3, 1.2, 3), rng.uniform(1.0, 4.0, 3), rng.uniform(0.0, 6.0, 3)
        turned = Rotation.from_rotvec(size * np.sin(np.outer(t, speed) + begin))
        there = turned[:-1].inv()
        found.append({"gyr": (there * turned[1:]).as_rotvec() * hertz + rng.normal(0.0, 2e-3, (rows, 3)),
                      "acc": there.apply([0.0, 0.0, 9.80665]) + rng.normal(0.0, 0.03, (rows, 3)),
                      "mag": there.apply([0.0, 2e-5, -4e-5]) + rng.normal(0.0, 1e-7, (rows, 3))})
    return found


@st.composite
def tables(draw):
    """A text table of sensors, its meaning, and what its labels state."""
    names = draw(st.lists(st.sampled_from(["hand", "F2p", "wrist_left", "s1"]), min_size=1, max_size=3,
                          unique=True))
    kinds = ["gyr", "acc"] + ["mag"] * draw(st.booleans())
    return {
        "names": names, "kinds": kinds, "order": draw(st.permutations(kinds)),
        "word": {kind: draw(st.sampled_from(WORDS[kind])) for kind in kinds},
        "unit": {kind: draw(st.sampled_from(list(UNITS[kind]))) for kind in kinds},
        "stated": draw(st.booleans()), "time": draw(st.sampled_from([None, *TIMES])),
        "separator": draw(st.sampled_from([",", ";", "\t", " "])), "comma": draw(st.booleans()),
        "above": draw(st.integers(0, 3)), "hertz": draw(st.sampled_from([50.0, 100.0, 400.0])),
        "seed": draw(st.integers(0, 999))}


def written(folder, made):
    """Write the table; the samples that are in it, SI."""
    separator, blank = made["separator"], made["separator"] == " "
    assume(not (made["comma"] and separator == ","))
    samples = motion(1500, len(made["names"]), made["seed"], made["hertz"])
    columns, labels = [], []
    if made["time"]:
        columns.append((3.0 + np.arange(1500) / made["hertz"])[:, np.newaxis] * TIMES[made["time"]])
        labels.append("time" if blank or not made["stated"] else f"time [{made['time']}]")
    for name, own in zip(made["names"], samples, strict=True):
        for kind in made["order"]:
            columns.append(own[kind] * UNITS[kind][made["unit"][kind]])
            unit = f" [{made['unit'][kind]}]" if made["stated"] and not blank else ""
            labels += [f"{name}_{made['word'][kind]}_{axis}{unit}" for axis in "xyz"]
    lines = [f"# recorded by somebody, line {number}" for number in range(made["above"])]
    lines.append(separator.join(labels))
    for row in np.hstack(columns):
        text = separator.join(f"{value:.10g}" for value in row)
        lines.append(text.replace(".", ",") if made["comma"] else text)
    (folder / "lab.csv").write_text("\n".join(lines) + "\n")
    return samples


@given(tables())
@SAFE
def test_the_layout_of_a_table_gives_what_was_written(tmp_path, made):
    samples = written(tmp_path, made)
    found = inspect(tmp_path / "lab.csv")
    (tmp_path / "layout.toml").write_text(found.layout_text())
    recording = open_recording(tmp_path / "lab.csv", layout=tmp_path / "layout.toml")
    assert recording.sensors == tuple(made["names"])
    for number, own in enumerate(samples):
        for kind in made["kinds"]:
            given_back = getattr(recording, kind)[:, number]
            np.testing.assert_allclose(given_back, own[kind], rtol=1e-5, atol=1e-8)
    assert float(recording.rate) == (made["hertz"] if made["time"] else 100.0)
    guesses = " ".join(found.notes)
    assert ("100 Hz is written" in guesses) == (made["time"] is None)
    stated = made["stated"] and made["separator"] != " "
    for kind in made["kinds"]:  # nothing is guessed without a word
        guess = f"no unit of {kind} is stated: by its numbers it is {made['unit'][kind]}"
        assert (guess in guesses) != stated
    assert found.streams[0].samples == 1500
    assert not found.unread


@given(st.integers(1, 3), st.sampled_from([["gyr", "acc"], ["acc", "gyr"], ["acc", "gyr", "mag"]]),
       st.integers(0, 99))
@SAFE
def test_columns_without_a_name_are_known_by_gravity(tmp_path, sensors, order, seed):
    samples = motion(400, sensors, seed)
    table = np.hstack([own[kind] * {"gyr": 180.0 / np.pi, "acc": 1.0, "mag": 1e6}[kind]
                       for own in samples for kind in order])
    np.savetxt(tmp_path / "lab.txt", table, fmt="%.5f")
    found = inspect(tmp_path / "lab.txt")
    assert any("no label names a kind" in note for note in found.notes)
    (tmp_path / "layout.toml").write_text(found.layout_text())
    recording = open_recording(tmp_path / "lab.txt", layout=tmp_path / "layout.toml")
    for number, own in enumerate(samples):
        for kind in ("gyr", "acc"):
            np.testing.assert_allclose(getattr(recording, kind)[:, number], own[kind], atol=1e-4)


@given(st.integers(1, 3), st.permutations(["gyr", "acc"]), st.sampled_from(["rad/s", "deg/s"]),
       st.sampled_from(["m/s^2", "g"]), st.booleans(), st.integers(0, 99))
@SAFE
def test_a_sensor_that_rests_first_is_not_taken_a_column_too_early(
        tmp_path, sensors, order, rate, force, timed, seed):
    """Gravity along an axis is in the window beside the accelerometer's, too, where rates are small."""
    samples = motion(400, sensors, seed)
    scale = {"gyr": UNITS["gyr"][rate], "acc": UNITS["acc"][force]}
    rng, columns = np.random.default_rng(seed), []
    for own in samples:
        still = {"gyr": rng.normal(0.0, 2e-3, (400, 3)),
                 "acc": np.roll([9.80665, 0.0, 0.0], rng.integers(3)) + rng.normal(0.0, 0.03, (400, 3))}
        columns += [scale[kind] * np.vstack([still[kind], own[kind]]) for kind in order]
    times = [0.01 * np.arange(800.0)[:, np.newaxis]] if timed else []
    np.savetxt(tmp_path / "lab.txt", np.hstack([*times, *columns]), fmt="%.7f")
    found = inspect(tmp_path / "lab.txt")
    first = len(times)
    places = {kind.columns[0] for kind in found.kinds}
    assert places == {f"{first + 3 * k + 1}" for k in range(2 * sensors)}


@given(st.integers(0, 99), st.lists(st.integers(20, 380), max_size=3, unique=True), st.integers(4, 30))
@SAFE
def test_gaps_of_a_table_are_found(tmp_path, seed, cuts, length):
    t = np.arange(400) / 100.0
    kept = np.ones(400, dtype=bool)
    for cut in cuts:
        kept[cut:cut + length] = False
    kept[[0, -1]] = True
    own = motion(400, 1, seed)[0]
    np.savetxt(tmp_path / "lab.csv", np.column_stack([t, own["gyr"], own["acc"]])[kept], delimiter=",",
               header="t," + ",".join(f"{kind}_{axis}" for kind in ("gyr", "acc") for axis in "xyz"),
               comments="")
    stream = inspect(tmp_path / "lab.csv").streams[0]
    missing = np.flatnonzero(np.diff(np.concatenate([[1], kept.astype(int), [1]])) == -1).size
    assert len(stream.gaps) == missing
    assert sum(gap.missing for gap in stream.gaps) == 400 - kept.sum()
    assert stream.rate_hz == pytest.approx(100.0)


@pytest.mark.parametrize(("unit", "scale"), [("deg/s", 180.0 / np.pi), ("rad/s", 1.0)])
@pytest.mark.parametrize("seed", range(3))
def test_the_unit_of_slow_rates_is_known_by_how_gravity_turns(tmp_path, unit, scale, seed):
    rng = np.random.default_rng(seed)
    t = np.arange(4001) / 100.0
    turned = Rotation.from_rotvec(0.4 * np.sin(np.outer(t, [0.8, 1.0, 1.2]) + rng.uniform(0.0, 6.0, 3)))
    gyr = (turned[:-1].inv() * turned[1:]).as_rotvec() * 100.0
    acc = turned[:-1].inv().apply([0.0, 0.0, 1.0])
    assert np.abs(gyr * scale).max() < 35.0  # no rate that is too fast for rad/s gives it away
    np.savetxt(tmp_path / "lab.csv", np.column_stack([t[:-1], gyr * scale, acc]), delimiter=",", comments="",
               header="t,gx,gy,gz,ax,ay,az".replace("g", "gyr_").replace("a", "acc_"))
    assert inspect(tmp_path / "lab.csv").layout["units"]["gyr"] == unit


@given(st.sampled_from([2, 4, 10]), st.integers(0, 99))
@SAFE
def test_a_slower_kind_is_written_as_such(tmp_path, every, seed):
    own = motion(400, 1, seed)[0]
    own["mag"][np.arange(400) % every != 0] = np.nan
    table = np.column_stack([np.arange(400) / 100.0, own["gyr"], own["acc"], own["mag"] * 1e6])
    np.savetxt(tmp_path / "lab.csv", table, delimiter=",", comments="", header="time (s)," + ",".join(
        f"{kind}_{axis}" for kind in ("gyr", "acc", "mag") for axis in "xyz"))
    found = inspect(tmp_path / "lab.csv")
    assert found.layout["sensors"]["imu"]["every"] == {"mag": every}
    (tmp_path / "layout.toml").write_text(found.layout_text())
    recording = open_recording(tmp_path / "lab.csv", layout=tmp_path / "layout.toml")
    np.testing.assert_allclose(recording.mag[:, 0], own["mag"][np.arange(400) // every * every], rtol=1e-6)


@given(st.sampled_from(["mat", "npz"]), st.booleans(), st.booleans(), st.integers(0, 99))
@SAFE
def test_the_layout_of_arrays_gives_what_was_written(tmp_path, form, turned, nested, seed):
    samples = dict(zip(["hand", "finger"], motion(300, 2, seed), strict=True))
    content = {}
    for name, own in samples.items():
        arrays = {kind: each.T if turned else each for kind, each in own.items()}
        content |= {name: arrays} if nested and form == "mat" else {
            f"{name}_{kind}": each for kind, each in arrays.items()}
    content["fs"] = 200.0
    path = tmp_path / f"lab.{form}"
    savemat(path, content) if form == "mat" else np.savez(path, **content)
    found = inspect(path)
    (tmp_path / "layout.toml").write_text(found.layout_text())
    recording = open_recording(path, layout=tmp_path / "layout.toml")
    assert recording.rate == 200
    for name, own in samples.items():
        for kind, each in own.items():
            np.testing.assert_allclose(getattr(recording, kind)[:, recording.sensors.index(name)], each)


def test_streams_of_one_file_on_two_clocks_are_brought_together(tmp_path):
    path = tmp_path / "lab.xdf"
    path.write_bytes(two_clocks())
    found = inspect(path)
    assert not found.readable
    rates = {each.name: round(each.rate_hz, 1) for each in found.streams}
    assert rates == {"left": 99.7, "right": 100.2}
    assert found.layout["resample"] == 100
    (tmp_path / "layout.toml").write_text(found.layout_text())
    by_layout = open_recording(path, layout=tmp_path / "layout.toml")
    by_option = open_recording(path, resample=100)
    assert by_layout.sensors == ("left", "right")
    assert dict(by_layout.resampled_hz) == pytest.approx(dict(by_option.resampled_hz))
    np.testing.assert_allclose(by_layout.gyr, by_option.gyr, atol=1e-6)


def two_clocks():
    chunks = []
    for number, (name, hertz) in enumerate((("left", 99.7), ("right", 100.2)), start=1):
        times = 5000.0 + 0.1 * number + np.arange(1200) / hertz
        own = motion(1200, 1, number)[0]
        values = np.hstack([own["gyr"] * 180.0 / np.pi, own["acc"] / 9.80665]).astype(np.float32)
        labels = [f"{name}_{label}" for label in xdf_files.MOTION_LABELS[:6]]
        units = xdf_files.MOTION_UNITS[:6]
        chunks += [xdf_files.header(number, name, rate=100.0, labels=labels, units=units),
                   xdf_files.samples(number, times, values), xdf_files.footer(number, 1200)]
    return xdf_files.file_of(*chunks)


def test_an_xdf_file_that_describes_itself_needs_no_layout_and_gets_one(tmp_path):
    path = tmp_path / "lab.xdf"
    path.write_bytes(xdf_files.motion_file())
    found = inspect(path)
    assert found.readable
    assert {kind.kind: kind.unit for kind in found.kinds} == {"gyr": "deg/s", "acc": "g", "mag": "uT"}
    (tmp_path / "layout.toml").write_text(found.layout_text())
    by_layout = open_recording(path, layout=tmp_path / "layout.toml")
    np.testing.assert_allclose(by_layout.acc, open_recording(path).acc)


@pytest.mark.parametrize("kind", ["broad", "body16", "chain5", "wrist"])
def test_known_sets_need_no_layout(tmp_path, kind):
    found = inspect(write(tmp_path, kind))
    assert found.readable
    assert not found.layout
    recording = open_recording(tmp_path / "trial.dat")
    assert {each.sensor for each in found.kinds} == set(recording.sensors)


@pytest.mark.parametrize("file", ["wrist/circle-250.npz", "chain5/trial1.npz"])
def test_samples_of_real_sensors_are_known_without_a_label(recordings, tmp_path, file):
    """The numbers of a published set alone, in units that its makers did not use."""
    known = open_recording(recordings / file)
    sensor = len(known.sensors) - 1
    table = np.hstack([known.acc[:, sensor] / 9.80665, np.degrees(known.gyr[:, sensor])])
    np.savetxt(tmp_path / "lab.csv", table, delimiter=",", fmt="%.9g")
    found = inspect(tmp_path / "lab.csv")
    assert (found.layout["units"]["acc"], found.layout["units"]["gyr"]) == ("g", "deg/s")
    (tmp_path / "layout.toml").write_text(found.layout_text())
    recording = open_recording(tmp_path / "lab.csv", layout=tmp_path / "layout.toml")
    np.testing.assert_allclose(recording.gyr[:, 0], known.gyr[:, sensor], atol=1e-6)
    np.testing.assert_allclose(recording.acc[:, 0], known.acc[:, sensor], atol=1e-6)


@pytest.mark.parametrize("content", [
    b"", b"a,b\nc,d\n", b"some words\nand more\n", b"1\n2\n3\n", bytes(range(256)),
    b"PK\x03\x04" + bytes(30), b"XDF:\x01"])
def test_what_is_no_recording_is_one_line(tmp_path, content):
    (tmp_path / "lab").write_bytes(content)
    with pytest.raises(InputError) as fault:
        inspect(tmp_path / "lab")
    assert "\n" not in str(fault.value)
    assert str(fault.value).startswith(str(tmp_path / "lab"))


@given(st.lists(st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=9), min_size=1, max_size=30))
@SAFE
def test_no_table_of_numbers_breaks_it(tmp_path, rows):
    width = min(map(len, rows))
    (tmp_path / "lab.csv").write_text("\n".join(",".join(map(repr, row[:width])) for row in rows))
    found = inspect(tmp_path / "lab.csv")
    assert found.streams[0].samples == len(rows)


def test_the_command_writes_a_layout_and_says_what_it_gives(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own = motion(3000, 1, 3)[0]
    np.savetxt("lab.csv", np.hstack([own["gyr"], own["acc"]]), delimiter=",", comments="",
               header="gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z,more"[:-5])
    assert main(["import", "--inspect", "lab.csv", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["layout"] == "lab.layout.toml"
    assert told["taken"] == "1 sensor, 3000 samples, 100 Hz"
    assert main(["import", "lab.csv", "motion.h5", "--layout", "lab.layout.toml"]) == 0
    capsys.readouterr()
    assert main(["import", "--inspect", "lab.csv"]) == 2
    told = "lab.layout.toml: exists; allowed: the name of a new file; give another one"
    assert capsys.readouterr().err.strip() == f"fesloop: {told}"
    assert main(["import", "--inspect", "lab.csv", "other.toml"]) == 0
    out = capsys.readouterr().out
    assert "guessed: no unit of gyr is stated: by its numbers it is rad/s" in out
    assert "next:   fesloop import lab.csv motion.h5 --layout other.toml" in out
    assert main(["import", "--inspect", "lab.csv", "--resample", "100"]) == 2
