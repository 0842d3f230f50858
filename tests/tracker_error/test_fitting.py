"""Error processes of real recordings: fitted to the first half, held against the second. About 30 s."""

import json
import tomllib
from dataclasses import replace
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from recording_files import write

import fesloop
from fesloop.analysis.tracker_error import fitting
from fesloop.analysis.tracker_error.fitting import PLAYER, fit_error, fit_measured, player
from fesloop.analysis.tracker_error.measured_errors import measured_errors
from fesloop.analysis.tracker_error.series_fit import fit_series
from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_MS, NS_PER_S

HINGES = ("seg2-seg3.x", "seg3-seg4.y", "seg4-seg5.z")


@pytest.fixture(scope="module")
def chain(recordings):
    """By the tracker that knows its joints, which nobody has to ask for."""
    return fit_error(str(recordings / "chain5" / "trial1.npz"))


@pytest.mark.slow
def test_hinges_of_the_chain_err_as_the_process_says(chain):
    """RMSE within 15 %, also where the halves themselves differ by more; lags in the band."""
    judged = {each.name: each for each in chain.judgements}
    assert chain.process.usual() == HINGES
    assert chain.process.source == "trial1.npz rigid, tracker constrained"
    for name in HINGES:
        assert judged[name].rmse_holds
        assert judged[name].share >= 0.85
    assert abs(judged["seg2-seg3.x"].halves_differ) > 0.2
    assert sum(each.rmse_holds for each in chain.judgements) >= 12
    assert np.mean([each.share for each in chain.judgements]) > 0.85


@pytest.mark.slow
def test_its_reference_is_found_late(chain):
    """Estimates 15 ms ahead at every moved joint: half a frame of the cameras, and no tracker's doing."""
    assert 10.0 < chain.ahead_ms < 20.0
    assert all(series.lead_s > 0.005 for series in chain.process.series if series.name in HINGES)


@pytest.mark.slow
def test_what_the_reference_is_late_by_is_taken_off(recordings, tmp_path):
    """Of an error that leads, `lead * rate`, as much less as is taken off the reference's stamps."""
    path = recordings / "chain5" / "trial1.npz"
    settings = [f"recording={path}", "tracker=constrained", "blocks.recording.duration_s=30"]

    def leads_ms(late_ms):
        found = {each.name: each for each in measured_errors(run, late_ms * NS_PER_MS).records}
        known = [(found[name].known, found[name]) for name in HINGES]
        return [1e3 * np.polyfit(each.rate[at], each.error[at], 1)[0] for at, each in known]

    with Recording(fesloop.load(PLAYER, settings).run(tmp_path).recording) as run:
        np.testing.assert_allclose(np.subtract(leads_ms(0), leads_ms(20)), 20.0, atol=2.0)


def test_a_recording_is_opened_as_the_settings_say(tmp_path):
    """Without its layout nobody knows what is in a table."""
    rows = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 9.81], (300, 2))
    rows += np.tile([1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0], 2) * np.random.default_rng(0).normal(size=(300, 12))
    np.savetxt(tmp_path / "lab.csv", rows, delimiter=",")
    (tmp_path / "layout.toml").write_text("rate = 100\n[text]\nheader = 0\n[sensors.a]\ngyr = [1, 2, 3]\n"
                                          "acc = [4, 5, 6]\n[sensors.b]\ngyr = [7, 8, 9]\n"
                                          "acc = [10, 11, 12]\n")
    layout = f"blocks.recording.layout={tmp_path / 'layout.toml'}"
    for path, settings, tracker in (
            (tmp_path / "lab.csv", (layout, "pairs=[[0, 1]]"), "vqf"),
            (write(tmp_path, "chain5"), (), "constrained"),
            (write(tmp_path, "chain5"), ("sensor_set=nonrigid", "tracker=vqf"), "vqf")):
        blocks = player(str(path), settings).document()["blocks"]
        assert (blocks["recording"]["recording"], blocks["tracker"]["kind"]) == (str(path), tracker)


@pytest.mark.slow
def test_the_wrist_errs_as_the_process_says(recordings):
    found = fit_error(str(recordings / "wrist" / "circle-250.npz"))
    judged, = found.judgements
    assert judged.name == "radius-carpus.angle"
    assert judged.rmse_holds
    assert judged.autocorrelation_holds


def test_what_estimates_lead_by_is_told_in_ms(recordings, monkeypatch):
    def leading(*records):
        fit = fit_series(*records)
        return replace(fit, series=replace(fit.series, lead_s=0.012))

    monkeypatch.setattr(fitting, "fit_series", leading)
    assert fit_error(str(recordings / "wrist" / "circle-250.npz")).ahead_ms == pytest.approx(12.0)


@pytest.mark.slow
def test_the_second_half_tells_the_process_nothing(recordings):
    """With what comes after the middle replaced by the reference's own mirror, the process stays as it is."""
    path = recordings / "wrist" / "circle-250.npz"
    experiment = fesloop.load(PLAYER, [f"recording={path}"])
    with TemporaryDirectory() as folder, Recording(experiment.run(folder).recording) as run:
        measured = measured_errors(run)
    plain = fit_measured(measured)
    for record in measured.records:
        late = record.times_s >= measured.cut_s
        record.error[late] = 5.0 * record.error[late][::-1]
    measured.lost[measured.estimates.times_ns >= measured.cut_s * NS_PER_S] = True
    assert fit_measured(measured).process == plain.process


