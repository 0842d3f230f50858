"""FMUs in a process of their own: what they do there costs the run one line, and nothing else."""

import copy
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError, RunError
from fesloop.loop.block import Context
from plants.fmu import Fmu
from plants.fmu.process import IsolatedFmu
from plants.fmu.running import RunningFmu

MISDEEDS = {
    "raise(SIGSEGV)": "was killed by SIGSEGV",
    "abort()": "was killed by SIGABRT",
    "exit(0)": "ended by itself with exit code 0",
    '{ fprintf(stderr, "out of cheese\\n"); _exit(7); }': "ended by itself with exit code 7, out of cheese",
    "for (;;)": "did not finish within 1 s",
    "for (char *p;; memset(p, 1, 1 << 20)) p = malloc(1 << 20)": "was killed by SIGSEGV (it used "}
EXPERIMENT = """
[experiment]
name = "alone"
duration_s = 2

[blocks.plant]
kind = "fmu"
path = "{path}"
step_rate = "100"

[[wires]]
from = "plant.y"
to = "plant.u"
rate = "100"
latency_ms = 10

[record]
plant_rate = "100"
"""


def fesloop(folder, *arguments):
    """A run of the program in a folder."""
    return subprocess.run([sys.executable, "-m", "fesloop", *arguments], cwd=folder, capture_output=True,
                          text=True, check=False, env={**os.environ, "PYTHONPATH": ":".join(sys.path)})


def has_ended(pid):
    """Whether a process is no more, or nothing but its exit code."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


@pytest.mark.slow
@pytest.mark.parametrize("misdeed", MISDEEDS)
def test_a_misdeed_in_mid_run_is_an_error_of_the_run(small2, misdeed):
    fmu = small2("AT_S=1.25", f"MISDEED={misdeed}")
    plant = Fmu(path=str(fmu), step_rate="100", probe_timeout_s=6.0, step_timeout_s=1.0, memory_mb=200)
    state = plant.init(Context("node"))
    pid = state.running._process._process.pid
    for _ in range(125):
        plant.advance(state, [1.0], 0, 0)
    assert plant.read(state, [])[1] == 125
    words = re.escape(f"node: in the step from 1.25 s small.fmu {MISDEEDS[misdeed]}")
    with pytest.raises(RunError, match=f"^{words}"):
        plant.advance(state, [1.0], 0, 0)
    assert has_ended(pid)
    plant.close(state)


@pytest.mark.slow
def test_a_crash_costs_the_run_one_line_and_no_row(small2, tmp_path):
    fmu = small2("AT_S=1.25", "MISDEED=raise(SIGSEGV)", "PRINTS")
    (tmp_path / "alone.toml").write_text(EXPERIMENT.format(path=fmu))
    done = fesloop(tmp_path, "run", "alone.toml", "--json")
    told = json.loads(done.stdout)
    cause = "plant: in the step from 1.25 s small.fmu was killed by SIGSEGV, stderr at 1.25 s"
    assert (done.returncode, told["status"], told["cause"]) == (1, "failed", cause)
    assert cause in done.stderr
    assert "Traceback" not in done.stderr
    with h5py.File(tmp_path / told["recording"]) as file:
        np.testing.assert_array_equal(file["plants/plant"]["steps"], np.arange(126))


@pytest.mark.slow
@pytest.mark.parametrize("definition", ["CRASH_AT_LOAD", "CRASH_IN_INSTANTIATION", "CRASH"])
def test_a_crash_before_the_first_step_is_found_by_check(small2, tmp_path, definition):
    (tmp_path / "alone.toml").write_text(EXPERIMENT.format(path=small2(definition)))
    done = fesloop(tmp_path, "check", "alone.toml", "--json")
    assert done.returncode == 2
    assert "small.fmu: in initialisation it was killed by SIGSEGV" in json.loads(done.stdout)["faults"][0]


@pytest.mark.slow
def test_a_crash_at_the_end_is_told_and_all_is_recorded(small2, tmp_path):
    (tmp_path / "alone.toml").write_text(EXPERIMENT.format(path=small2("CRASH_AT_END")))
    done = fesloop(tmp_path, "run", "alone.toml", "--json")
    told = json.loads(done.stdout)
    assert (done.returncode, told["status"]) == (1, "failed")
    assert "plant: in its end, after all its steps small.fmu was killed by SIGSEGV" in told["cause"]
    with h5py.File(tmp_path / told["recording"]) as file:
        np.testing.assert_array_equal(file["plants/plant"]["steps"], np.arange(200))


@pytest.mark.slow
def test_a_state_that_is_dropped_crashes_unseen(small2):
    plant = Fmu(path=str(small2("CRASH_AT_END")), step_rate="100")
    state = plant.init(Context("plant"))
    pid = state.running._process._process.pid
    del state
    assert has_ended(pid)


def test_a_clean_run_ends_the_process(small2, capfd):
    plant = Fmu(path=str(small2("PRINTS")), step_rate="100")
    state = plant.init(Context("plant"))
    pid = state.running._process._process.pid
    plant.advance(state, [1.0], 0, 0)
    assert not has_ended(pid)
    plant.close(state)
    plant.close(state)
    assert has_ended(pid)
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_what_is_printed_without_end_does_not_hold_up_the_run(small2):
    flood = 'for (int i = 0; i < 9000; i++) fprintf(stderr, "a line, nine thousand times a step\\n")'
    plant = Fmu(path=str(small2("AT_S=0", f"MISDEED={flood}")), step_rate="100")
    state = plant.init(Context("plant"))
    for _ in range(10):
        plant.advance(state, [1.0], 0, 0)
    plant.close(state)


@pytest.mark.slow
@pytest.mark.parametrize("misdeed", ["for (;;)", "(void)0"])
def test_the_process_ends_with_one_that_is_killed(small2, tmp_path, misdeed):
    fmu = small2("AT_S=0.5", f"MISDEED={misdeed}")
    script = tmp_path / "script.py"
    script.write_text(f"""
