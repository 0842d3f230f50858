"""Gyroscope and accelerometer tell the same turn, or sensor, fault and the key that mends it are named."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from agreement_parts import motion
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fesloop.apps.cli import main
from fesloop.streams.agreement import AXES, agreements
from fesloop.streams.files import open_recording

G = 9.80665
SEEDS = st.integers(0, 10_000)
QUICK = settings(max_examples=2, deadline=None)
RECORDINGS = Path(os.environ.get("FESLOOP_RECORDINGS", ""))
PUBLISHED = [("body16/qmt_full_body_example_data.mat", None), ("chain5/trial1.npz", "rigid"),
             ("chain5/trial1.npz", "nonrigid"), ("wrist/circle-250.npz", None),
             *((f"broad/{name}.mat", None) for name in (
                 "02_undisturbed_slow_rotation_B", "24_disturbed_tapping_A", "21_undisturbed_fast_combined",
                 "30_disturbed_stationary_magnet_C"))]


def several(seeds, **about):
    """Samples of sensors that move for themselves, (n, sensors, 3)."""
    each = [motion(seed, **about) for seed in seeds]
    return each[0][0], *(np.stack([samples[kind] for samples in each], axis=1) for kind in (1, 2))


@given(seed=SEEDS, rate=st.sampled_from([20.0, 60.0, 120.0]), turning=st.sampled_from([0.0, 0.1, 1.0, 6.0]),
       shaking=st.sampled_from([0.0, 1.0, 3.0, 5.0]))
@settings(max_examples=4, deadline=None)
def test_right_rates_are_never_doubted(seed, rate, turning, shaking):
    times, gyr, acc = several([seed, seed + 1], rate=rate, turning=turning, shaking=shaking, seconds=30.0)
    found = agreements(times, gyr, acc)
    assert not any(each.doubtful for each in found)
    if turning == 1.0 and shaking <= 1.0:
        assert {each.verdict for each in found} == {"agrees"}


@pytest.mark.slow
@given(seed=SEEDS, number=st.integers(1, 47))
@settings(max_examples=2, deadline=None)
def test_every_order_and_sign_of_axes_is_found(seed, number):
    times, gyr, acc = several([seed], seconds=60.0)
    (found,) = agreements(times, gyr @ AXES[number], acc)
    assert found.verdict == "axes"
    np.testing.assert_array_equal(found.axes, AXES[number])


@given(seed=SEEDS, factor=st.one_of(st.sampled_from([np.pi / 180.0, 180.0 / np.pi]),
                                    st.floats(0.1, 0.7), st.floats(1.4, 10.0)))
@QUICK
def test_a_wrong_scale_is_found_with_its_factor(seed, factor):
    times, gyr, acc = several([seed], turning=0.5)
    (found,) = agreements(times, gyr / factor, acc)
    # 40 s of slow motion does not always tell 1.4 for sure, but takes it for likelier.
    assert found.verdict == "scale" or (found.verdict == "no_information" and 0.6 < factor < 1.7)
    assert found.factor == pytest.approx(factor, rel=0.1)


@given(seed=SEEDS, factor=st.one_of(st.sampled_from([0.5, 2.0]), st.floats(0.2, 0.6), st.floats(1.7, 5.0)),
       shaking=st.floats(0.0, 3.0), noise=st.floats(0.0, 0.5))
@example(seed=3, factor=2.0, shaking=2.0, noise=0.0)
@example(seed=4, factor=2.0, shaking=2.0, noise=0.0)
@settings(max_examples=4, deadline=None)
def test_wrong_rates_never_agree_however_rough_the_motion(seed, factor, shaking, noise):
    times, gyr, acc = several([seed], shaking=shaking, seconds=30.0)
    acc += noise * np.random.default_rng(seed).standard_normal(acc.shape)
    (found,) = agreements(times, gyr / factor, acc)
    assert found.verdict != "agrees"
    if found.verdict == "no_information" and found.factor != 1.0:
        assert found.factor == pytest.approx(factor, rel=0.3)


@pytest.mark.slow
@given(seed=SEEDS, factor=st.one_of(st.floats(0.1, 0.7), st.floats(1.4, 10.0)))
@QUICK
def test_a_wrong_sampling_rate_is_a_scale_of_all_sensors(seed, factor):
    times, gyr, acc = several([seed, seed + 1], turning=0.7, seconds=80.0)
    for found in agreements(times / factor, gyr, acc):
        assert found.verdict == "scale"
        assert found.factor == pytest.approx(factor, rel=0.1)


@given(seed=SEEDS, order=st.permutations(range(3)))
@QUICK
def test_exchanged_gyroscopes_are_found_with_their_owner(seed, order):
    times, gyr, acc = several([seed, seed + 1, seed + 2])
    found = agreements(times, gyr[:, order], acc)
    assert [each.other for each in found] == [order.index(number) for number in range(3)]
    assert [each.verdict for each in found] == ["agrees" if order[number] == number else "exchange"
                                                for number in range(3)]


@pytest.mark.slow
@given(seed=SEEDS, number=st.integers(1, 47))
@QUICK
def test_axes_and_units_at_once_are_found(seed, number):
    times, gyr, acc = several([seed], turning=0.5)
    (found,) = agreements(times, gyr @ AXES[number] * 57.2958, acc)
    assert found.doubtful
    if found.verdict == "axes_and_scale":
        np.testing.assert_array_equal(found.axes, AXES[number])
        assert found.factor == pytest.approx(1.0 / 57.2958, rel=0.1)


@pytest.mark.slow
@given(seed=SEEDS)
@QUICK
def test_a_gyroscope_that_is_dead_or_of_another_motion_disagrees(seed):
    times, gyr, acc = several([seed, seed + 1], seconds=60.0)
    for rates in (0.0 * gyr[:, :1], gyr[:, 1:]):
        (found,) = agreements(times, rates, acc[:, :1])
        assert found.verdict == "disagrees"


@pytest.mark.slow
@given(seed=SEEDS, number=st.integers(1, 47))
@QUICK
def test_lost_samples_and_gaps_change_no_verdict(seed, number):
    times, gyr, acc = several([seed], seconds=60.0)
    lost = np.random.default_rng(seed).random(times.size) < 0.03
    for values in (gyr, acc):
        values[lost] = np.nan
    kept = (times < 20.0) | (times > 23.3)
    (right,) = agreements(times[kept], gyr[kept], acc[kept])
    (wrong,) = agreements(times[kept], gyr[kept] @ AXES[number], acc[kept])
    assert right.verdict == "agrees"
    assert wrong.verdict == "axes"


def test_what_turns_about_the_vertical_or_not_at_all_tells_nothing():
    times = np.arange(3000) / 100.0
    acc = np.tile([0.0, 0.0, G], (times.size, 2, 1))
    gyr = np.zeros_like(acc)
    gyr[:, 0, 2] = np.sin(times)
    assert [each.verdict for each in agreements(times, gyr, acc)] == ["no_information"] * 2
    assert [each.verdict for each in agreements(times[:50], gyr[:50], acc[:50])] == ["no_information"] * 2


def test_motion_about_one_axis_leaves_the_others_open_and_the_simplest_is_named():
    times = np.arange(4000) / 100.0
    angle = 0.6 * np.sin(times)
    acc = G * np.column_stack([np.sin(angle), np.cos(angle), 0.0 * times])[:, None]
    gyr = np.column_stack([0.6 * np.cos(times), 0.0 * times, 0.0 * times])[:, None]
    (found,) = agreements(times, gyr, acc)
    assert found.verdict == "axes"
    np.testing.assert_array_equal(found.axes, np.eye(3)[[2, 1, 0]])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "sensors"), PUBLISHED)
def test_no_published_recording_is_doubted(name, sensors):
    if not (RECORDINGS / name).is_file():
        pytest.skip("FESLOOP_RECORDINGS has no such file")
    recording = open_recording(RECORDINGS / name, sensors)
    found = agreements(recording.stamps_ns * 1e-9, recording.gyr, recording.acc)
    assert not any(each.doubtful for each in found)


def table(folder, gyr, acc, rate=100.0, units="rad/s", **columns):
    """A table of the sensors hand and finger with its layout; `columns` of a sensor's kind are others."""
    axes = {f"{sensor}_{kind}": [f"{sensor}_{kind}{axis}" for axis in "xyz"]
            for sensor in ("hand", "finger") for kind in ("gyr", "acc")}
    rows = np.concatenate([np.concatenate([gyr[:, n], acc[:, n]], axis=1) for n in range(2)], axis=1)
    (folder / "layout.toml").write_text(
        f'rate = "{rate:g}"\npairs = [["hand", "finger"]]\n[units]\ngyr = "{units}"\n' + "".join(
            f"[sensors.{sensor}]\n" + "".join(
                f"{kind} = {json.dumps(columns.get(f'{sensor}_{kind}', axes[f'{sensor}_{kind}']))}\n"
                for kind in ("gyr", "acc")) for sensor in ("hand", "finger")))
    np.savetxt(folder / "lab.csv", rows, delimiter=",", comments="", fmt="%.9g",
               header=",".join(name for names in axes.values() for name in names))
    return folder / "lab.csv", folder / "layout.toml"


