"""A tracker that errs like a recorded one: error, age, loss and stamps, in a loop and by itself."""

import numpy as np
import pytest

import fesloop
from estimators.error_replay import ErrorReplay
from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.block import Context, Tick
from fesloop.loop.duration import Duration
from fesloop.loop.signals import NEVER, Sample
from fesloop.models.error_process import ErrorProcess, ErrorSeries

MS = 1_000_000


def process(*series, **other):
    return ErrorProcess(series=series or (ErrorSeries(name="a.z", fast_deg=1.0, fast_s=0.2),), **other)


def run(block, truth, seed=0, name="tracker", step_ns=10 * MS):
    """Estimates (n, joints) of a truth (n, joints), deg, and the captures that they are stamped with."""
    state, tick = block.init(Context(name, seed)), Tick()
    estimates, captures = [], []
    for k, angles in enumerate(np.radians(truth)):
        tick.index, tick.time_ns, tick.captured_ns = k, k * step_ns, NEVER
        sample = Sample(angles, k * step_ns, k * step_ns, k * step_ns)
        estimates.append(block.step(state, (sample,), tick)[0])
        captures.append(tick.captured_ns)
    return np.degrees(estimates), np.array(captures)


def test_size_and_correlation_in_time_are_those_of_the_process():
    series = ErrorSeries(name="a.z", bias_deg=2.0, slow_deg=1.0, slow_s=0.5, quick_deg=0.5)
    estimates, _ = run(ErrorReplay(process=process(series), joints=1), np.zeros((60_000, 1)))
    error = estimates[:, 0]
    assert error.mean() == pytest.approx(2.0, abs=0.15)
    assert error.std() == pytest.approx(np.sqrt(1.25), rel=0.06)
    off = error - error.mean()
    for lag, wanted in ((1, np.exp(-0.02) / 1.25), (25, np.exp(-0.5) / 1.25)):
        assert np.mean(off[:-lag] * off[lag:]) / off.var() == pytest.approx(wanted, abs=0.05)


def test_it_follows_from_angle_and_rate():
    series = ErrorSeries(name="a.z", slope=0.1, lead_s=-0.05)
    truth = np.arange(200)[:, None] * 0.2
    estimates, _ = run(ErrorReplay(process=process(series), joints=1), truth)
    np.testing.assert_allclose(estimates[1:] - truth[1:], 0.1 * truth[1:] - 0.05 * 20.0, atol=1e-9)
    centred, _ = run(ErrorReplay(process=process(series), joints=1, centre_deg=(10.0,)), truth)
    np.testing.assert_allclose(estimates - centred, 1.0)


def test_joints_err_together_as_the_series_do_and_copies_alone():
    series = [ErrorSeries(name=name, moved=True, quick_deg=1.0) for name in ("a.x", "b.y")]
    pair = process(*series, correlation=((1.0, 0.8), (0.8, 1.0)))
    estimates, _ = run(ErrorReplay(process=pair, joints=3), np.zeros((20_000, 3)))
    np.testing.assert_allclose(np.corrcoef(estimates.T), [[1.0, 0.8, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 1.0]],
                               atol=0.03)
    swapped = ErrorReplay(process=pair, joints=2, like=("b.y", "b.y"))
    assert swapped.numbers() == [1, 1]


def test_estimates_are_as_old_as_the_recorded_ones_and_say_so():
    old = process(ErrorSeries(name="a.z"), age_ms=25.0)
    truth = np.arange(100)[:, None] * 1.0
    estimates, captures = run(ErrorReplay(process=old, joints=1), truth)
    np.testing.assert_array_equal(captures[3:], np.arange(97) * 10 * MS)
    np.testing.assert_allclose(estimates[3:, 0], np.arange(97))


def test_jittered_ages_are_drawn_and_captures_never_go_back():
    late = process(age_ms=5.0, jitter=Duration(kind="exponential", mean_ms=20.0, high_ms=100.0))
    _, captures = run(ErrorReplay(process=late, joints=1), np.zeros((5000, 1)), step_ns=MS)
    assert (np.diff(captures) >= 0).all()
    ages = (np.arange(5000) * MS - captures)[200:]
    assert ages.min() >= 5 * MS
    assert ages.max() <= 105 * MS
    assert ages.mean() > 6 * MS


def test_lost_estimates_leave_the_last_one_with_its_stamp_in_bursts():
    lossy = process(loss=0.2, burst_messages=4.0)
    estimates, captures = run(ErrorReplay(process=lossy, joints=1), np.zeros((40_000, 1)))
    lost = np.diff(captures) == 0
    assert lost.mean() == pytest.approx(0.2, abs=0.02)
    assert lost.sum() / (lost[1:] & ~lost[:-1]).sum() == pytest.approx(4.0, rel=0.15)
    assert (np.diff(estimates[:, 0])[lost] == 0.0).all()
    assert (np.diff(estimates[:, 0])[~lost] != 0.0).all()


