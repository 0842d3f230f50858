"""Files that a layout describes: text tables and .mat files, units, time, references, and every fault."""

import csv

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mat73_files import write_mat73
from recording_files import CONTENTS, SAMPLES, still
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from fesloop.apps.cli import main
from fesloop.errors import InputError, InputErrors
from fesloop.streams.files import open_recording
from fesloop.streams.text_table import TextForm, read_table

LAYOUT = """
rate = "2000/7"
pairs = [["forearm", "hand"]]

[units]
gyr = "deg/s"
acc = "g"

[sensors.forearm]
gyr = ["g0", "g1", "g2"]
acc = [5, 6, 7]

[sensors.hand]
gyr = ["h0", "h1", "h2"]
acc = ["b0", "b1", "b2"]
"""
NAMES = ["t", "g0", "g1", "g2", "a0", "a1", "a2", "h0", "h1", "h2", "b0", "b1", "b2"]


def table():
    """(SAMPLES, 13): time in ms, forearm deg/s and g, hand deg/s and g."""
    (gyr, acc, _), (other_gyr, other_acc, _) = still(seed=0), still(seed=1)
    times = 10.0 * np.arange(SAMPLES)[:, np.newaxis]
    return np.hstack([times, np.rad2deg(gyr), acc / 9.80665, np.rad2deg(other_gyr), other_acc / 9.80665])


def written(folder, layout=LAYOUT, values=None, separator=",", decimal=".", names=NAMES):
    values = table() if values is None else values
    with (folder / "lab.csv").open("w", newline="") as file:
        writer = csv.writer(file, delimiter=separator)
        writer.writerow(names)
        writer.writerows([[repr(float(cell)).replace(".", decimal) for cell in row] for row in values])
    (folder / "layout.toml").write_text(layout)
    return folder / "lab.csv", folder / "layout.toml"


def opened(paths):
    return open_recording(paths[0], layout=paths[1])


def refused(paths, *words):
    with pytest.raises(InputError) as caught:
        opened(paths)
    for line in str(caught.value).splitlines():
        assert str(paths[1].parent) in line
    for word in words:
        assert word in str(caught.value), str(caught.value)


def test_columns_by_name_and_number_in_si(tmp_path):
    recording = opened(written(tmp_path))
    values = table()
    assert recording.sensors == ("forearm", "hand")
    assert recording.pairs == ((0, 1),)
    assert str(recording.rate) == "2000/7"
    np.testing.assert_array_equal(recording.gyr[:, 1], values[:, 7:10] * (np.pi / 180.0))
    np.testing.assert_array_equal(recording.acc[:, 0], values[:, 4:7] * 9.80665)
    assert recording.mag is None
    assert recording.source_units == {"gyr": "deg/s", "acc": "g"}


def test_a_european_table_with_time_and_missing_values(tmp_path):
    layout = LAYOUT.replace('rate = "2000/7"', 'time = "t"').replace(
        "[units]", '[text]\nseparator = ";"\ndecimal = ","\nmissing = ["", "lost"]\n[units]\ntime = "ms"')
    paths = written(tmp_path, layout, separator=";", decimal=",")
    lines = paths[0].read_text().splitlines()
    cells = lines[4].split(";")
    lines[4] = ";".join([*cells[:7], "lost", *cells[8:12], ""])
    paths[0].write_text("\ufeff" + "\r\n".join(lines), encoding="utf-8")
    recording = opened(paths)
    assert recording.rate == 100
    assert recording.stamps_ns[3] == 30_000_000
    np.testing.assert_array_equal(np.argwhere(np.isnan(recording.gyr)), [[3, 1, 0]])
    np.testing.assert_array_equal(np.argwhere(np.isnan(recording.acc)), [[3, 1, 2]])
    np.testing.assert_array_equal(recording.gyr[4:, 0], table()[4:, 1:4] * (np.pi / 180.0))


@given(values=st.lists(st.lists(st.floats(allow_nan=False), min_size=3, max_size=3), min_size=1, max_size=6),
       separator=st.sampled_from([",", ";", "\t", " ", "|"]), decimal=st.sampled_from([".", ","]))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_every_double_is_read_to_the_last_bit(tmp_path, values, separator, decimal):
    if separator == decimal:
        return
    path = tmp_path / "numbers.txt"
    path.write_text("\n".join(separator.join(repr(cell).replace(".", decimal) for cell in row)
                              for row in values))
    read = read_table(path, TextForm(separator=separator, decimal=decimal, header=0)).values
    assert read.tobytes() == np.array(values).tobytes()


