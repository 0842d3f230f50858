"""Studies from end to end: in this process, on one cluster of two workers that is started by hand."""

import os
import zlib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from random import Random
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from study_blocks import prepared_or_not, slowly, waited
from study_kills import started_cluster
from study_parts import TESTS, harmful_experiment, with_harmful_blocks, write_study

from fesloop import load as load_experiment
from fesloop.analysis.study import load
from fesloop.analysis.study.design.plan import plan
from fesloop.analysis.study.design.study_file import read_study
from fesloop.analysis.study.engine import cluster, coordinator, preparing, running, worker
from fesloop.analysis.study.engine import tasks as tasks_module
from fesloop.analysis.study.engine.cluster import connected
from fesloop.analysis.study.engine.coordinator import run_study
from fesloop.analysis.study.engine.preparing import meanwhile, prepare_one
from fesloop.analysis.study.engine.running import DIED
from fesloop.analysis.study.engine.tasks import Done, Task, completed
from fesloop.errors import InputError, InputErrors, RunError
from fesloop.experiment import registry
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.registry import identifier
from fesloop.experiment.running import run
from fesloop.loop.machine import one_blas_thread
from fesloop.models.patient_model import load_patient_model

LATENCIES = "[axes.latency_ms]\nvalues = [0, 20, 40]\n"
HARM = '[axes.deed]\nkey = "blocks.harmful.deed"\nvalues = {}\n'


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """Of a cluster whose workers know the kind `harmful`, as does this process."""
    folder = tmp_path_factory.mktemp("cluster")
    environment = with_harmful_blocks(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", environment["PYTHONPATH"])
        patch.setenv("STUDY_BLOCKS", str(folder))
        patch.syspath_prepend(folder / "installed")
        patch.syspath_prepend(TESTS)
        forget_kinds()
        with started_cluster(folder, 2) as started:
            yield started.address
    forget_kinds()


def forget_kinds():
    registry._entries.cache_clear()
    registry.find.cache_clear()


@pytest.fixture(scope="module")
def crossed(address, tmp_path_factory):
    """A study of six runs, and its results on the cluster."""
    folder = tmp_path_factory.mktemp("crossed")
    study = read_study(write_study(folder, LATENCIES, replicates=2, recordings="all"))
    summary = run_study(study, folder, scheduler=address)
    assert (summary.runs, summary.done, summary.failed) == (6, 6, {})
    return study, load(summary.store)


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 3])
def test_any_number_of_workers_gives_the_same_results(crossed, tmp_path, workers):
    study, results = crossed
    assert load(run_study(study, tmp_path, workers=workers).store).digest() == results.digest()


@pytest.mark.slow
def test_any_order_of_runs_gives_the_same_results(crossed, address, tmp_path, monkeypatch):
    study, results = crossed
    in_order = running.tasks_of

    def shuffled(*given):
        tasks = list(in_order(*given))
        Random(4).shuffle(tasks)
        return iter(tasks)

    monkeypatch.setattr(running, "tasks_of", shuffled)
    assert load(run_study(study, tmp_path, scheduler=address).store).digest() == results.digest()


def test_numbers_and_recordings_are_those_of_a_direct_run(crossed, tmp_path):
    _, results = crossed
    table = results.table()
    for number in (0, 5):
        latency, seed = table["latency_ms"][number], int(table["seed"][number])
        settings = ["experiment.duration_s=0.3", "score.after_s=0.1", f"latency_ms={latency}"]
        direct = run(load_experiment("finger_pid_latency", settings, seed), tmp_path)
        assert table["error_deg"][number] == direct.metrics["joint_rmse_deg"][-1]
        assert table["seen_deg"][number] == direct.metrics["tracker_rmse_deg"][-1]
        with Recording(table["recording"][number]) as kept, Recording(direct.recording) as made:
            assert kept.digest() == made.digest()
    folder = Path(table["recording"][0]).parent
    assert sorted(path.name for path in folder.iterdir()) == sorted(f"{id_}.h5" for id_ in table["id"])


def test_a_study_that_is_done_runs_nothing_again(crossed):
    study, results = crossed
    before = results.path.read_bytes()
    summary = run_study(study, results.path.parents[1], scheduler="tcp://127.0.0.1:1")
    assert (summary.done, summary.runs) == (6, 6)
    assert results.path.read_bytes() == before


def harmful_study(folder, deeds, **about):
    name = harmful_experiment(folder)
    return read_study(write_study(folder, LATENCIES + HARM.format(deeds), experiment=name, **about))