def test_each_seed_and_name_has_an_error_of_its_own_and_the_same_one_again():
    block, truth = ErrorReplay(process=process(), joints=1), np.zeros((50, 1))
    one = run(block, truth)[0]
    np.testing.assert_array_equal(run(block, truth)[0], one)
    assert not np.allclose(run(block, truth, seed=1)[0], one)
    assert not np.allclose(run(block, truth, name="other")[0], one)
    np.testing.assert_allclose(run(ErrorReplay(process=process(), joints=1, size=2.0), truth)[0], 2.0 * one)


def test_each_trial_has_another_constant_part():
    block = ErrorReplay(process=process(ErrorSeries(name="a.z", bias_deg=1.0, bias_sd_deg=2.0)), joints=2)
    found = np.array([run(block, np.zeros((3, 2)), seed=seed)[0] for seed in range(200)])
    np.testing.assert_array_equal(np.ptp(found, axis=1), 0.0)
    assert found.mean() == pytest.approx(1.0, abs=0.4)
    assert found[:, 0].std(axis=0).mean() == pytest.approx(2.0, rel=0.2)
    assert abs(np.corrcoef(found[:, 0].T)[0, 1]) < 0.25


def test_each_trial_has_another_size_with_the_same_mean_square():
    block = ErrorReplay(process=process(ErrorSeries(name="a.z", quick_deg=1.0, size_sd=0.5)), joints=1)
    found = np.array([run(block, np.zeros((200, 1)), seed=seed)[0].std() for seed in range(400)])
    assert np.log(found).std() == pytest.approx(0.5, rel=0.15)
    assert np.mean(found**2) == pytest.approx(1.0, rel=0.35)


@pytest.mark.parametrize("several", [False, True])
def test_a_draw_of_several_recordings_is_stated_once_a_trial(several):
    series = ErrorSeries(name="a.z", bias_deg=1.0, bias_sd_deg=2.0 * several)
    block, tick = ErrorReplay(process=process(series), joints=2), Tick()
    state, sample = block.init(Context("t")), Sample(np.zeros(2), 0, 0, 0)
    (angles,), _ = block.step(state, (sample,), tick), block.step(state, (sample,), tick)
    assert [status for status, _ in tick.reports] == ["one_draw"] * several
    if several:
        stated = ", ".join(f"{each:.1f}" for each in np.degrees(angles))
        assert f"constant parts {stated} deg, random parts times 1.0, 1.0" in tick.reports[0][1]


def test_before_any_truth_it_says_so():
    block, tick = ErrorReplay(process=process(), joints=2), Tick()
    nothing = Sample(np.zeros(2), NEVER, NEVER, NEVER)
    assert block.step(block.init(Context("t")), (nothing,), tick) == ()
    assert [status for status, _ in tick.reports] == ["no_sample"]


@pytest.mark.parametrize(("change", "told"), [
    ({"like": ("b",)}, "no series 'b'; allowed: a.z"),
    ({"joints": 2, "like": ("a.z",)}, "like: has 1 values"),
    ({"size": -1.0}, "size"), ({"joints": -1}, "joints"), ({"centre_deg": (float("nan"),)}, "centre_deg")])
def test_misuse(change, told):
    with pytest.raises(InputError, match=told):
        ErrorReplay(process=process(), **change)


def test_the_shipped_loop_sees_the_error_and_its_age(tmp_path):
    file = tmp_path / "error.toml"
    process(ErrorSeries(name="a.z", slow_deg=3.0, slow_s=0.5), age_ms=30.0).save(file)
    result = fesloop.load("hil_error_replay", [f"error={file}", "experiment.duration_s=4"]).run(tmp_path)
    ideal = fesloop.load("hil_error_replay", ["tracker=ideal", "experiment.duration_s=4"]).run(tmp_path)
    assert result.metrics["tracker_rmse_deg"][0] == pytest.approx(3.0, rel=0.4)
    assert ideal.metrics["tracker_rmse_deg"][0] < 1e-9
    assert result.metrics["joint_rmse_deg"][0] > 2.0 * ideal.metrics["joint_rmse_deg"][0]
    with Recording(result.recording) as recording:
        signal = recording.signal("tracker.angles")
        assert set((signal.times_ns - signal.newest_ns)[10:].tolist()) == {30 * MS}
        # The process itself stands in the recording, which needs no file to be run again.
        assert recording.experiment["blocks"]["tracker"]["process"]["series"][0]["slow_deg"] == 3.0
    file.unlink()
    again = fesloop.load(result.recording).run(tmp_path)
    assert again.metrics["joint_rmse_deg"] == result.metrics["joint_rmse_deg"]


def test_an_experiment_without_a_file_and_one_with_another_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"blocks\.tracker\.process: is missing"):
        fesloop.load("hil_error_replay")
    with pytest.raises(InputError, match=r"blocks\.tracker\.process: .*cannot be read"):
        fesloop.load("hil_error_replay", [f"error={tmp_path / 'none.toml'}"])
    wrong = tmp_path / "wrong.toml"
    process().save(wrong)
    wrong.write_text(wrong.read_text().replace("fast_deg = 1.0", "fast_deg = -1.0"))
    with pytest.raises(InputError, match="fast_deg: -1"):
        fesloop.load("hil_error_replay", [f"error={wrong}"])
