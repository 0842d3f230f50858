import copy
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from fesloop.analysis.study import load
from fesloop.analysis.study.design.cells import Cell
from fesloop.analysis.study.design.plan import PlannedCell, PlannedRun
from fesloop.analysis.study.design.study_file import study_of
from fesloop.analysis.study.store import writing as store_writing
from fesloop.analysis.study.store.writing import Store, StoredResult
from fesloop.errors import InputError, InputErrors, RunError


def a_study(**about):
    return study_of({"study": {"name": "kept", "experiment": "finger_pid_latency",
                               "metrics": {"error_deg": "joint_rmse_deg"}, "replicates": 2, **about},
                     "axes": {"latency_ms": {"values": [0, 20, 40]}}})


def a_plan(ids=("a", "b", "c"), causes=("", "", "")):
    """Three cells of two replicates."""
    for number, (id_, cause) in enumerate(zip(ids, causes, strict=True)):
        cell = Cell(number=number, levels={"latency_ms": 20 * number}, experiment="finger_pid_latency",
                    common=(), by_axis={})
        runs = tuple(PlannedRun(number, r, 1 + r, f"{id_}{r}") for r in range(2))
        yield PlannedCell(cell, "" if cause else "{}", runs, 0.5, cause)


def result(id_, value=1.0, status="done", cause=""):
    return StoredResult(id=id_, status=status, cause=cause,
                        metrics={"error_deg": value} if status == "done" else {}, wall_s=0.1, worker="here")


def rows(folder):
    """{id: (status, metrics)} as they stand in the file."""
    with closing(sqlite3.connect(folder / "study.sqlite")) as file:
        assert file.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        return {id_: tuple(rest) for id_, *rest in file.execute("SELECT id, status, metrics FROM results")}


@pytest.fixture
def folder(tmp_path):
    """Of a store of six runs, one of which is done and one failed."""
    with Store(tmp_path / "kept", a_study()) as kept:
        assert kept.put_plan(a_plan()) == 3.0
        kept.put([result("a0"), result("a1", status="failed", cause="broken")])
    return tmp_path / "kept"


def test_a_result_is_there_once_and_stays_as_it_was_first(folder):
    with Store(folder, a_study()) as kept:
        kept.put([result("a0", 7.0), result("b0", 2.0)])
        kept.put([result("b0", 8.0)])
        assert kept.counts() == (2, {"broken": 1})
    assert rows(folder)["a0"] == ("done", '{"error_deg": 1.0}')
    assert rows(folder)["b0"] == ("done", '{"error_deg": 2.0}')


def test_only_a_failed_result_is_replaced_and_only_by_running_it_again(folder):
    with Store(folder, a_study()) as kept:
        assert [id_ for _, _, id_ in kept.pending()] == ["b0", "b1", "c0", "c1"]
        assert [id_ for _, _, id_ in kept.pending(retry_failed=True)] == ["a1", "b0", "b1", "c0", "c1"]
        kept.put([result("a1", 3.0)])
        assert kept.counts() == (2, {})
        kept.put([result("a1", status="failed", cause="too late")])
        assert kept.counts() == (2, {})


def test_cells_that_share_a_run_wait_for_it_once(tmp_path):
    with Store(tmp_path, a_study()) as kept:
        kept.put_plan(a_plan(("a", "b", "a")))
        assert list(kept.pending()) == [(0, 1, "a0"), (0, 2, "a1"), (1, 1, "b0"), (1, 2, "b1")]
        assert kept.distinct_runs() == 4
        kept.put([result("a0")])
    assert load(tmp_path).table()["cell"].tolist() == [0, 2]


def test_a_transaction_is_whole_or_not_at_all(folder):
    before = rows(folder)
    with Store(folder, a_study()) as kept:
        broken = StoredResult(id="b1", status="done", cause="", metrics={}, wall_s=object(), worker="")
        with pytest.raises(RunError, match="earlier results are kept"):
            kept.put([result("b0"), broken])
        assert rows(folder) == before
        kept.put([result("b0")])
    assert rows(folder).keys() - before == {"b0"}