def test_a_failing_run_is_a_row_with_its_cause_and_keeps_its_recording(address, tmp_path):
    study = harmful_study(tmp_path, ["none", "raise"], recordings="failed")
    summary = run_study(study, tmp_path, scheduler=address)
    (cause,) = summary.failed
    assert cause.startswith("ValueError: harm is done (study_blocks.py:")
    assert (summary.done, summary.failed[cause]) == (3, 3)
    table = load(summary.store).table()
    assert table["status"].tolist() == ["done", "failed"] * 3
    assert table["cause"].tolist() == ["", cause] * 3
    for status, recording in zip(table["status"], table["recording"], strict=True):
        assert bool(recording) == (status == "failed")
    with Recording(table["recording"][1]) as recording:
        assert recording.status == "failed"


@pytest.mark.slow
def test_failed_runs_are_run_again_only_if_asked_for(address, tmp_path):
    mended = tmp_path / "mended"
    study = harmful_study(tmp_path, ["none", "unless"], settings=[f"blocks.harmful.marker={mended}"])
    assert sum(run_study(study, tmp_path, scheduler=address).failed.values()) == 3
    mended.touch()
    assert run_study(study, tmp_path, scheduler=address).done == 3
    summary = run_study(study, tmp_path, scheduler=address, retry_failed=True)
    assert (summary.done, summary.failed) == (6, {})


@pytest.mark.slow
def test_a_run_that_ends_its_worker_each_time_is_failed_and_all_others_are_done(address, tmp_path):
    """With one worker, others lie beside it there each time; and it ends while its worker still starts."""
    name = harmful_experiment(tmp_path)
    deeds = HARM.format(["exit", "none", "other", "third"])
    study = read_study(write_study(tmp_path, deeds, experiment=name))
    summary = run_study(study, tmp_path, workers=1)
    assert summary.failed == {DIED: 1}
    assert load(summary.store).table()["status"].tolist() == ["failed", "done", "done", "done"]


@pytest.mark.parametrize(("settings", "metrics", "fault"), [
    (["blocks.harmful.deed=raise"], 'e = "joint_rmse_deg"', "base experiment itself fails: ValueError: harm"),
    ([], 'e = "joint_rmse"',
     "^tiny: study.metrics.e: a run has no metric 'joint_rmse'.*mean 'joint_rmse_deg'"),
    ([], 'e = "rmse"', "^tiny: study.metrics.e: a run has no metric 'rmse'.*mean 'joint_rmse_deg' or "),
    ([], 'e = "joints"', "^tiny: study.metrics.e: 'joints' is not a number")])
def test_a_base_that_fails_is_named_before_anything_runs(address, tmp_path, settings, metrics, fault):
    name = harmful_experiment(tmp_path)
    study = read_study(write_study(tmp_path, LATENCIES, experiment=name, settings=settings, metrics=metrics))
    with pytest.raises(InputErrors, match=fault) as raised:
        run_study(study, tmp_path, scheduler=address)
    assert len(str(raised.value).splitlines()) == 1
    assert str(raised.value).count("allowed: ") == 1
    assert load(tmp_path / "tiny").finished == 0


def test_the_first_run_tries_the_base_and_is_kept(address, tmp_path, monkeypatch):
    asked = []
    for module in (coordinator, running):
        def noted(client, tasks, *given, module=module, wrapped=module.completed):
            def each():
                for task_ in tasks:
                    asked.append((module, task_.id))
                    yield task_
            return wrapped(client, each(), *given)
        monkeypatch.setattr(module, "completed", noted)
    study = harmful_study(tmp_path, ["raise", "none"])
    table = load(run_study(study, tmp_path, scheduler=address).store).table()
    assert table["status"].tolist() == ["failed", "done"] * 3
    first, *others = table["id"].tolist()
    assert asked == [(coordinator, first), (coordinator, "base-0"), *((running, other) for other in others)]


def test_a_first_run_whose_worker_ended_may_be_innocent_and_is_run_again(address, tmp_path, monkeypatch):
    class KilledWorker(Exception):
        pass

    whole = coordinator.completed

    def completed(client, tasks, *given):
        tasks = list(tasks)
        pilots = [Done(each.id, None, KilledWorker()) for each in tasks if not each.id.startswith("base")]
        yield from [pilots] if pilots else whole(client, iter(tasks), *given)

    monkeypatch.setattr(coordinator, "completed", completed)
    summary = run_study(read_study(write_study(tmp_path, LATENCIES)), tmp_path, scheduler=address)
    assert summary.failed == {}
    assert summary.done == summary.runs


def test_a_worker_whose_disk_is_full_ends_the_study_and_costs_no_result(address, tmp_path):
    study = harmful_study(tmp_path, ["none", "full"])
    with pytest.raises(RunError, match=r"a worker's disk is full \(.*No space left.*; make room, and start"):
        run_study(study, tmp_path, scheduler=address)
    table = load(tmp_path / "tiny").table()
    assert set(table["status"]) <= {"done"}
    assert set(table["deed"]) <= {"none"}