def test_a_mark_for_what_is_missing_is_known_in_the_files_own_spelling(tmp_path):
    path = tmp_path / "numbers.txt"
    path.write_text("1,5;-999,0\n-999,0;2,5\n")
    form = TextForm(separator=";", decimal=",", header=0, missing=("-999,0",))
    np.testing.assert_array_equal(read_table(path, form).values, [[1.5, np.nan], [np.nan, 2.5]])


def variables():
    (gyr, acc, mag), quat = still(), Rotation.random(SAMPLES, rng=np.random.default_rng(3)).as_quat()
    return {"imu": {"gyr": gyr, "accT": np.ascontiguousarray(acc.T), "name": "hand"},
            "all": np.hstack([mag, quat]), "fs": 100.0, "label": ["one", np.arange(3.0)],
            "scored": (np.arange(SAMPLES) > 4).astype("u1")}


MATLAB = """
rate = 100
[units]
mag = "uT"
[sensors.hand]
gyr = "imu.gyr"
acc = "imu.accT"
mag = {variable = "all", columns = [1, 2, 3]}
orientation = {variable = "all", columns = [4, 5, 6, 7]}
[reference]
order = "xyzw"
direction = "reference_to_segment"
scored = "scored"
north = true
"""


@pytest.mark.parametrize("version", ["5", "5 compressed", "7.3"])
def test_variables_of_matlab_files(tmp_path, version):
    path, layout = tmp_path / "lab.mat", tmp_path / "layout.toml"
    content = variables()
    if version == "7.3":
        write_mat73(path, content)
    else:
        savemat(path, {**content, "label": np.array(content["label"], dtype=object)},
                do_compression="compressed" in version)
    layout.write_text(MATLAB)
    recording = opened((path, layout))
    np.testing.assert_array_equal(recording.gyr[:, 0], content["imu"]["gyr"])
    np.testing.assert_array_equal(recording.acc[:, 0], content["imu"]["accT"].T)
    np.testing.assert_array_equal(recording.mag[:, 0], content["all"][:, :3] * 1e-6)
    vector = np.array([0.3, -0.4, 0.5])
    told = Rotation.from_quat(recording.reference.orientation[:, 0], scalar_first=True)
    np.testing.assert_allclose(told.apply(vector), Rotation.from_quat(
        content["all"][:, 3:]).inv().apply(vector), atol=1e-12)
    assert recording.reference.scored.tolist() == [k > 4 for k in range(SAMPLES)]
    assert recording.reference.north


def test_sets_that_are_known_are_read_from_matlab_73_too(tmp_path):
    content = CONTENTS["broad"]()
    content["movement"] = content["movement"].astype("u1")
    path = write_mat73(tmp_path / "broad.mat", content)
    recording = open_recording(path)
    assert recording.source_format == "broad"
    np.testing.assert_array_equal(recording.gyr[:, 0], content["imu_gyr"])


LAYOUT_FAULTS = [
    ('rate = "2000/7"', "", ("rate", "neither rate nor time")),
    ('rate = "2000/7"', 'rate = "fast"', ("rate", "'fast'")),
    ('rate = "2000/7"', 'rate = "1e999999999"', ("rate", "'1e999999999'")),
    ('rate = "2000/7"', "rate = 2e9", ("rate", "sampling rate")),
    ('gyr = "deg/s"', 'gyr = "rpm"', ("units.gyr", "'rpm'", "deg/s")),
    ('gyr = "deg/s"', 'gyro = "deg/s"', ("units.gyro", "unknown key", "did you mean 'gyr'")),
    ('"h2"]', '"h3"]', ("sensors.hand.gyr", "'h3' is no column", "h0, h1, h2")),
    ('"h2"]', '"h2"]\nmag = [1, 2, 99]', ("sensors.hand.mag", "column 99", "1 to 13")),
    ("[5, 6, 7]", "[5, 6]", ("sensors.forearm.acc", "names 2 columns", "3")),
    ("[5, 6, 7]", '"a0"', ("sensors.forearm.acc", "names 1 columns")),
    ("acc = [5, 6, 7]", "", ("sensors.forearm.acc", "is missing")),
    ("[5, 6, 7]", '{variable = "x", columns = [1]}', ("a text file is one table",)),
    ('"hand"]]', '"leg"]]', ("pairs", "'leg' is no sensor")),
    ('"hand"]]', '"forearm"]]', ("pairs", "'forearm' is paired with itself")),
    ('"h2"]', '"h1"]', ("sensors.hand.gyr", "names column 9 twice")),
    ("[units]", '[text]\nseparator = ",,"\n[units]', ("text.separator", "',,'")),
    ("[units]", "[text]\nheader = 0\n[units]", ("line 1: column", "'t' is no number")),
    ("[units]", "[units", ("is not TOML",)),
    ('gyr = "deg/s"', 'gyr = "rad/s"', ("forearm: gyr", )),
    ("[5, 6, 7]", "[5, 6, 7]\norientation = [2, 3, 4, 5]", ("sensors.hand.orientation", "others have it")),
]