FAULTS = {
    "axes": ({"finger_gyr": ["finger_gyry", "finger_gyrx", "finger_gyrz"]}, "finger: rates do not explain",
             "list the columns of `sensors.finger.gyr` as y, x, z in the layout"),
    "acc": ({"finger_acc": ["finger_accz", "finger_accy", "finger_accx"]}, "finger: rates do not explain",
            "list the columns of `sensors.finger.acc` as z, y, x in the layout"),
    "units": ({"units": "deg/s"}, "hand, finger: rates do not", 'set `units.gyr = "rad/s"` in the layout'),
    "rate": ({"rate": 50.0}, "hand, finger: rates do not", "check `rate` in the layout, about "),
    "exchange": ({"finger_gyr": ["hand_gyrx", "hand_gyry", "hand_gyrz"],
                  "hand_gyr": ["finger_gyrx", "finger_gyry", "finger_gyrz"]}, "hand: rates do not",
                 "exchange `sensors.hand.gyr` and `sensors.finger.gyr` in the layout"),
}


@pytest.mark.parametrize("fault", ["axes", *(
    pytest.param(fault, marks=pytest.mark.slow) for fault in FAULTS if fault != "axes")])
def test_import_check_and_run_name_the_sensor_and_the_key(tmp_path, capsys, fault):
    about, names, mends = FAULTS[fault]
    _, gyr, acc = several([3, 4])
    path, layout = table(tmp_path, gyr, acc, **about)
    assert main(["import", str(path), str(tmp_path / "lab.h5"), "--layout", str(layout)]) == 0
    told = capsys.readouterr().err
    assert names in told
    assert mends in told
    given_ = ["hil_replay", "--set", f"recording={tmp_path / 'lab.h5'}"]
    assert main(["check", *given_, "--json"]) == 0
    (detail,) = [each["detail"] for each in json.loads(capsys.readouterr().out)["cautions"]
                 if each["status"] == "rates_disagree"]
    assert names in detail
    assert mends in detail
    if fault == "axes":
        assert main(["run", *given_, "--out", str(tmp_path / "runs")]) == 0
        assert capsys.readouterr().err.startswith(
            "fesloop: the recording played by `recording` is wrong: finger:")


def test_import_says_which_rate_is_likelier_where_motion_is_too_rough_to_be_sure(tmp_path, capsys):
    _, gyr, acc = several([3, 4], shaking=2.0, seconds=30.0)
    path, layout = table(tmp_path, gyr, acc, rate=200.0)
    assert main(["import", str(path), str(tmp_path / "lab.h5"), "--layout", str(layout), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rates_disagree"] == ""
    assert "could not be checked against gravity in 2 of 2 sensors" in told["rates_not_checked"]
    assert "hand, finger: 2 times these rates would explain it better: check `rate`" in told[
        "rates_not_checked"]


def test_a_right_layout_is_no_trouble(tmp_path, capsys):
    _, gyr, acc = several([3, 4])
    path, layout = table(tmp_path, gyr, acc)
    assert main(["import", str(path), str(tmp_path / "lab.h5"), "--layout", str(layout), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rates_disagree"] == ""
