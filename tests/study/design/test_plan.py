import zlib

import numpy as np
import pytest
from study_parts import write_study

from fesloop import load
from fesloop.analysis.study.design.plan import NotPrepared, plan
from fesloop.analysis.study.design.study_file import read_study
from fesloop.analysis.study.engine.preparing import meanwhile
from fesloop.analysis.study.engine.worker import experiment_of
from fesloop.errors import InputErrors
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import run


def planned(study):
    return list(plan(study, meanwhile(study)))


@pytest.fixture
def crossed(tmp_path):
    """Latency by gain, with two options of which one is another spelling of what stands there."""
    return read_study(write_study(
        tmp_path, '[axes.latency_ms]\nvalues = [0, 40]\n'
        '[axes.gain]\noptions.file = {}\noptions.same = { settings = ["kp=1"] }\n'
        'options.high = { settings = ["kp=1.5"] }', replicates=2, seed=5))


def test_a_run_is_named_by_the_hash_of_the_experiment_that_load_makes(crossed):
    for each in planned(crossed):
        for run_ in each.runs:
            experiment = load(each.cell.experiment, each.cell.settings, run_.seed)
            assert run_.id == experiment.fingerprint()
            assert run_.seed == 5 + run_.replicate == experiment.seed
            assert experiment_of(zlib.compress(each.document.encode()), run_.seed) == experiment
        assert each.simulated_s == pytest.approx(0.3)


def test_cells_that_come_to_the_same_experiment_share_their_runs(crossed):
    ids = {tuple(each.cell.levels.values()): [run_.id for run_ in each.runs] for each in planned(crossed)}
    assert ids[0, "file"] == ids[0, "same"] != ids[0, "high"]
    assert len({id for each in ids.values() for id in each}) == 2 * 2 * 2


def test_what_is_random_is_the_same_in_every_cell(crossed, tmp_path):
    """The tracker's white noise is what it puts out less the truth at the instant of capture."""
    def noise(each, replicate):
        result = run(load(each.cell.experiment, each.cell.settings, each.runs[replicate].seed), tmp_path)
        with Recording(result.recording) as recording:
            told = np.array(recording.signal("tracker.angles").values)
            truth = recording.signal("finger.angles")
            times = recording.signal("tracker.angles").times_ns
            at = np.searchsorted(truth.times_ns, times)
            assert np.array_equal(truth.times_ns[at], times)
            return told - np.array(truth.values)[at]

    cells = {tuple(each.cell.levels.values()): each for each in planned(crossed)}
    first, far = noise(cells[0, "file"], 0), noise(cells[40, "high"], 0)
    assert np.std(first) > 1e-3
    np.testing.assert_allclose(first, far, atol=1e-12)
    assert not np.allclose(first, noise(cells[0, "file"], 1), atol=1e-4)


def faults_of(tmp_path, axes, **about):
    with pytest.raises(InputErrors) as raised:
        planned(read_study(write_study(tmp_path, axes, **about)))
    return str(raised.value).splitlines()


@pytest.mark.parametrize(("axes", "faults"), [
    ("[axes.latncy_ms]\nvalues = [3, 4]",
     ["tiny: axes.latncy_ms: --set latncy_ms: .*(latncy_ms 3).*did you mean 'latency_ms'"]),
    ('[axes.gain]\nkey = "blocks.controlr.kp"\nvalues = [1]', ["axes.gain: .*(gain 1).*mean 'contr"]),
    ("[axes.latency_ms]\nvalues = [0, -5, 7, -9]", ["-5.0 is negative.*(latency_ms -5)", "-9.0 is negative"]),
    ('[axes.latency_ms]\nvalues = ["late"]', ['"late" is text (latency_ms late); allowed: a number']),
    ('[axes.kp]\nvalues = [1]\n[axes.c]\noptions.a = { settings = ["kd=2"] }\noptions.b = {}',
     ["axes.c: --set kd: is no key of finger_pid_latency (kp 1, c a)"]),
    ('[axes.c]\noptions.a = { experiment = "finger_mcp" }', ["shipped.*(c a).*did you mean 'finger_mpc'"]),
    ('[axes.c]\noptions.a = { experiment = "none.toml" }', ["none.toml: cannot be read: No such f.*(c a)"])])
def test_what_cannot_be_run_is_named_once_with_its_axis_and_the_first_cell(tmp_path, axes, faults):
    found = faults_of(tmp_path, axes, replicates=3)
    assert len(found) == len(faults)
    for line, fault in zip(found, faults, strict=True):
        for part in fault.split(".*"):
            assert part in line


def test_a_setting_of_every_cell_is_not_laid_to_an_axis(tmp_path):
    (fault,) = faults_of(tmp_path, "[axes.latency_ms]\nvalues = [0, 1]", settings=["kq=1"])
    assert "study.settings: --set kq: is no key" in fault


def test_what_runs_in_real_time_only_is_refused_with_the_first_of_its_live_blocks(tmp_path):
    axes = "[axes.hold_ms]\nvalues = [100, 200]"
    (fault,) = faults_of(tmp_path, axes, experiment="hil_dry_stimulator")
    assert "tiny: blocks.device: is live, and a study runs nothing in real time (hold_ms 100)" in fault


def test_of_many_faults_ten_are_shown_and_the_rest_counted(tmp_path):
    found = faults_of(tmp_path, f"[axes.latency_ms]\nvalues = {[-i for i in range(1, 15)]}")
    assert len(found) == 11
    assert "4 more faults like these" in found[-1]


def test_what_could_not_be_prepared_is_planned_with_its_cause_and_the_rest_as_ever(crossed):
    def settings(cell):
        if cell.levels["latency_ms"] == 40:
            raise NotPrepared("identify_grasp: no force")
        return ()

    usual = planned(crossed)
    for each, before in zip(plan(crossed, settings), usual, strict=True):
        if each.cell.levels["latency_ms"] == 40:
            assert each.cause == "identify_grasp: no force"
            assert each.document == ""
            done = {run_.id for other in usual for run_ in other.runs}
            assert done.isdisjoint(run_.id for run_ in each.runs)
        else:
            assert (each.cause, each.runs) == ("", before.runs)


def test_a_cell_that_its_model_makes_invalid_fails_and_the_others_run(crossed):
    def settings(cell):
        return ("blocks.finger.strength=-1",) if cell.number == 1 else ()

    with pytest.raises(InputErrors, match="strength"):
        list(plan(crossed, settings))
    usual, found = planned(crossed), list(plan(crossed, settings, checked=True))
    assert [bool(each.cause) for each in found] == [number == 1 for number in range(len(usual))]
    assert "strength" in found[1].cause
    assert [each.runs for number, each in enumerate(found) if number != 1] == [
        each.runs for number, each in enumerate(usual) if number != 1]
