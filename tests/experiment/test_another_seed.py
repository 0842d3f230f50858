"""Another seed for an experiment that is made already, against one that is read with it."""

import numpy as np
import pytest

import fesloop
from fesloop.errors import InputError, InputErrors
from fesloop.experiment.running import Experiment, run

EXPERIMENTS = ("finger_pid_latency", "finger_mpc", "finger_ilc", "array_search_two_phase")


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_it_is_the_experiment_that_is_read_with_the_seed(name):
    first, read = fesloop.load(name), fesloop.load(name, seed=77)
    made = first.with_seed(77)
    assert made == read
    assert made.fingerprint() == read.fingerprint()
    assert made.document() == read.document()
    assert made.wiring.seed == made.seed == 77
    assert first.seed == first.wiring.seed != 77
    assert first != made
    assert first.with_seed(first.seed) == first


def test_a_seed_of_numpy_is_the_same_seed():
    """What a loop over np.arange gives."""
    first = fesloop.load("finger_pid_latency")
    made = first.with_seed(np.int64(5))
    assert made == first.with_seed(5)
    assert type(made.seed) is type(made.wiring.seed) is int
    again = Experiment(name=first.name, description=first.description, nodes=first.nodes, wires=first.wires,
                       duration_s=first.duration_s, trials=np.int32(1), seed=np.int64(5), record=first.record,
                       score=first.score)
    assert again == made


def test_it_runs_as_the_experiment_that_is_read_with_the_seed(tmp_path):
    settings = ["experiment.duration_s=0.8"]
    first = fesloop.load("finger_pid_latency", settings)
    digests = []
    for experiment in (first.with_seed(5), fesloop.load("finger_pid_latency", settings, seed=5), first):
        result = run(experiment, tmp_path)
        with fesloop.Recording(result.recording) as recording:
            digests.append((recording.digest(), recording.seed, result.metrics["joint_rmse_deg"]))
    assert digests[0] == digests[1]
    assert digests[2][2] != digests[0][2]


@pytest.mark.parametrize("seed", [-1, 2**63])
def test_a_seed_that_cannot_be_is_refused_as_in_a_file(seed):
    with pytest.raises(InputErrors) as read:
        fesloop.load("finger_pid_latency", seed=seed)
    with pytest.raises(InputErrors) as made:
        fesloop.load("finger_pid_latency").with_seed(seed)
    assert str(read.value).endswith(str(made.value))


@pytest.mark.parametrize("number", [1.5, 2.0, True, "3"])
def test_a_seed_and_a_number_of_trials_are_integers(number):
    """Of a file its form says so; of what is written in Python nothing else does before the run."""
    first = fesloop.load("finger_pid_latency")
    with pytest.raises(InputError, match=r"experiment\.seed"):
        first.with_seed(number)
    for key in ("seed", "trials"):
        with pytest.raises(InputError, match=rf"experiment\.{key}.*an integer"):
            Experiment(name="made", nodes=first.nodes, wires=first.wires, duration_s=1.0, **{key: number})


def test_what_a_seed_decides_is_checked_again():
    """The least delay round the loop, which the horizon has to hold, is that of the jitter that is drawn."""
    settings = ["control=mpc", "jitter_ms=100", "latency_ms=440"]
    first, refused = fesloop.load("finger_control", settings, seed=0), []
    for seed in range(8):
        told = []
        for make in (lambda seed=seed: fesloop.load("finger_control", settings, seed=seed),
                     lambda seed=seed: first.with_seed(seed)):
            try:
                make()
                told.append("")
            except (InputError, InputErrors) as fault:
                told.append(str(fault).removeprefix("finger_control with control=mpc: "))
        assert told[0] == told[1]
        refused += [seed] if told[0] else []
    assert 0 < len(refused) < 8


def test_a_document_is_the_callers_own():
    experiment = fesloop.load("finger_pid_latency")
    text = experiment.as_json()
    document = experiment.document()
    document["blocks"].clear()
    document["wires"][0]["latency_ms"] = 1e3
    assert experiment.as_json() == text


@pytest.mark.parametrize("seed", [np.int64(3), np.int32(3), np.uint8(3)])
def test_a_wiring_takes_a_seed_of_numpy(seed):
    made = fesloop.load("finger_pid_latency").wiring.with_seed(seed)
    assert made.seed == 3
    assert type(made.seed) is int


@pytest.mark.parametrize("seed", [True, np.bool_(True), 3.0, np.float64(3.0), -1, np.int64(-1), 2**63, "3",
                                  np.array([3])])
def test_a_wiring_takes_nothing_else_for_a_seed(seed):
    with pytest.raises(InputError, match="seed"):
        fesloop.load("finger_pid_latency").wiring.with_seed(seed)