import itertools
from fesloop.loop.block import Context
from plants.fmu import Fmu
plant = Fmu(path={str(fmu)!r}, step_rate="100", probe_timeout_s=4, step_timeout_s=3600)
state = plant.init(Context("plant"))
for step in itertools.count():
    if step == 50:
        print(state.running._process._process.pid, flush=True)
    plant.advance(state, [1.0], 0, 0)
""")
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True,
                          env={**os.environ, "PYTHONPATH": ":".join(sys.path)}) as parent:
        pid = int(parent.stdout.readline())
        busy = worked_s(pid) + 0.2
        wait(lambda: worked_s(pid) > busy)
        parent.send_signal(signal.SIGKILL)
    try:
        wait(lambda: has_ended(pid))
    finally:
        if not has_ended(pid):
            os.kill(pid, signal.SIGKILL)


def worked_s(pid):
    """Processor time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return int(fields[11]) / os.sysconf("SC_CLK_TCK")


def wait(holds):
    deadline = time.monotonic() + 120
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.fixture(scope="module")
def pairs(small2, small3, finger_fmu):
    """Plants of several kinds, isolated and not."""
    kinds = [{"path": str(small2())}, {"path": str(small3())},
             {"path": str(finger_fmu), "interface": "model_exchange"}]
    isolated = [Fmu(**kind, step_rate="100") for kind in kinds]
    shared = [copy.copy(plant) for plant in isolated]
    for plant in shared:
        object.__setattr__(plant, "isolate", False)
    return list(zip(isolated, shared, strict=True))


@pytest.mark.slow
@settings(max_examples=5, deadline=None)
@given(kind=st.integers(0, 2), seed=st.integers(0, 2**32), steps=st.integers(1, 60), data=st.data())
def test_isolated_or_not_every_bit_is_the_same(pairs, kind, seed, steps, data):
    saved_at = data.draw(st.integers(0, steps))
    isolated, shared = (driven(plant, seed, steps, saved_at) for plant in pairs[kind])
    assert isolated == shared


def driven(plant, seed, steps, saved_at):
    """Bytes of all outputs under random inputs, from `saved_at` on by a copy of the state."""
    rng = np.random.default_rng(seed)
    state, rows, inputs = plant.init(Context("plant")), [], None
    for step in range(steps):
        if step == saved_at:
            before, state = state, copy.deepcopy(state)
            plant.close(before)
        if inputs is None or rng.random() < 0.3:
            inputs = [rng.uniform(0, 0.02, port.shape) if port.shape else rng.uniform(0, 0.02)
                      for port in plant.inputs]
        plant.advance(state, inputs, 0, 0)
        rows.append([np.asarray(value).tobytes() for value in plant.read(state, inputs)])
    plant.close(state)
    return rows


@pytest.mark.slow
def test_nothing_that_a_file_says_makes_it_ours(finger_fmu):
    for path, kind in ((str(finger_fmu), IsolatedFmu), ("shipped:finger", RunningFmu)):
        plant = Fmu(path=path)
        state = plant.init(Context("plant"))
        assert type(state.running) is kind
        plant.close(state)


@pytest.mark.parametrize(
    ("name", "value"), [("memory_mb", 0), ("step_timeout_s", 0.0), ("step_timeout_s", 1e-6),
                        ("step_timeout_s", 1e9)])
def test_limits_have_limits(small2, name, value):
    with pytest.raises(InputError, match=f"^{name}: "):
        Fmu(path=str(small2()), **{name: value})
