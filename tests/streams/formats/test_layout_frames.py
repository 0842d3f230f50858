"""Layouts: axes of kinds of samples, rotations of sensors, and sensors with instants of their own."""

from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError
from fesloop.streams.files import import_recording, open_recording

SAFE = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
FRAMES = [(order, signs) for order in permutations("xyz") for signs in product("+-", repeat=3)]
COLUMNS = [f"{kind}{axis}" for kind in ("g", "a", "m") for axis in "xyz"]


def matrix(frame):
    """The x, y and z of the other frame, in rows."""
    return np.array([(1.0 if sign == "+" else -1.0) * np.eye(3)["xyz".index(axis)]
                     for axis, sign in zip(*frame, strict=True)])


def named(frame):
    return [axis if sign == "+" else f"-{axis}" for axis, sign in zip(*frame, strict=True)]


def truth(rows=40, seed=1):
    """Samples of a slow sensor in its segment's frame, SI: {kind: (rows, 3)}."""
    rng = np.random.default_rng(seed)
    up = rng.standard_normal(3)
    return {"gyr": rng.normal(0.0, 0.5, (rows, 3)), "acc": 9.81 * up / np.linalg.norm(up) + rng.normal(
        0.0, 0.05, (rows, 3)), "mag": np.array([2e-5, -1e-5, 4e-5]) + rng.normal(0.0, 1e-7, (rows, 3))}