def test_a_recording_for_which_there_is_no_room_is_no_result(crossed, tmp_path, monkeypatch):
    study, _ = crossed
    experiment = load_experiment("finger_pid_latency", study.about.settings)

    def full(source, target):
        Path(target).touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(worker.shutil, "move", full)
    document = zlib.compress(experiment.as_json().encode())
    came = worker.run_one("a", document, 1, worker.ResultSpec(study.metrics, "all", str(tmp_path / "kept")))
    assert came.status == worker.NO_ROOM
    assert came.recording == ""
    assert list((tmp_path / "kept").iterdir()) == []


@pytest.mark.slow
def test_what_cells_need_is_prepared_once_for_each_patient_and_again_if_it_failed(
        address, tmp_path, monkeypatch):
    monkeypatch.setattr(coordinator, "prepare_one", prepared_or_not)
    told = Path(os.environ["STUDY_BLOCKS"])
    study = read_study(write_study(
        tmp_path, '[axes.strength]\nkey = "blocks.finger.strength"\nvalues = [1.0, 1.2]\n'
        "[axes.move_weight]\nvalues = [0.05, 0.1]\n", experiment="grasp_mpc", duration_s=1.0,
        settings=["plant=finger", "experiment.trials=1"], metrics='error_deg = "joint_rmse_deg"',
        more='[prepare.model]\nexperiment = "identify_grasp"\nsettings = ["plant=finger"]\n'
        'axes = ["strength"]\n'))
    (told / "fails").touch()
    summary = run_study(study, tmp_path, scheduler=address)
    assert (summary.done, summary.failed) == (0, {"identify_grasp: no force was seen": 4})
    summary = run_study(study, tmp_path, scheduler=address, retry_failed=True)
    assert (summary.done, summary.failed) == (0, {"identify_grasp: no force was seen": 4})
    (told / "fails").unlink()
    assert run_study(study, tmp_path, scheduler=address).done == 0
    summary = run_study(study, tmp_path, scheduler=address, retry_failed=True)
    assert (summary.done, summary.failed) == (4, {})
    ids = [path.name.partition("-")[0] for path in told.glob("*.prepared")]
    assert sorted(ids) == sorted(3 * list(set(ids)))
    assert len(set(ids)) == 2
    before = load(summary.store).digest()
    assert load(run_study(study, tmp_path, scheduler=address).store).digest() == before
    assert len(list(told.glob("*.prepared"))) == 6


@pytest.mark.slow
def test_what_is_prepared_is_the_model_that_identifying_gives(tmp_path):
    experiment = load_experiment("identify_grasp", ["plant=finger"], 3)
    came = prepare_one("a", zlib.compress(experiment.as_json().encode()), 3)
    assert (came.id, came.status, came.cause) == ("a", "done", "")
    with one_blas_thread():
        identifier()(str(run(experiment, tmp_path).recording)).model.save(tmp_path / "model.toml")
    assert came.content == (tmp_path / "model.toml").read_text()
    nothing = load_experiment("finger_pid_latency", ["experiment.duration_s=0.3", "score.after_s=0.1"], 3)
    came = prepare_one("b", zlib.compress(nothing.as_json().encode()), 3)
    assert came.status == "failed"
    assert came.cause
    assert came.content == ""


def test_a_model_that_explains_too_little_fails_the_preparation(monkeypatch):
    poor = replace(load_patient_model(Path("grasp_finger")), fit={"free_run": {"MCP": 10.0}})
    monkeypatch.setattr(preparing, "identifier", lambda: lambda path: SimpleNamespace(model=poor))
    experiment = load_experiment("finger_pid_latency", ["experiment.duration_s=0.3", "score.after_s=0.1"])
    came = prepare_one("a", zlib.compress(experiment.as_json().encode()), 3)
    assert (came.status, came.content) == ("failed", "")
    assert "the model explains too little: the free run of MCP has a fit of 10.0 %" in came.cause


@pytest.mark.parametrize("address_", ["tcp://127.0.0.1:1", "nonsense", "http://127.0.0.1:1", "tls://127.0.0.1:1"])
def test_an_address_at_which_no_scheduler_is_is_named(monkeypatch, address_):
    monkeypatch.setattr(cluster, "_CONNECT_S", 1.0)
    with pytest.raises(InputError, match=f"--scheduler {address_}: no Dask scheduler answers there"), \
            connected(None, address_):
        pass


def test_two_studies_on_one_scheduler_do_not_share_tasks(address):
    """They may want other metrics of the same run."""
    def outcomes(value):
        several = completed(client, iter([Task("a", slowly, (value,))]))
        return [each.outcome for some in several for each in some]

    with connected(None, address) as client, ThreadPoolExecutor() as both:
        assert list(both.map(outcomes, [1, 2])) == [[1], [2]]


