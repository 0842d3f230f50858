"""A hand that follows recorded joint angles: files of several forms, and movement between their samples."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fesloop import Recording, load
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.angle_courses import read_courses
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context
from plants.moving_hand.plant import MovingHand
from plants.moving_hand.recorded import RecordedAngles

SAFE = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
FREEDOMS = hand_tree(HandSize()).freedoms
USED = ("wrist_flexion", "F2_mcp_flexion", "F2_pip_flexion")
MIDDLE, SIZE = np.radians([0.0, 30.0, 40.0]), np.radians([20.0, 15.0, 25.0])
HERTZ = 100.0


def course(times, speed=2.0 * math.pi * 0.5):
    """Angles of the three freedoms and their first two derivatives, each (n, 3)."""
    phase = speed * np.asarray(times)[:, np.newaxis] + np.array([0.0, 1.0, 2.0])
    return MIDDLE + SIZE * np.sin(phase), SIZE * speed * np.cos(phase), -SIZE * speed**2 * np.sin(phase)


def opensim(path, times, angles, names=USED, degrees=True, extra=()):
    rows = np.column_stack([times, np.degrees(angles) if degrees else angles])
    head = ["lab", "version=1", f"nRows={len(rows)}", f"nColumns={rows.shape[1]}", *extra,
            f"inDegrees={'yes' if degrees else 'no'}", "endheader", "\t".join(["time", *names])]
    lines = ["\t".join(f"{value:.12g}" for value in row) for row in rows]
    path.write_text("\n".join([*head, *lines]) + "\n")
    return str(path)


def observed(hand, times):
    """Angles, rates, accelerations (n, 3) of the three freedoms."""
    state = hand.init(Context("hand", 1, 0, None))
    at = [FREEDOMS.index(name) for name in USED]
    found = hand.observe(state, (), 0, [round(1e9 * time) for time in times])
    return [each[:, at] for each in found[:3]]


@given(st.floats(0.1, 2.0), st.booleans(), st.sampled_from([5.0, 20.0]), st.floats(0.0, 3.0))
@SAFE
def test_the_hand_follows_the_samples_and_what_lies_between(tmp_path, hertz, degrees, knot_ms, begin):
    speed, times = 2.0 * math.pi * hertz, np.arange(400) / HERTZ
    file = opensim(tmp_path / "lab.mot", begin + times, course(times, speed)[0], degrees=degrees)
    hand = MovingHand(recorded=RecordedAngles(file=file, lowpass_hz=0.0, still_s=1.0), knot_ms=knot_ms)
    at = np.linspace(0.1, 3.8, 200)  # not beside the ends, where a spline has no neighbours
    for found, exact in zip(observed(hand, 2.0 + at), course(at, speed), strict=True):
        np.testing.assert_allclose(found, exact, atol=1e-3 * max(1.0, np.abs(exact).max()))


def test_the_low_pass_removes_noise_and_no_movement(tmp_path):
    times = np.arange(1000) / HERTZ
    noisy = course(times)[0] + np.random.default_rng(1).normal(0.0, math.radians(0.3), (1000, 3))
    file = opensim(tmp_path / "lab.mot", times, noisy)
    at = np.linspace(1.0, 9.0, 400)
    rough, smooth = (observed(MovingHand(recorded=RecordedAngles(file=file, lowpass_hz=hertz)), 2.5 + at)
                     for hertz in (0.0, 6.0))
    exact = course(at)
    assert np.abs(smooth[0] - exact[0]).max() < math.radians(0.5)
    assert np.std(smooth[2] - exact[2]) < 0.05 * np.std(rough[2] - exact[2])


def test_the_hand_is_still_then_moves_to_the_first_sample_and_stops_behind_the_last(tmp_path):
    times = np.arange(300) / HERTZ
    file = opensim(tmp_path / "lab.mot", times, course(times)[0])
    hand = MovingHand(recorded=RecordedAngles(file=file, still_s=1.5, approach_s=1.0),
                      rest_deg={"wrist_flexion": 10.0, "F3_pip_flexion": 20.0})
    angles, rates, _ = observed(hand, [0.0, 1.5, hand.length_s, hand.length_s + 9.0])
    np.testing.assert_allclose(np.degrees(angles[:2]), [[10.0, 0.0, 0.0]] * 2, atol=1e-9)
    np.testing.assert_allclose(angles[2], angles[3], atol=1e-5)
    np.testing.assert_allclose(angles[2], course(times)[0][-1], atol=math.radians(2.0))
    np.testing.assert_allclose(rates[[0, 1, 3]], 0.0, atol=1e-9)
    every = hand.observe(hand.init(Context("hand", 1, 0, None)), (), 0, [2_000_000_000])[0][0]
    assert math.degrees(every[FREEDOMS.index("F3_pip_flexion")]) == pytest.approx(20.0)
    near = np.arange(0.0, hand.length_s, 0.01)
    angles, rates, _ = observed(hand, near)
    steps = np.diff(angles, axis=0) / 0.01  # no jump at the seams
    np.testing.assert_allclose(steps, 0.5 * (rates[1:] + rates[:-1]), atol=0.05)


def test_columns_of_other_names_and_signs(tmp_path):
    times = np.arange(300) / HERTZ
    angles = course(times)[0]
    (tmp_path / "lab.csv").write_text("time_ms,wrist ext_deg,mcp2_rad,pip2_deg,other_deg\n" + "\n".join(
        f"{1e3 * t!r},{-math.degrees(a)!r},{b!r},{math.degrees(c)!r},7"
        for t, (a, b, c) in zip(times.tolist(), angles.tolist(), strict=True)))
    columns = dict(zip(USED, ("-wrist ext", "mcp2", "pip2"), strict=True))
    recorded = RecordedAngles(file=str(tmp_path / "lab.csv"), columns=columns)
    np.testing.assert_allclose(recorded.angles, angles, atol=1e-12)
    part = RecordedAngles(file=str(tmp_path / "lab.csv"), columns=columns, start_s=1.0, duration_s=1.0)
    np.testing.assert_allclose(part.angles, angles[100:201], atol=1e-12)


@given(st.permutations(["units=Nothing", "Coordinates", "a comment = b", ""]), st.booleans())
@SAFE
def test_a_header_of_opensim_may_hold_anything(tmp_path, extra, degrees):
    times = np.arange(20) / HERTZ
    file = opensim(tmp_path / "lab.sto", times, course(times)[0], degrees=degrees, extra=extra)
    found = read_courses(file, "", 0)
    assert found.names == USED
    np.testing.assert_allclose(found.values, course(times)[0], atol=1e-9)


SCRIPT = """
[experiment]
name = "replayed"
duration_s = 4
[blocks.hand]
kind = "moving_hand"
knot_ms = 10
recorded = { file = "lab.mot" }
[blocks.tracker]
kind = "ideal"
rate = "100"
[[wires]]
from = "hand.angles"
to = "tracker.angles"
[score]
truth = "hand.angles"
estimate = "tracker.angles"
"""


def test_a_run_can_be_exported_and_moved_again(tmp_path, monkeypatch):
    times = np.arange(300) / HERTZ
    (tmp_path / "there").mkdir()
    opensim(tmp_path / "there" / "lab.mot", times, course(times)[0])
    (tmp_path / "there" / "mine.toml").write_text(SCRIPT)
    monkeypatch.chdir(tmp_path)
    assert main(["run", "there/mine.toml", "--out", "runs"]) == 0
    with Recording("runs/replayed-1.h5") as run:
        angles = run.signal("hand.angles")
        first, when = np.array(angles.values), angles.times_ns
        part = run.experiment["blocks"]["hand"]["recorded"]
    assert len(part["fingerprint"]) == 64
    assert main(["export", "runs/replayed-1.h5", "--format", "mot", "--signals", "tracker.angles",
                 "--out", "again.mot"]) == 0
    again = RecordedAngles(file="again.mot", lowpass_hz=0.0, still_s=0.0, approach_s=0.5)
    hand = MovingHand(recorded=again)
    found = hand.observe(hand.init(Context("hand", 1, 0, None)), (), 0, (when + 500_000_000).tolist())[0]
    np.testing.assert_allclose(found, first, atol=math.radians(0.01))
    opensim(tmp_path / "there" / "lab.mot", times, 0.5 * course(times)[0])
    with pytest.raises(InputError, match="has changed: its fingerprint is"):
        load("runs/replayed-1.h5")


@pytest.mark.parametrize(("change", "told"), [
    ({"columns": {"F2_pip": "F2_pip_flexion"}}, "columns.F2_pip: is no freedom of the hand"),
    ({"columns": {"F2_pip_flexion": "pip"}}, "columns.F2_pip_flexion: 'pip' is not in"),
    ({"columns": {"F3_pip_flexion": "-F2_pip_flexion"}}, r"F3_pip_flexion: is -65 to -15 deg; .*-NAME"),
    ({"start_s": 2.95}, "holds 5 samples"),
    ({"lowpass_hz": 60.0}, "lowpass_hz: 60; allowed: below 50 Hz"),
    ({"approach_s": 0.0}, "approach_s: 0; allowed: above 0"),
    ({"still_s": -1.0}, "still_s: -1"),
    ({"signal": "hand.angles"}, "signal: given for .*lab.mot, which is not a recording"),
    ({"fingerprint": "abc"}, "has changed"),
])
def test_wrong_parameters_are_one_line(tmp_path, change, told):
    times = np.arange(300) / HERTZ
    file = opensim(tmp_path / "lab.mot", times, course(times)[0])
    with pytest.raises(InputError, match=told) as fault:
        RecordedAngles(file=file, **change)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize(("before", "after", "told"), [
    ("inDegrees=yes\n", "", "inDegrees: is missing; allowed: yes or no"),
    ("inDegrees=yes", "inDegrees=maybe", "inDegrees: 'maybe'"),
    ("time\t", "t\t", "line 7: 't wrist_flexion"),
    ("F2_mcp_flexion", "wrist_flexion", "line 7: "),
    ("\n0.05\t", "\n0.05\tx\t", "line 13: '0.05"),
    ("\n0.05\t", "\n0.05\t1\t", "line 13: 5 numbers; allowed: 4"),
    ("\n0.05\t", "\n0.01\t", "sample 5 at 0.01 s is not after 0.04 s"),
])
def test_faults_of_a_file_of_opensim_name_the_line(tmp_path, before, after, told):
    times = np.arange(20) / HERTZ
    path = tmp_path / "lab.mot"
    opensim(path, times, course(times)[0])
    text = path.read_text()
    assert before in text
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(InputError, match=told):
        read_courses(str(path), "", 0)


@given(first=st.integers(1, 150), lost=st.integers(0, 60))
def test_a_gap_longer_than_a_straight_line_is_good_for_is_refused(tmp_path_factory, first, lost):
    times = np.delete(np.arange(300) / HERTZ, slice(first, first + lost))
    path = tmp_path_factory.mktemp("gap") / "hand.mot"
    opensim(path, times, course(times)[0])
    if (lost + 1) / HERTZ > 0.1 + 1e-9:
        told = (rf"has no samples for {(lost + 1) / HERTZ:.4g} s, from {(first - 1) / HERTZ:.4g} s on; "
                "allowed: gaps of at most 0.1 s")
        with pytest.raises(InputError, match=told):
            RecordedAngles(file=str(path))
    else:
        assert RecordedAngles(file=str(path)).times_s.size == 300 - lost


def test_missing_samples_and_other_columns_are_told(tmp_path):
    times = np.arange(30) / HERTZ
    angles = course(times)[0]
    angles[7, 1] = np.nan
    with pytest.raises(InputError, match=r"F2_mcp_flexion: has 1 samples without a number, .* 0.07 s"):
        RecordedAngles(file=opensim(tmp_path / "lab.mot", times, angles))
    with pytest.raises(InputError, match=r"has no column of a freedom of the hand, but a, b, c; "):
        RecordedAngles(file=opensim(tmp_path / "lab.mot", times, course(times)[0], names=("a", "b", "c")))
    with pytest.raises(InputError, match="script and recorded are given"):
        MovingHand(script="hour", recorded=RecordedAngles(
            file=opensim(tmp_path / "lab.mot", times, course(times)[0])))