def test_the_command_writes_a_file_that_a_loop_takes(recordings, tmp_path, capsys):
    target = tmp_path / "error.toml"
    path = str(recordings / "wrist" / "circle-250.npz")
    assert main(["fit-error", path, str(target), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["angles"][0]["rmse_within_15_percent"]
    numbers = sum(np.size(value) for table in tomllib.loads(target.read_text())["series"].values()
                  for value in table.values())
    assert numbers < 25
    result = fesloop.load("hil_error_replay", [f"error={target}"]).run(tmp_path)
    assert result.metrics["tracker_rmse_deg"][0] > 0.2


@pytest.fixture(scope="module")
def twice(tmp_path_factory):
    """Runs of one simulated finger with other constant errors of the tracker."""
    folder = tmp_path_factory.mktemp("runs")
    settings = ["noise_deg=0.4", "experiment.duration_s=12"]
    return [str(fesloop.load("finger_control", [*settings, f"bias_deg={bias}"], seed).run(folder).recording)
            for seed, bias in ((1, 2.0), (2, -1.0))]


@pytest.mark.slow
def test_one_process_of_two_runs_says_how_they_differ(twice, tmp_path, capsys):
    target = tmp_path / "error.toml"
    assert main(["fit-error", *twice, str(target), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["recordings"]) == 2
    assert [each["recording"] for each in told["angles"]] == [1, 1, 1, 2, 2, 2]
    assert [each["angle"] for each in told["differences"]] == ["MCP", "PIP", "DIP"]
    for each in told["differences"]:
        np.testing.assert_allclose(each["bias_deg"], [2.0, -1.0], atol=0.1)
        np.testing.assert_allclose(each["random_deg"], 0.4, rtol=0.15)
    series = tomllib.loads(target.read_text())["series"]["MCP"]
    assert series["bias_deg"] == pytest.approx(0.5, abs=0.1)
    assert series["bias_sd_deg"] == pytest.approx(3.0 / np.sqrt(2.0), abs=0.1)
    assert main(["fit-error", *twice, str(tmp_path / "again.toml")]) == 0
    shown = capsys.readouterr().err
    assert "recording by recording" in shown
    assert "2: MCP" in shown
    names, (header, *_) = shown.split("2 recordings: ")[0], shown.split("2 recordings: ")[1:]
    assert all(f"{number}: {name}" in names for number, name in enumerate(told["recordings"], 1))
    assert header.startswith("RMS error, deg; fitted to their first halves")
    for column in ("moved", "first half", "within 15 %", "autocorrelation in band", "lags %", "increments"):
        assert f"\n{column}" in shown, "the legend explains it"


def test_recordings_of_other_joints_are_refused(recordings):
    with pytest.raises(InputError, match="have no angle in common"):
        fit_error(*(str(recordings / name) for name in ("wrist/circle-250.npz", "chain5/trial1.npz")),
                  settings=("tracker=vqf",))


@pytest.mark.parametrize(("name", "told"), [
    ("absent.npz", "there is no such file; allowed: a run (.h5), or a recording of sensors with a reference; "
                   "paths start from the current folder, FESLOOP_RECORDINGS or not"),
    ("absent.h5", "there is no such file; "), ("broken.npz", ""), ("broken.csv", "")])
def test_the_command_says_what_is_wrong_with_a_file_and_of_no_experiment(name, told, tmp_path, monkeypatch,
                                                                         capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FESLOOP_RECORDINGS", str(tmp_path / "lab"))
    if name.startswith("broken"):
        (tmp_path / name).write_text("no numbers")
    assert main(["fit-error", name, "e.toml"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"fesloop: {name}: {told}")
    assert "hil_replay" not in line


def test_a_recording_without_a_reference_is_refused(recordings):
    with pytest.raises(InputError, match="no reference of two neighbouring segments"):
        fit_error(str(recordings / "body16" / "qmt_full_body_example_data.mat"),
                  settings=("blocks.recording.duration_s=3",))


def test_of_a_replay_no_tracking_error_is_claimed(recordings, tmp_path):
    path = recordings / "chain5" / "trial1.npz"
    for name in ("replay", "hil_replay"):
        result = fesloop.load(name, [f"recording={path}", "blocks.recording.duration_s=8"]).run(tmp_path)
        assert set(result.metrics) == {"orientation_rmse_deg", "relative_angle_rmse_deg",
                                       "joint_angle_rmse_deg", "flexion_axis_share", "step_us"}


@pytest.mark.slow
def test_hil_replay_takes_one_joint_of_a_whole_body_and_records_its_commands(recordings, tmp_path):
    path = recordings / "body16" / "qmt_full_body_example_data.mat"
    settings = [f"recording={path}", "pairs=[[14, 13]]", "blocks.recording.duration_s=6"]
    result = fesloop.load("hil_replay", settings).run(tmp_path)
    with Recording(result.recording) as run:
        assert run.signal("tracker.angles").values.shape == (601, 1)
        assert run.signal("safety.stimulation").values.max() > 0.0
    assert set(result.metrics) == {"flexion_axis_share", "step_us"}


@pytest.mark.slow
def test_an_imported_recording_is_played_like_its_source(recordings, tmp_path):
    target = tmp_path / "motion.h5"
    assert main(["import", str(recordings / "wrist" / "circle-250.npz"), str(target)]) == 0
    assert fit_error(str(target)).judgements[0].rmse_holds
