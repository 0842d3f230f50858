"""Studies small enough for tests, and the processes in which they are run."""

import json
import os
import signal
import subprocess
import sys
from importlib import resources
from pathlib import Path

TESTS = Path(__file__).resolve().parent
FINGER = "finger_pid_latency"
ENTRY_POINTS = "[fesloop.blocks]\nharmful = study_blocks:Harmful\n"
METADATA = "Metadata-Version: 2.1\nName: study-blocks\nVersion: 1.0\n"


def write_study(folder, axes, name="tiny", experiment=FINGER, settings=(), more="", duration_s=0.3,
                metrics='error_deg = "joint_rmse_deg", seen_deg = "tracker_rmse_deg"', **about):
    """Path of a study file; `axes` and `more` are text of it, `about` goes into its table [study]."""
    settings = [f"experiment.duration_s={duration_s}", "score.after_s=0.1", *settings]
    lines = [f"{key} = {json.dumps(value)}" for key, value in about.items()]
    path = folder / f"{name}.toml"
    path.write_text(f'[study]\nname = "{name}"\nexperiment = "{experiment}"\nmetrics = {{ {metrics} }}\n'
                    f"settings = {json.dumps(settings)}\n" + "\n".join([*lines, axes, more]))
    return path


def harmful_experiment(folder):
    """An experiment beside a study, a block of which does harm if it is told to."""
    finger = resources.files("fesloop.experiment") / "shipped" / f"{FINGER}.toml"
    text = finger.read_text(encoding="utf-8").replace("[[wires]]", HARMFUL + "[[wires]]", 1)
    (folder / "harmful.toml").write_text(text)
    return "harmful.toml"


HARMFUL = '[blocks.harmful]\nkind = "harmful"\nrate = "10"\n\n'


def with_harmful_blocks(folder):
    """Environment of processes that know the kind `harmful`."""
    installed = folder / "installed" / "study_blocks-1.0.dist-info"
    installed.mkdir(parents=True, exist_ok=True)
    (installed / "METADATA").write_text(METADATA)
    (installed / "entry_points.txt").write_text(ENTRY_POINTS)
    paths = [str(installed.parent), str(TESTS), str(TESTS.parent), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}


def started(study, out, *arguments, env=None, **popen):
    """A process of `fesloop study --json`."""
    return subprocess.Popen(
        [sys.executable, "-m", "fesloop", "study", str(study), "--out", str(out), "--json", *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env, cwd=Path(out).parent,
        preexec_fn=_hear_interrupts, **popen)


def _hear_interrupts():
    """Tests that a shell runs in the background ignore Ctrl-C, and what they start would as well."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def told(study, out, *arguments, env=None):
    """(exit code, the object on standard output or None, standard error) of `fesloop study --json`."""
    with started(study, out, *arguments, env=env) as process:
        text, errors = process.communicate(timeout=120.0)
    assert "Traceback" not in errors
    return process.returncode, json.loads(text) if text else None, errors
