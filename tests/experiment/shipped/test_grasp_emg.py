"""A grasp by EMG: exact latencies of a script without noise, its determinism, and what does not fit."""

from dataclasses import dataclass

import numpy as np
import pytest

import fesloop
from controllers.reference.triggered import TriggeredPhase, TriggeredPhases
from estimators.emg_effort import EmgEffort
from fesloop.apps.cli import main
from fesloop.errors import InputError, InputErrors
from fesloop.experiment.cautions import experiment_cautions
from fesloop.experiment.recording.reading import Recording
from fesloop.hand.movements import muscle
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.intention.block import Intention
from plants.intention.emg import EmgElectrode
from plants.intention.script import Attempt
from plants.muscles import Muscles

MS = 1_000_000


@dataclass(frozen=True)
class Alternating:
    """EMG whose sign alternates: rectified, it is 1 mV times the effort, without noise."""

    inputs = (Port("effort", (1,)),)
    outputs = (Port("emg", (1,), "V"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (1e-3 * (-1.0) ** tick.index * inputs[0].value,)


def test_the_latency_from_onset_to_trigger_is_that_of_the_hand_calculation():
    """Rise 1 us, so that effort is a step behind 2.2 s: the first sample with it is that of 2.201 s, read at
    2.206 s. Two lags of 3 Hz at 1 kHz, a = exp(-.006 pi), reach 1 - a^n (1 + n (1 - a)) after n samples of
    it: .295 for n = 57, .302 for 58, which is read at 2.263 s. The reference (40 Hz) sees .3 passed at
    2.275 s, and 150 ms later, at 2.425 s, it triggers: 225 ms after the onset."""
    attempts = (Attempt(at_s=0.3, duration_s=0.6, muscles=("ECRL",)),
                Attempt(at_s=2.0, duration_s=0.6, muscles=("ECRL",)))
    person = Intention(attempts=attempts, emg=(EmgElectrode(muscle="ECRL"),), jitter_s=0.0, noise=0.0,
                       rise_s=1e-6)
    phases = (TriggeredPhase(name="rest", deg={"finger_flexion": 0.0}),
              TriggeredPhase(name="close", deg={"finger_flexion": 60.0}))
    nodes = [Node("person", person, rate="1000"), Node("sensor", Alternating(), rate="1000"),
             Node("emg", EmgEffort(rest_s=(0.0, 0.4), contraction_s=(0.4, 1.9)), rate="1000"),
             Node("reference", TriggeredPhases(phases=phases, rows=("finger_flexion",)), rate="40")]
    wires = [Wire("person.effort", "sensor.effort"), Wire("sensor.emg", "emg.emg", latency_ms=5.0),
             Wire("emg.effort", "reference.effort"), Wire("emg.detection", "reference.detection")]
    recorder = Recorder()
    Loop(Wiring(nodes, wires, seed=1), recorder=recorder).run_until(3000 * MS)
    efforts = {row[1]: row[5][0] for row in recorder.blocks["emg"]}
    assert min(now for now, effort in efforts.items() if effort >= 0.3) == 2263 * MS
    phase = {row[1]: row[5][1] for row in recorder.blocks["reference"]}
    assert min(now for now, number in phase.items() if number == 1.0) == 2425 * MS
    attempt = {row[1]: row[5][1] for row in recorder.blocks["person"]}
    assert min(now for now, number in attempt.items() if number == 2.0) == 2200 * MS


@dataclass(frozen=True)
class Held:
    """Puts out a constant recruitment of all muscles, at 1 GHz: fused."""

    recruited: float
    inputs = ()
    outputs = (Port("recruitment", (29,)), Port("frequency", (29,), "Hz"))

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return np.full(29, self.recruited), np.full(29, 500.0)


@pytest.mark.parametrize("recruited", [0.0, 0.3, 0.8, 1.0])
def test_effort_adds_to_stimulation_up_to_the_fibres_that_stimulation_holds(recruited):
    """Steady activation: h(500 Hz) v + min(effort, 1 - v), with h = 2500 / 2501."""
    person = Intention(attempts=(Attempt(at_s=0.0, duration_s=9.0, action="extend_wrist"),), noise=0.0,
                       voluntary_limit=0.0, voluntary_limits={"ECRL": 0.7})
    nodes = [Node("person", person, rate="100"), Node("pulses", Held(recruited), rate="40"),
             Node("muscles", Muscles(voluntary_limit=0.0, voluntary_limits={"ECRL": 0.7}))]
    wires = [Wire("person.voluntary", "muscles.voluntary"), Wire("pulses.recruitment", "muscles.recruitment"),
             Wire("pulses.frequency", "muscles.frequency")]
    recorder = Recorder("10")
    Loop(Wiring(nodes, wires, seed=1), recorder=recorder).run_until(3000 * MS)
    activation = recorder.plants["muscles"][-1][2][0][-1]
    stimulated = recruited * 2500.0 / 2501.0
    expected = min(stimulated + min(0.7, 1.0 - recruited), 1.0)
    assert activation[muscle("ECRL")] == pytest.approx(expected, abs=1e-6)
    assert activation[muscle("FDP3")] == pytest.approx(stimulated, abs=1e-6)


def test_the_patients_limits_are_those_of_the_person():
    person = next(node.part for node in fesloop.load("grasp_emg").nodes if node.name == "intention")
    assert (person.voluntary_limit, person.voluntary_limits) == (0.0, {"ECRL": 0.7, "ECRB": 0.6})


def refused(*settings):
    with pytest.raises((InputError, InputErrors)) as fault:
        fesloop.load("grasp_emg", [*settings])
    return str(fault.value)


@pytest.mark.parametrize(("toml", "says"), [
    ("remove = ['wires.\"intention.emg->emg.emg\"']", "emg.emg: this input has no wire"),
    ('blocks.emg.muscle = "deltoi"', "did you mean 'deltoid'"),
    ('blocks.intention.rate = "100"', "intention.rate: 100; allowed: 250 or more"),
    ('blocks.emg.rate = "500"', "raise emg.rate"),
    ("blocks.reference.on = 0.1", "off: 0.15; allowed: 0 or more, below on, 0.1")])
def test_what_does_not_fit_is_refused_in_one_line(toml, says, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(f'extends = "grasp_emg"\n{toml}\n')
    with pytest.raises((InputError, InputErrors)) as fault:
        fesloop.load(str(path))
    assert says in str(fault.value)
    assert "\n" not in str(fault.value).strip()


def test_a_controller_that_learns_by_the_clock_is_refused(tmp_path):
    path = tmp_path / "learning.toml"
    path.write_text('''extends = "open_close_ilc"
remove = ["blocks.reference.repeats", "blocks.reference.phases"]
[blocks.reference]
kind = "triggered_phases"
phases = [{ name = "rest" }, { name = "open", deg = { wrist_extension = 25, finger_flexion = 20 } }]
[blocks.intention]
kind = "intention"
rate = "1000"
emg = [{ muscle = "ECRL" }]
attempts = [{ at_s = 1.0, action = "extend_wrist" }]
[blocks.emg]
kind = "emg_effort"
rate = "1000"
[[wires]]
from = "intention.emg"
to = "emg.emg"
[[wires]]
from = "emg.effort"
to = "reference.effort"
''')
    with pytest.raises((InputError, InputErrors)) as fault:
        fesloop.load(str(path))
    assert "blocks.reference.angles: 'controller' follows it in the next trial" in str(fault.value)
    assert "grasp_phases" in str(fault.value)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two runs of one seed, and one of another, without the object's end: 9 s each."""
    folder = tmp_path_factory.mktemp("runs")
    short = ["experiment.duration_s=9", "scene=free"]
    return [fesloop.load("grasp_emg", [*short, f"experiment.seed={seed}"]).run(folder) for seed in (1, 1, 2)]


@pytest.mark.slow
def test_runs_repeat_by_seed_and_answer_every_attempt(runs):
    digests = []
    for run in runs:
        with Recording(run.recording) as recording:
            digests.append(recording.digest())
    assert digests[0] == digests[1] != digests[2]
    for run in runs:
        assert run.metrics["false_triggers"] == [0]
        assert run.metrics["missed_triggers"] == [0]
        assert 0.2 < run.metrics["intention_to_reference_s"][0] < 0.5
        assert run.metrics["intention_to_movement_s"][0] > run.metrics["intention_to_reference_s"][0]


@pytest.mark.slow
def test_artefacts_of_stimulation_are_triggers_missed_and_blanking_brings_them_back(tmp_path):
    short = ["experiment.duration_s=9", "scene=free", "intention=trigger_wrist"]
    without, blanked = (fesloop.load("grasp_emg", [*short, f"blanking_ms={ms}"]).run(tmp_path).metrics
                        for ms in (0.0, 2.5))
    assert without["missed_triggers"][0] >= 1
    assert blanked["missed_triggers"] == [0]


def test_what_a_stimulated_person_puts_out_is_captured_now():
    """Else commands would derive, round the loop, from ever older captures, and be withheld as too old."""
    experiment = fesloop.load("grasp_emg", ["intention=trigger_wrist"])
    assert "always_too_old" not in {status for _, status, _ in experiment_cautions(experiment, blocks=False)}


def test_a_person_whose_attempts_are_not_answered_is_the_first_thing_said(tmp_path, capsys):
    assert main(["run", "grasp_emg", "--set", "blocks.reference.hold_ms=13000", "--out", str(tmp_path)]) == 0
    first = capsys.readouterr().err.splitlines()[0]
    assert first.startswith("fesloop: 3 of the person's attempts were not answered")