KILLED = """
import os, signal, sys
from test_store import Path, Store, a_plan, a_study, result
kept = Store(Path(sys.argv[1]), a_study())
if sys.argv[2] == "plan":
    def plan():
        yield from list(a_plan())[:2]
        os.kill(os.getpid(), signal.SIGKILL)
    kept.put_plan(plan())
if sys.argv[2] == "put":
    kept._file.execute("PRAGMA cache_size = 1")
    with kept._transaction():
        kept._put([result("b0")] + [result(f"more {i}") for i in range(3000)])
        os.kill(os.getpid(), signal.SIGKILL)
os.kill(os.getpid(), signal.SIGKILL)
"""


def killed(folder, when):
    paths = [str(Path(__file__).parents[i]) for i in (0, 1, 3)]
    done = subprocess.run([sys.executable, "-c", KILLED, str(folder), when], check=False,
                          env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)})
    assert done.returncode == -signal.SIGKILL


@pytest.mark.slow
def test_a_coordinator_killed_within_a_commit_leaves_the_store_as_before(folder):
    before = (folder / "study.sqlite").read_bytes()
    killed(folder, "put")
    assert (folder / "study.sqlite-journal").stat().st_size > 0
    assert (folder / "study.sqlite").read_bytes() != before
    with Store(folder, a_study()) as kept:
        assert kept.counts() == (1, {"broken": 1})
        assert len(list(kept.pending())) == 4
        kept.put([result("b0")])
    assert sorted(rows(folder)) == ["a0", "a1", "b0"]


@pytest.mark.slow
@pytest.mark.parametrize("when", ["start", "plan"])
def test_one_killed_before_it_had_a_plan_is_followed_by_any(tmp_path, when):
    killed(tmp_path, when)
    with Store(tmp_path, a_study(replicates=2, description="another")) as kept:
        kept.put_plan(a_plan())
        assert kept.distinct_runs() == 6


def test_two_coordinators_are_never_at_one_store(folder):
    with Store(folder, a_study()) as kept:
        with pytest.raises(InputError, match="another fesloop study is writing there; allowed: one at"):
            Store(folder, a_study())
        kept.put([result("b0")])
    with Store(folder, a_study()) as kept:
        assert kept.counts()[0] == 2


def test_a_store_of_another_study_is_refused_and_says_what_differs(folder):
    before = (folder / "study.sqlite").read_bytes()
    with pytest.raises(InputError, match=r"made by another study: study\.seed is null there, 4 here"):
        Store(folder, a_study(seed=4))
    with pytest.raises(InputError, match=r"study\.metrics\.error_deg is .joint_rmse_deg. there, .tracker"):
        Store(folder, a_study(metrics={"error_deg": "tracker_rmse_deg"}))
    assert (folder / "study.sqlite").read_bytes() == before


def test_a_study_with_other_figures_goes_on_and_is_reported_with_them(folder, monkeypatch):
    figure = {"name": "error", "kind": "curves", "metric": "error_deg", "x": "latency_ms"}
    drawn = study_of(a_study().document | {"figures": [figure]})
    (folder / "theory.json").write_text("lines over other figures")
    monkeypatch.setattr(store_writing, "version_text", lambda: "{}")
    with pytest.raises(InputError, match="another version"):
        Store(folder, drawn)
    assert "figures" not in load(folder).study
    monkeypatch.undo()
    with Store(folder, drawn) as kept:
        assert kept.counts() == (1, {"broken": 1})
    assert load(folder).study["figures"] == [figure]
    assert not (folder / "theory.json").exists()
    with Store(folder, a_study()):
        pass
    assert load(folder).study == dict(a_study().document)


def test_a_study_that_is_described_in_other_words_goes_on(folder):
    document = dict(a_study().document)
    axes = {name: {**axis, "label": "delay", "unit": "ms"} for name, axis in document["axes"].items()}
    about = {**document["study"], "description": "In other words."}
    said = study_of({**document, "study": about, "axes": axes})
    with Store(folder, said) as kept:
        assert kept.counts() == (1, {"broken": 1})
    assert load(folder).study == dict(said.document)