def write(folder, samples, layout, columns=COLUMNS, name="lab.csv"):
    np.savetxt(folder / name, samples, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    (folder / "layout.toml").write_text(layout)
    return open_recording(folder / name, layout=folder / "layout.toml")


SENSOR = '[sensors.S]\ngyr = ["gx", "gy", "gz"]\nacc = ["ax", "ay", "az"]\nmag = ["mx", "my", "mz"]\n'


@given(st.lists(st.sampled_from(FRAMES), min_size=3, max_size=3),
       st.sampled_from([frame for frame in FRAMES if np.linalg.det(matrix(frame)) > 0.0]),
       st.tuples(*[st.floats(-100.0, 100.0)] * 3), st.integers(0, 99))
@SAFE
def test_axes_and_rotation_lead_from_each_chip_to_the_segment(tmp_path, own, sensor, turn, seed):
    """Segment -> sensor (rotation, then axes) -> the axes of each kind, and back by the layout."""
    there = truth(seed=seed)
    back = Rotation.from_rotvec(turn, degrees=True).inv()
    table = np.hstack([back.apply(each) @ matrix(sensor) @ matrix(frame)
                       for each, frame in zip(there.values(), own, strict=True)])
    axes = ", ".join(f"{kind} = {named(frame)}" for kind, frame in zip(there, own, strict=True))
    found = write(tmp_path, table, f"rate = 100\n{SENSOR}axes = {named(sensor)}\nown_axes = {{{axes}}}\n"
                  f"rotation_deg = {list(turn)}\n")
    for kind, each in there.items():
        np.testing.assert_allclose(getattr(found, kind)[:, 0], each, atol=1e-12 * np.abs(each).max())


def test_without_a_rotation_samples_are_those_of_the_file_to_the_last_bit(tmp_path):
    there = truth()
    table = np.hstack(list(there.values()))
    found = write(tmp_path, table, f"rate = 100\n{SENSOR}own_axes = {{acc = ['-x', '-y', '-z']}}\n")
    np.testing.assert_array_equal(found.gyr[:, 0], there["gyr"])
    np.testing.assert_array_equal(found.acc[:, 0], -there["acc"])


TWO = """
[text]
missing = ["", "nan"]
[sensors.A]
time = "ta"
gyr = ["gx", "gy", "gz"]
acc = ["ax", "ay", "az"]
[sensors.B]
time = {file = "b.csv", columns = ["tb"]}
gyr = {file = "b.csv", columns = ["gx", "gy", "gz"]}
acc = {file = "b.csv", columns = ["ax", "ay", "az"]}
"""


def lines(times):
    """Samples that change linearly with time, which straight lines between samples meet exactly."""
    one = times[:, np.newaxis]
    return np.hstack([0.1 * one * [1.0, -2.0, 0.5], [0.0, 0.0, 9.81] + 0.01 * one * [1.0, 1.0, 0.0]])


@given(st.floats(95.0, 105.0), st.floats(95.0, 105.0), st.floats(0.0, 1.0), st.integers(200, 400),
       st.integers(200, 400), st.integers(0, 20), st.integers(0, 99))
@SAFE
def test_sensors_with_clocks_of_their_own_meet_at_the_common_instants(
        tmp_path, hertz_a, hertz_b, late_s, rows_a, rows_b, padding, seed):
    rng = np.random.default_rng(seed)
    times = [start + (np.arange(rows) + rng.uniform(-0.2, 0.2, rows)) / hertz for start, rows, hertz in (
        (5.0, rows_a, hertz_a), (5.0 + late_s, rows_b, hertz_b))]
    columns = ["gx", "gy", "gz", "ax", "ay", "az"]
    padded = np.vstack([np.column_stack([times[0], lines(times[0])]), np.full((padding, 7), np.nan)])
    np.savetxt(tmp_path / "b.csv", np.column_stack([times[1], lines(times[1])]), delimiter=",",
               header=",".join(["tb", *columns]), comments="", fmt="%.17g")
    found = write(tmp_path, padded, f"resample = 100\n{TWO}", ["ta", *columns])
    assert found.rate == 100
    assert found.origin_s == pytest.approx(max(each[0] for each in times))
    at = found.origin_s + np.arange(found.samples) / 100.0
    assert at[-1] <= min(each[-1] for each in times) + 1e-9 < at[-1] + 0.0101
    for number in range(2):
        samples = np.hstack([found.gyr[:, number], found.acc[:, number]])
        np.testing.assert_allclose(samples, lines(at), atol=1e-7)
    assert found.resampled_hz == pytest.approx({"A": hertz_a, "B": hertz_b}, rel=2e-2)
    (tmp_path / "m.h5").unlink(missing_ok=True)
    import_recording(tmp_path / "lab.csv", tmp_path / "m.h5", tmp_path / "layout.toml")
    kept = open_recording(tmp_path / "m.h5")
    assert dict(kept.resampled_hz) == dict(found.resampled_hz)


def test_nothing_is_resampled_unasked(tmp_path):
    columns = ["gx", "gy", "gz", "ax", "ay", "az"]
    times = np.arange(200) / 100.0
    np.savetxt(tmp_path / "b.csv", np.column_stack([1.001 * times, lines(times)]), delimiter=",",
               header=",".join(["tb", *columns]), comments="")
    table = np.column_stack([times, lines(times)])
    with pytest.raises(InputError, match=r"has other instants than sensor A.*write `resample = 100`"):
        write(tmp_path, table, TWO, ["ta", *columns])


def test_a_table_of_uneven_instants_becomes_even_where_the_layout_says_so(tmp_path):
    times = (np.arange(300) + np.random.default_rng(2).uniform(-0.3, 0.3, 300)) / 50.0
    table = np.column_stack([times, lines(times)])
    layout = 'time = "t"\n[sensors.S]\ngyr = ["gx", "gy", "gz"]\nacc = ["ax", "ay", "az"]\n'
    columns = ["t", "gx", "gy", "gz", "ax", "ay", "az"]
    assert write(tmp_path, table, layout, columns).rate is None
    found = write(tmp_path, table, f"resample = 50\n{layout}", columns)
    assert found.rate == 50
    at = times[0] + np.arange(found.samples) / 50.0
    np.testing.assert_allclose(found.gyr[:, 0], lines(at)[:, :3], atol=1e-8)


@pytest.mark.parametrize(("layout", "told"), [
    (f"rate = 100\n{SENSOR}axes = ['-x', 'y', 'z']\n", "axes: .*left-handed.*own_axes"),
    (f"rate = 100\n{SENSOR}own_axes = {{acc = ['x', 'x', 'z']}}\n", "S.own_axes.acc: .*'x', 'x', 'z'"),
    (f"rate = 100\n{SENSOR}rotation_deg = [0, 0, 200]\n", "sensors.S.rotation_deg: .*200"),
    (f"rate = 100\n{SENSOR}time = 'mx'\n", "sensors.S.time: is given beside rate"),
    (f"{SENSOR}", "neither rate nor time is given"),
    (f"time = 'gx'\nresample = 100\n{SENSOR}every = {{mag = 2}}\n", "S.every: is given beside resample"),
    (f"time = 'gx'\n{SENSOR}", "gyr: names column 1"),
])
def test_contradictions_name_their_key(tmp_path, layout, told):
    with pytest.raises(InputError, match=told) as fault:
        write(tmp_path, np.hstack(list(truth().values())), layout)
    assert "\n" not in str(fault.value)
