"""The instant of the first sample on its source's clock, by which other streams of the file are aligned."""

import json

import numpy as np
import pytest
import pyxdf
import xdf_files as xdf
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fesloop.apps.cli import main
from fesloop.streams.files import import_recording, open_recording

QUICK = settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
LABELS = [f"gyr_{axis}" for axis in "xyz"] + [f"acc_{axis}" for axis in "xyz"]


@given(begins=st.floats(0.0, 1e6), offset=st.floats(-1e5, 1e5), marker_after=st.floats(0.0, 3.9),
       resample=st.sampled_from([None, "100"]))
@QUICK
def test_a_marker_of_the_same_xdf_file_falls_on_the_sample_that_it_marks(tmp_path, begins, offset,
                                                                         marker_after, resample):
    times = begins + np.arange(400) / 100.0
    values = np.zeros((400, 6))
    values[:, 5] = 1.0
    values[int(marker_after * 100.0), 0] = 5.0
    marked = times[int(marker_after * 100.0)]
    offsets = [xdf.clock_offset(stream, begins + k, offset) for stream in (1, 2) for k in range(4)]
    path = tmp_path / "lab.xdf"
    path.write_bytes(xdf.file_of(
        xdf.header(1, labels=LABELS, units=["deg/s"] * 3 + ["g"] * 3, form="double64"),
        xdf.header(2, name="markers", kind="Markers", rate=0.0, labels=["mark"], form="int32"),
        xdf.samples(1, times, values), *offsets,
        xdf.samples(2, np.array([marked]), np.array([[1]], dtype="<i4"))))
    (tmp_path / "motion.h5").unlink(missing_ok=True)
    import_recording(path, tmp_path / "motion.h5", resample=resample)
    recording = open_recording(tmp_path / "motion.h5")
    streams, _ = pyxdf.load_xdf(path)
    markers = next(each for each in streams if each["info"]["name"] == ["markers"])
    at_s = markers["time_stamps"][0] - recording.origin_s
    nearest = int(np.argmin(np.abs(recording.stamps_ns * 1e-9 - at_s)))
    assert nearest == int(np.argmax(recording.gyr[:, 0, 0]))
    assert recording.stamps_ns[nearest] * 1e-9 == pytest.approx(at_s, abs=1e-5)


@given(begins=st.floats(-1e4, 1e4), unit=st.sampled_from([("s", 1.0), ("ms", 1e-3), ("us", 1e-6)]))
@QUICK
def test_a_tables_first_instant_is_kept_through_every_import(tmp_path, begins, unit):
    name, seconds = unit
    times_s = begins + np.arange(50) / 100.0
    rows = np.column_stack([times_s / seconds, np.tile([0, 0, 0, 0, 0, 9.81], (50, 1))])
    np.savetxt(tmp_path / "lab.csv", rows, delimiter=",", fmt="%.15g", header="t,a,b,c,d,e,f", comments="")
    (tmp_path / "layout.toml").write_text(
        f'time = "t"\n[units]\ntime = "{name}"\n[sensors.S]\ngyr = ["a", "b", "c"]\nacc = ["d", "e", "f"]\n')
    for target in ("one.h5", "two.h5"):
        (tmp_path / target).unlink(missing_ok=True)
    import_recording(tmp_path / "lab.csv", tmp_path / "one.h5", tmp_path / "layout.toml")
    import_recording(tmp_path / "one.h5", tmp_path / "two.h5")
    assert open_recording(tmp_path / "two.h5").origin_s == pytest.approx(begins, abs=1e-8)


def test_the_summary_says_where_t_0_is_or_that_nobody_knows(tmp_path, capsys):
    path = tmp_path / "lab.xdf"
    path.write_bytes(xdf.motion_file())
    assert main(["import", str(path), str(tmp_path / "a.h5"), "--json"]) == 0
    (theirs,), _ = pyxdf.load_xdf(path)
    first_s = theirs["time_stamps"][0]
    assert json.loads(capsys.readouterr().out)["origin_s"] == pytest.approx(first_s, abs=1e-6)
    assert main(["import", str(path), str(tmp_path / "b.h5")]) == 0
    assert f"t = 0 is {first_s:.5f}" in capsys.readouterr().out
    np.savetxt(tmp_path / "lab.csv", np.tile([0, 0, 0, 0, 0, 9.81], (50, 1)), delimiter=",",
               header="a,b,c,d,e,f", comments="")
    (tmp_path / "layout.toml").write_text(
        'rate = 100\n[sensors.S]\ngyr = ["a", "b", "c"]\nacc = ["d", "e", "f"]\n')
    assert main(["import", str(tmp_path / "lab.csv"), str(tmp_path / "c.h5"), "--json",
                 "--layout", str(tmp_path / "layout.toml")]) == 0
    assert json.loads(capsys.readouterr().out)["origin_s"] is None