@pytest.mark.parametrize(("old", "new", "words"), LAYOUT_FAULTS)
def test_faults_of_layouts_are_named_with_their_key(tmp_path, old, new, words):
    assert old in LAYOUT
    values = table()
    values[:, 1:4] *= 200.0
    layout = LAYOUT.replace(old, new, 1)
    refused(written(tmp_path, layout, values if "rad/s" in new else None), *words)


ORIENTED = LAYOUT.replace("acc = [5, 6, 7]", "acc = [5, 6, 7]\norientation = [14, 15, 16, 17]").replace(
    'acc = ["b0", "b1", "b2"]', 'acc = ["b0", "b1", "b2"]\norientation = [14, 15, 16, 17]')


@pytest.mark.parametrize(("samples", "reference", "key"), [
    ('rate = "2000/7"', "rate = 285.7143", ""), ('rate = "2000/7"', 'time = "t"', "rate"),
    ('rate = "2000/7"', "rate = 50", "reference.rate"), ("rate = 100", 'time = "t"', ""),
    ('time = "t"', "rate = 100.05", ""), ('time = "t"', "rate = 100.2", "reference.rate"),
    ('time = "t"', "rate = 60", "reference.rate"), ('time = "t"', 'time = "t"', "")])
def test_a_table_has_one_rate(tmp_path, samples, reference, key):
    """Its stamps are at 100 Hz; what is stated for one half of its columns must hold for the other."""
    layout = ORIENTED.replace('rate = "2000/7"', samples).replace("[units]", '[units]\ntime = "ms"')
    unit = np.tile([1.0, 0.0, 0.0, 0.0], (SAMPLES, 1))
    paths = written(tmp_path, f"{layout}\n[reference]\n{reference}\n", np.hstack([table(), unit]),
                    names=[*NAMES, "qw", "qx", "qy", "qz"])
    if key:
        refused(paths, f"layout.toml: {key}: lets {SAMPLES} orientations last", "the same, within 0.1 %")
    else:
        assert opened(paths).reference.stamps_ns.size == SAMPLES


@pytest.mark.parametrize(("begins_s", "late_ns", "first"), [
    (0.0, 0, 0), (0.25, 250_000_000, 0), (-0.5, 0, 25), (-0.13, 10_000_000, 7)])
def test_a_reference_that_begins_later_or_sooner_stays_where_it_is(tmp_path, begins_s, late_ns, first):
    """By one clock, which need not begin at 0: samples at 100 Hz, orientations at 50."""
    (gyr, acc, _), turns = still(), Rotation.from_rotvec(np.linspace(0.0, 1.0, 60)[:, np.newaxis] * [0, 0, 1])
    t = 1000.0 + np.arange(SAMPLES) / 100.0
    own = t[0] + begins_s + np.arange(60) / 50.0
    q = turns.as_quat(scalar_first=True)
    np.savez(tmp_path / "lab.npz", t=t, own=own, gyr=gyr, acc=acc, q=q)
    (tmp_path / "layout.toml").write_text('time = "t"\n[sensors.hand]\ngyr = "gyr"\nacc = "acc"\n'
                                          'orientation = "q"\n[reference]\ntime = "own"\n')
    reference = opened((tmp_path / "lab.npz", tmp_path / "layout.toml")).reference
    np.testing.assert_array_equal(reference.stamps_ns, late_ns + 20_000_000 * np.arange(60 - first))
    np.testing.assert_allclose(reference.orientation[:, 0], q[first:])
    assert reference.scored.size == 60 - first
    for other in (own + 3600.0, own - 3600.0):
        np.savez(tmp_path / "lab.npz", t=t, own=other, gyr=gyr, acc=acc, q=q)
        refused((tmp_path / "lab.npz", tmp_path / "layout.toml"), "reference.time", "by one clock")