def test_a_store_of_another_version_is_refused_until_it_is_asked_for(folder, monkeypatch):
    here = store_writing.version_text()
    other = here.replace('"numpy": "', '"numpy": "9')
    assert other != here
    monkeypatch.setattr(store_writing, "version_text", lambda: other)
    with pytest.raises(InputError, match=r"another version: numpy \S+ there, 9\S+ here;.*--mix-versions"):
        Store(folder, a_study())
    with Store(folder, a_study(), mix_versions=True) as kept:
        kept.put([result("b0")])
    with closing(sqlite3.connect(folder / "study.sqlite")) as file:
        found = dict(file.execute("SELECT id, version FROM results"))
        texts = [text for (text,) in file.execute("SELECT text FROM versions ORDER BY version")]
    assert texts[found["a0"]] == here
    assert texts[found["b0"]] == other


def test_a_store_whose_base_experiment_has_changed_is_refused(folder):
    with Store(folder, a_study()) as kept:
        with pytest.raises(InputError, match=r"_latency was another experiment \(seen at latency_ms 20"):
            kept.put_plan(a_plan(("a", "x", "c")))
        kept.put_plan(a_plan())
        assert [id_ for _, _, id_ in kept.pending()] == ["b0", "b1", "c0", "c1"]


@pytest.mark.parametrize(("change", "told"), [
    (("patient", "drawn", "strength"), "what has changed is the patient file '/there/anna.toml'"),
    (("patient", "file"), "the first key that has changed is patient.file"),
    (("blocks", "pid", "kp"), "the first key that has changed is blocks.pid.kp"),
    (("blocks", "fourth"), "the first key that has changed is blocks.fourth")])
def test_the_refusal_says_what_of_the_experiment_has_changed(tmp_path, change, told):
    """A patient's parameters are under its blocks too: the file is what a user has changed."""
    then = {"experiment": {"seed": 1}, "blocks": {"pid": {"kp": [1.0]}, "muscles": {"strength": 1.0}},
            "patient": {"file": "/there/anna.toml", "drawn": {"strength": 1.0}}}
    now = copy.deepcopy(then) | {"experiment": {"seed": 5}}
    if change[0] == "patient":
        now["blocks"]["muscles"]["strength"] = 2.0
    table = now
    for key in change[:-1]:
        table = table[key]
    table[change[-1]] = 2.0

    def planned(ids, document):
        return [replace(each, document=json.dumps(document)) for each in a_plan(ids)]

    with Store(tmp_path, a_study()) as kept:
        kept.put_plan(planned("abc", then))
        with pytest.raises(InputError, match="was another experiment") as refused:
            kept.put_plan(planned("axc", now))
    assert told in str(refused.value)


def test_a_model_that_is_prepared_again_takes_the_place_of_the_first(folder):
    with Store(folder, a_study()) as kept:
        kept.put_prepared("m", "model", "failed", "no force", "")
        kept.put_prepared("m", "model", "done", "", "text")
    with Store(folder, a_study()) as kept:
        assert kept.prepared() == {"m": ("done", "", "text")}
    assert load(folder).planned == 6


def test_a_plan_with_faults_leaves_the_store_without_one(tmp_path):
    def faulty():
        yield from a_plan()
        raise InputErrors([InputError("a", "b")])

    with Store(tmp_path, a_study()) as kept:
        with pytest.raises(InputErrors):
            kept.put_plan(faulty())
        assert kept.distinct_runs() == 0
    with Store(tmp_path, a_study(seed=3)) as kept:
        kept.put_plan(a_plan())
        assert kept.distinct_runs() == 6


def test_cells_that_could_not_be_prepared_are_failed_and_take_their_runs_when_they_can(tmp_path):
    with Store(tmp_path, a_study()) as kept:
        kept.put_plan(a_plan(("a", "none", "c"), ("", "no force", "")))
        assert kept.counts() == (0, {"no force": 2})
        assert kept.not_prepared() == {"no force": 2}
        assert [id_ for _, _, id_ in kept.pending(retry_failed=True)] == ["a0", "a1", "c0", "c1"]
        kept.put([result("a0")])
        kept.put_plan(a_plan())
        assert kept.counts() == (1, {})
        assert [id_ for _, _, id_ in kept.pending()] == ["a1", "b0", "b1", "c0", "c1"]


@pytest.mark.parametrize("content", [b"latency, error\n" * 300, b"SQLite format 3\0" + b"x" * 5000])
def test_a_file_of_something_else_is_refused_and_left_alone(tmp_path, content):
    (tmp_path / "study.sqlite").write_bytes(content)
    with pytest.raises(InputError, match="not a study of fesloop"):
        Store(tmp_path, a_study())
    assert (tmp_path / "study.sqlite").read_bytes() == content