class LosesOnce:
    """A client to whom the first outcome that it fetches is lost, as with a worker."""

    def __init__(self, client):
        self._client, self.fetched = client, 0

    def __getattr__(self, name):
        return getattr(self._client, name)

    async def gather(self, futures, errors):
        self.fetched += 1
        if self.fetched == 1:
            return dict.fromkeys(futures)
        return await self._client.gather(futures, errors=errors)


@pytest.mark.slow
def test_an_outcome_that_is_lost_with_its_worker_is_waited_for(address):
    with connected(None, address) as client:
        losing = LosesOnce(client)
        (done,) = (each for some in completed(losing, iter([Task("a", abs, (-3,))])) for each in some)
    assert (done.id, done.outcome, losing.fetched) == ("a", 3, 2)


class LosesWorkers(LosesOnce):
    """A client whose cluster's only worker is gone, with its process, as it fetches first."""

    async def gather(self, futures, errors):
        self.fetched += 1
        if self.fetched == 1:
            for worker_ in self._client.cluster.workers.values():
                await worker_.close()
        return await self._client.gather(futures, errors=errors)


@pytest.mark.slow
def test_workers_compute_on_one_thread_and_keep_their_memory(monkeypatch):
    for name in ("MALLOC_TRIM_THRESHOLD_", "OMP_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    with connected(1, None) as client:
        (found,) = client.run(lambda: dict(os.environ)).values()
    assert "MALLOC_TRIM_THRESHOLD_" not in found  # Dask's own: a run takes a fifth longer with it
    assert [found[f"{name}_NUM_THREADS"] for name in ("OMP", "MKL", "OPENBLAS")] == ["1"] * 3


@pytest.mark.slow
def test_an_outcome_that_is_lost_with_the_only_worker_is_had_of_another_one(monkeypatch):
    """Dask alone waits without end: nothing else starts a worker while it fetches."""
    monkeypatch.setattr("fesloop.analysis.study.engine.tasks._FETCH_S", 3.0)
    with connected(1, None) as client:
        losing = LosesWorkers(client)
        (done,) = (each for some in completed(losing, iter([Task("a", abs, (-3,))])) for each in some)
    assert (done.id, done.outcome) == ("a", 3)
    assert losing.fetched >= 2


@pytest.mark.slow
def test_memory_does_not_grow_with_tasks_that_are_not_under_way(address):
    """Tasks are drawn as they are needed: ten batches for each of the cluster's two threads, and no more."""
    drawn = []

    def tasks():
        for number in range(1500):
            drawn.append(number)
            yield Task(f"n{number}", abs, (number + 1,))

    with connected(None, address) as client:
        done = 0
        for some in completed(client, tasks()):
            assert len(drawn) - done <= 20 * 32
            done += len(some)
    assert done == len(drawn) == 1500


@pytest.mark.slow
def test_tasks_left_over_by_a_worker_whose_batch_takes_long_are_done_once(address):
    """Short tasks make large batches, which the long ones after them do not end in time."""
    tasks = [Task(f"{number}", waited, (number, 0.0 if number < 100 else 0.15)) for number in range(132)]
    with connected(None, address) as client:
        done = [each for some in completed(client, iter(tasks)) for each in some]
    assert sorted((int(each.id), each.outcome) for each in done) == [(each, (each,)) for each in range(132)]


@given(st.lists(st.integers(1, 9), min_size=1, max_size=20), st.integers(1, 60))
def test_no_task_of_a_batch_begins_after_its_time(lengths, most):
    """By a clock that only tasks move on."""
    clock = [0.0]

    def task(length):
        clock[0] += length
        return length

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tasks_module, "_BATCH_S", most + 0.5)
        patch.setattr(tasks_module, "time", SimpleNamespace(perf_counter=lambda: clock[0]))
        outcomes, took_s = tasks_module._in_turn([task] * len(lengths), [(each,) for each in lengths])
    assert outcomes == lengths[:len(outcomes)]
    assert took_s == sum(outcomes)
    assert sum(outcomes[:-1]) < most + 0.5
    assert len(outcomes) == len(lengths) or took_s > most


def test_a_plan_that_is_known_is_compared_by_cells_with_every_level(tmp_path):
    study = read_study(write_study(
        tmp_path, '[axes.latency_ms]\nvalues = [0, 10, 20]\n[axes.strength]\nkey = "blocks.finger.strength"\n'
        "values = [1.0, 1.1, 1.2, 1.3]\n"))
    whole, few = (list(plan(study, meanwhile(study), known=known)) for known in (False, True))
    assert (len(whole), len(few)) == (12, 6)
    assert {(name, level) for each in few for name, level in each.cell.levels.items()} == {
        (name, level) for each in whole for name, level in each.cell.levels.items()}
    assert all(each == whole[each.cell.number] for each in few)