def test_as_many_rows_of_another_rate_are_refused_and_fewer_are_not(tmp_path):
    """Half as many at half the rate are another system's."""
    path, layout = tmp_path / "lab.mat", tmp_path / "layout.toml"
    content = variables()
    for rows, rate, taken in ((SAMPLES, 50, False), (SAMPLES // 2, 50, True), (SAMPLES, 100, True)):
        savemat(path, {**content, "turns": content["all"][:rows, 3:], "scored": content["scored"][:rows]})
        layout.write_text(MATLAB.replace('{variable = "all", columns = [4, 5, 6, 7]}', '"turns"')
                          + f"rate = {rate}\n")
        if taken:
            assert len(opened((path, layout)).reference.orientation) == rows
        else:
            refused((path, layout), "reference.rate: lets")


def test_faults_of_tables_are_named_with_line_and_column(tmp_path):
    paths = written(tmp_path)
    text = paths[0].read_text().splitlines()
    for line, change, words in [
            (7, lambda row: row + ",1", ("line 8", "14 columns")),
            (7, lambda row: "abc" + row, ("line 8: column 't'", "is no number")),
            (0, lambda row: row + ",more", ("line 1", "names 14 columns")),
            (0, lambda row: row.replace("g1", "g0"), ("sensors.forearm.gyr", "'g0' is listed twice"))]:
        spoilt = list(text)
        spoilt[line] = change(spoilt[line])
        paths[0].write_text("\n".join(spoilt))
        refused(paths, *words)
    paths[0].write_text(text[0])
    refused(paths, "holds no row")
    paths[0].write_bytes(b"\xff\xfe")
    refused(paths, "not UTF-8")


@pytest.mark.parametrize(("instant", "words"), [
    (60.0, "sample 7 does not come after"), (50.0, "sample 7 does not come after"), (np.nan, "not finite")])
def test_instants_that_do_not_increase_are_refused(tmp_path, instant, words):
    values = table()
    values[7, 0] = instant
    layout = LAYOUT.replace('rate = "2000/7"', 'time = "t"').replace("[units]", '[units]\ntime = "ms"')
    assert opened(written(tmp_path, layout)).rate == 100
    refused(written(tmp_path, layout, values), words)


def test_several_faults_of_a_layout_are_named_at_once(tmp_path):
    layout = LAYOUT.replace("[5, 6, 7]", "true").replace('gyr = "deg/s"', "gyr = 1")
    with pytest.raises(InputErrors) as caught:
        opened(written(tmp_path, layout))
    assert len(str(caught.value).splitlines()) == 2


def test_a_sensor_set_beside_a_layout_is_refused(tmp_path):
    paths = written(tmp_path)
    with pytest.raises(InputError, match="and a layout are given"):
        open_recording(paths[0], "imu", paths[1])


@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
@pytest.mark.parametrize("ended", ["rows", "names", "all"])
def test_a_separator_behind_the_last_cell_ends_no_column(tmp_path, separator, ended):
    layout = LAYOUT.replace("[units]", f"[text]\nseparator = '{separator}'\n[units]").replace("'\t'", '"\\t"')
    plain = opened(written(tmp_path, layout, separator=separator))
    paths = written(tmp_path, layout, separator=separator)
    names, *rows = paths[0].read_text().splitlines()
    names += separator * (ended != "rows")
    paths[0].write_text("\n".join([names, *(row + separator * (ended != "names") for row in rows)]))
    recording = opened(paths)
    assert recording.fingerprint() == plain.fingerprint()
    # A mark for what is missing makes it read cell by cell.
    paths[0].write_text(paths[0].read_text().replace(rows[5].split(separator)[1], "n/a", 1))
    assert np.isnan(opened(paths).gyr).sum() == 1


def test_a_last_column_without_numbers_is_a_column_if_it_has_a_name(tmp_path):
    path = tmp_path / "numbers.txt"
    path.write_text("a,b,note\n1,2,\n3,4,\n")
    read = read_table(path, TextForm())
    assert read.names == ("a", "b", "note")
    np.testing.assert_array_equal(read.values, [[1, 2, np.nan], [3, 4, np.nan]])
    path.write_text("a,b,\n1,2,3\n")
    assert read_table(path, TextForm()).names == ("a", "b", "")


def test_a_separator_behind_every_row_is_not_behind_some(tmp_path):
    path = tmp_path / "numbers.txt"
    path.write_text("a,b\n1,2,\n3,4\n")
    with pytest.raises(InputError, match="line 1: names 2 columns, the first row has 3"):
        read_table(path, TextForm())


def test_a_reference_of_zeros_is_missing_and_reported_once(tmp_path, capsys):
    turned = np.tile([1.0, 0.0, 0.0, 0.0], (SAMPLES, 2))
    turned[:3] = 0.0
    turned[3, 4:] = 0.0
    layout = LAYOUT.replace("[sensors.hand]", 'orientation = [14, 15, 16, 17]\n[sensors.hand]')
    paths = written(tmp_path, layout + "orientation = [18, 19, 20, 21]\n[reference]\nsensor_frames = false\n",
                    values=np.hstack([table(), turned]), names=[*NAMES, *"ijklmnop"])
    recording = opened(paths)
    assert np.isnan(recording.reference.orientation).all(axis=2).sum(axis=0).tolist() == [3, 4]
    assert main(["import", str(paths[0]), str(tmp_path / "lab.h5"), "--layout", str(paths[1])]) == 0
    (told,) = [line for line in capsys.readouterr().err.splitlines() if "NaN or zeros" in line]
    assert f"missing, NaN or zeros: forearm 3 of {SAMPLES}, hand 4 of {SAMPLES}" in told


FILES = LAYOUT.replace('acc = [5, 6, 7]', 'acc = {file = "acc.csv", columns = ["a0", "a1", "a2"]}').replace(
    'acc = ["b0", "b1", "b2"]', 'acc = {file = "acc.csv", columns = [4, 5, 6]}')


def written_apart(folder, layout=FILES):
    """The table with accelerations in a file of their own, and its layout."""
    values = table()
    written(folder, values=values[:, [4, 5, 6, 10, 11, 12]], names=["a0", "a1", "a2", "b0", "b1", "b2"])
    (folder / "lab.csv").rename(folder / "acc.csv")
    return written(folder, layout, values[:, [0, 1, 2, 3, 7, 8, 9]], names=[*NAMES[:4], *NAMES[7:10]])


def test_a_recording_in_several_files_is_the_one_in_one(tmp_path):
    whole = opened(written(tmp_path)).fingerprint()
    assert opened(written_apart(tmp_path)).fingerprint() == whole
    savemat(tmp_path / "acc.mat", {"force": table()[:, [4, 5, 6, 10, 11, 12]]})
    layout = FILES.replace('acc.csv", columns = ["a0", "a1", "a2"]',
                           'acc.mat", variable = "force", columns = [1, 2, 3]')
    assert opened(written_apart(tmp_path, layout)).fingerprint() == whole


@pytest.mark.parametrize(("old", "new", "words"), [
    ('file = "acc.csv", columns = ["a0', 'file = "no.csv", columns = ["a0', ("no.csv", "no such file")),
    ('columns = [4, 5, 6]', 'columns = [4, 5, 9]', ("sensors.hand.acc", "column 9", "1 to 6", "acc.csv")),
    ('columns = [4, 5, 6]', 'columns = [4, 5, 1]', ("sensors.hand.acc", "column 1 of acc.csv",
                                                    "as well as sensors.forearm.acc")),
    ('file = "acc.csv", columns = [4', 'columns = [4', ("sensors.hand.acc", "variable", "file, or both"))])
def test_faults_of_several_files_are_named(tmp_path, old, new, words):
    assert old in FILES
    refused(written_apart(tmp_path, FILES.replace(old, new)), *words)


def test_files_of_other_lengths_are_refused_and_a_missing_column_says_how_to_name_a_file(tmp_path):
    paths = written_apart(tmp_path)
    refused((paths[0], written_apart(tmp_path, LAYOUT)[1]), "'b0' is no column", "another file are {file =")
    paths = written_apart(tmp_path)
    (tmp_path / "acc.csv").write_text("\n".join((tmp_path / "acc.csv").read_text().splitlines()[:-3]))
    refused(paths, "sensors.forearm.acc", f"has {SAMPLES - 3} samples, sensors.forearm.gyr has {SAMPLES}")


def test_magnetometers_without_a_unit_are_refused_with_the_key_for_it(tmp_path):
    field = np.tile([20.0, 0.0, -40.0], (SAMPLES, 1))
    layout = LAYOUT.replace("[sensors.hand]", "mag = [14, 15, 16]\n[sensors.hand]") + "mag = [17, 18, 19]\n"
    paths = written(tmp_path, layout, values=np.hstack([table(), field, field]), names=[*NAMES, *"ijklmn"])
    refused(paths, "forearm: mag", "uT read as T", "units.mag", "uT, gauss")
    paths[1].write_text(layout.replace("[units]", '[units]\nmag = "a.u."'))
    refused(paths, "units.mag: 'a.u.' is no unit", "leave the magnetometers out")
    paths[1].write_text(layout.replace("[units]", '[units]\nmag = "uT"'))
    np.testing.assert_allclose(opened(paths).mag[0, 0], [20e-6, 0.0, -40e-6])