@pytest.mark.parametrize("tables", ["birds(name)", "about(name)", "about(key, value)", "results(id)"])
def test_a_database_of_something_else_is_refused_and_left_alone(tmp_path, tables):
    with closing(sqlite3.connect(tmp_path / "study.sqlite")) as file, file:
        file.execute(f"CREATE TABLE {tables}")
    before = (tmp_path / "study.sqlite").read_bytes()
    with pytest.raises(InputError, match="not a study of fesloop"):
        Store(tmp_path, a_study())
    assert (tmp_path / "study.sqlite").read_bytes() == before


def test_a_store_that_is_damaged_under_way_is_named_as_such(folder):
    def read_on():
        with Store(folder, a_study()) as kept:
            kept.path.write_bytes(os.urandom(kept.path.stat().st_size))
            list(kept.pending())

    with pytest.raises(RunError, match=r"study\.sqlite: cannot be read any more: .*(malformed|not a data)"):
        read_on()


def test_a_folder_that_cannot_be_is_named(tmp_path):
    (tmp_path / "file").touch()
    for path, fault in ((tmp_path / "file" / "kept", "Not a directory"), (tmp_path / "file", "File exists"),
                        (Path("/proc/fesloop/kept"), "No such file")):
        with pytest.raises(InputError, match=rf"--out \S+: cannot be written to: {fault}"):
            Store(path, a_study())


def test_a_store_without_room_keeps_what_it_has_and_goes_on_when_there_is_some(folder):
    before = rows(folder)
    with Store(folder, a_study()) as kept:
        pages = kept._file.execute("PRAGMA page_count").fetchone()[0]
        kept._file.execute(f"PRAGMA max_page_count = {pages}")
        with pytest.raises(RunError, match="the disk is full; earlier results are kept"):
            kept.put([result(f"more {i}") for i in range(2000)])
        assert rows(folder) == before
        kept._file.execute(f"PRAGMA max_page_count = {10 * pages}")
        kept.put([result("b0")])
    assert len(rows(folder)) == len(before) + 1


ON_A_SMALL_DISK = """
import os, sys
from test_store import InputError, Path, RunError, Store, a_plan, a_study, result
disk = Path(sys.argv[1])
with Store(disk / "kept", a_study()) as kept:
    kept.put_plan(a_plan())
    kept.put([result("a0")])
    with (disk / "ballast").open("wb", buffering=0) as ballast:
        try:
            while True:
                ballast.write(bytes(4096))
        except OSError:
            pass
    try:
        kept.put([result(f"more {i}") for i in range(2000)])
    except RunError as fault:
        print(fault)
    print(kept.counts())
try:
    Store(disk / "kept", a_study())
except InputError as fault:
    print(fault)
(disk / "ballast").unlink()
with Store(disk / "kept", a_study()) as kept:
    kept.put([result("b0")])
    print(kept.counts())
os.system(f"mount -o remount,ro {disk}")
for name in ("kept", "new"):
    try:
        Store(disk / name, a_study())
    except InputError as fault:
        print(fault)
"""


def test_on_a_full_disk_and_a_read_only_one_the_fault_is_named_and_nothing_is_lost(tmp_path):
    paths = [str(Path(__file__).parents[i]) for i in (0, 1, 3)]
    mount = f"mount -t tmpfs -o size=20m none {tmp_path}"
    if subprocess.run(["unshare", "-rm", "sh", "-c", mount], capture_output=True, check=False).returncode:
        pytest.skip("this machine lets nobody mount a disk of their own")
    there = f'{mount} && "$0" -c "$1" {tmp_path}'
    done = subprocess.run(
        ["unshare", "-rm", "sh", "-c", there, sys.executable, ON_A_SMALL_DISK],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)}, capture_output=True, text=True, check=False)
    full, counts, start, after, read_only, new = done.stdout.splitlines()
    assert "study.sqlite: the disk is full; earlier results are kept; make room" in full
    assert counts == "(1, {})"
    assert "the disk is full, 0 MB are left; allowed: a folder that can be written to" in start
    assert after == "(2, {})"
    assert "cannot be written to" in read_only
    assert "cannot be written to: Read-only file system" in new
    assert shutil.disk_usage(tmp_path).total > 2**26
