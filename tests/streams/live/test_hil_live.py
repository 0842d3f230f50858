"""The shipped experiment `hil_live`, with its sensors in a second process as a user has them (some 25 s)."""

import json
import subprocess
import sys
import time
from importlib.resources import files

import numpy as np
import pytest

pytest.importorskip("pylsl", reason="pylsl is not installed")

import fesloop
from fesloop import Recording
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.experiment.moving_hand import moving_hand
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_MS, NS_PER_S

pytestmark = pytest.mark.realtime


@pytest.fixture
def sender():
    """Starts `fesloop stream hand` with options, and ends it."""
    started = []

    def start(name, *options):
        command = [sys.executable, "-m", "fesloop", "stream", "hand", "--loop", "--name", name, *options]
        started.append(subprocess.Popen(command, stderr=subprocess.DEVNULL))

    yield start
    for process in started:
        process.terminate()
        process.wait(timeout=120.0)


def live(name, tmp_path, seconds):
    settings = [f"stream={name}", f"blocks.outlet.stream=commands of {name}",
                f"experiment.duration_s={seconds}", "blocks.sensors.timeout_s=60"]
    return load("hil_live", settings).run(tmp_path, realtime=True)


@pytest.mark.slow
def test_sensors_of_another_process_drive_tracker_and_controller(sender, tmp_path):
    name = f"imus {time.monotonic_ns()}"
    sender(name)
    result = live(name, tmp_path, 12.0)
    assert result.status == "done"
    with Recording(result.recording) as run:
        stimulation, angles = run.signal("safety.stimulation"), run.signal("tracker.angles")
        flexion = np.degrees(np.asarray(angles.values)[:, [7, 9, 10]])
        pulses = np.asarray(stimulation.values)
        ages_ms = (stimulation.times_ns - stimulation.oldest_ns) / 1e6
    assert len(pulses) > 1000
    assert pulses.max() > 0.0
    assert np.median(ages_ms) < 20.0
    # The hand closes by 45, 55 and 30 deg (moving_hand.toml); which of it the 12 s see depends on the start.
    assert (np.ptp(flexion[300:], axis=0) > np.array([20.0, 30.0, 12.0])).all()


@pytest.mark.slow
def test_a_tracker_whose_sensors_stop_stimulates_no_longer_than_stated(sender, tmp_path):
    """0.1 s until the posture is too old, 0.2 s of ramp, some ms of waking up."""
    name = f"imus {time.monotonic_ns()}"
    sender(name, *(f"--fault=stop@{start}+3" for start in range(6, 60, 9)))
    result = live(name, tmp_path, 10.0)
    with Recording(result.recording) as run:
        silent = [event.time_ns for event in run.events if event.status == "stream_silent"]
        stimulation = run.signal("safety.stimulation")
        times, charges = stimulation.times_ns, np.prod(np.asarray(stimulation.values), axis=2).sum(axis=1)
        back = [event.time_ns for event in run.events if event.status == "stream_resumed"]
    gaps = [(begin, min([instant for instant in back if instant > begin], default=int(times[-1])))
            for begin in silent]
    long = [gap for gap in gaps if gap[1] - gap[0] > NS_PER_S]
    assert long
    for begin, end in long:
        within = (times > begin + 350 * NS_PER_MS) & (times < end)
        assert within.any()
        assert charges[within].max() == 0.0


def test_the_file_is_of_the_fingers_it_says():
    freedoms = [freedom if isinstance(freedom, str) else freedom.name
                for freedom in hand_tree(HandSize()).freedoms]
    document = load("hil_live").document()
    for block in ("finger", "finger_sd"):
        indices = document["blocks"][block]["indices"]
        assert [freedoms[k] for k in indices] == document["blocks"]["reference"]["rows"]


def test_without_real_time_it_is_refused(tmp_path):
    with pytest.raises(InputError, match="--realtime"):
        fesloop.load("hil_live").run(tmp_path)


def test_the_computed_hand_is_what_sensors_give():
    hand = moving_hand()
    assert (len(hand.sensors), hand.rate, hand.samples) == (16, 100, 3000)
    assert np.linalg.norm(hand.acc[:350], axis=2).mean() == pytest.approx(9.81, abs=0.1)
    assert np.abs(hand.gyr[:350]).max() < 0.05 < np.abs(hand.gyr[450:2700]).max()
    np.testing.assert_allclose(hand.acc[-1], hand.acc[0], atol=0.3)
    assert files("fesloop.experiment").joinpath("moving_hand.toml").is_file()


@pytest.mark.slow
def test_a_stream_ends_when_its_time_is_over_and_says_what_was_sent():
    command = [sys.executable, "-m", "fesloop", "stream", "hand", "--name", f"brief {time.monotonic_ns()}"]
    done = subprocess.run([*command, "--duration", "0.5", "--json"], capture_output=True, text=True,
                          timeout=60)
    told = json.loads(done.stdout)
    assert (done.returncode, told["rate_hz"], len(told["sensors"])) == (0, 100.0, 16)
    assert told["sent"] == 50
    refused = subprocess.run([*command, "--fault", "halt@3"], capture_output=True, text=True, timeout=60)
    assert refused.returncode == 2
    assert "KIND is one of stop, vanish" in refused.stderr
