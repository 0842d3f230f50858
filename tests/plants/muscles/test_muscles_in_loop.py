"""The muscles in a loop: instants, observers, snapshots, trials; and as an experiment file has them."""

from dataclasses import dataclass

import numpy as np
import pytest
from muscle_parts import COUNT, MODELS, MS, patient, tiring

from fesloop.errors import InputError
from fesloop.forms.schema import make, plain
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from plants.muscles import Muscles
from plants.muscles.variation import Variation


@dataclass(frozen=True)
class Pulses:
    """Puts out recruitment that changes slot by slot, at 40 Hz."""

    inputs = ()
    outputs = (Port("recruitment", (COUNT,)), Port("frequency", (COUNT,), "Hz"))

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return np.full(COUNT, 0.2 + 0.6 * (tick.index % 3 == 0)), np.full(COUNT, 40.0)


@dataclass(frozen=True)
class Watcher:
    """Reads activation."""

    inputs = (Port("activation", (COUNT,)),)
    outputs = (Port("seen", (COUNT,)),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (inputs[0].value.copy(),)


def loop_of(muscles, watched="50", plant_rate=None, latency_ms=0.0):
    """A loop and its recorder."""
    recorder = Recorder(plant_rate=plant_rate)
    nodes = [Node("pulses", Pulses(), rate="40"), Node("muscles", muscles),
             Node("watcher", Watcher(), rate=watched)]
    wires = [Wire("pulses.recruitment", "muscles.recruitment", latency_ms=latency_ms),
             Wire("pulses.frequency", "muscles.frequency", latency_ms=latency_ms),
             Wire("muscles.activation", "watcher.activation")]
    return Loop(Wiring(nodes, wires, seed=2), recorder=recorder), recorder


def seen(recorder):
    """Activation as watched, by instant in ns."""
    return {row[1]: row[5][0] for row in recorder.blocks["watcher"]}


@pytest.mark.parametrize("model", MODELS)
def test_watching_and_recording_more_often_changes_no_bit(model: str) -> None:
    runs = []
    for watched, plant_rate in (("50", None), ("350", None), ("50", "1000")):
        loop, recorder = loop_of(patient(model), watched, plant_rate)
        loop.run_until(300 * MS)
        runs.append(seen(recorder))
    for instant in runs[0]:
        for run in runs[1:]:
            np.testing.assert_array_equal(run[instant], runs[0][instant])
    assert runs[0][300 * MS].min() > 0.1


@pytest.mark.parametrize("latency_ms", [0.0, 7.5, 25.0])
@pytest.mark.parametrize("model", MODELS)
def test_effort_that_follows_the_muscles_themselves_is_the_same_in_stretches(model: str, latency_ms) -> None:
    """Activation fed back as effort on the way."""
    runs = []
    for stretch in (500 * MS, 10 * MS, 3_333_333):
        nodes = [Node("pulses", Pulses(), rate="40"), Node("muscles", patient(model))]
        wires = [Wire("pulses.recruitment", "muscles.recruitment"),
                 Wire("pulses.frequency", "muscles.frequency"),
                 Wire("muscles.activation", "muscles.voluntary", rate="100", latency_ms=latency_ms)]
        recorder, now = Recorder("300"), -1
        loop = Loop(Wiring(nodes, wires, seed=2), recorder=recorder)
        while now < 500 * MS:
            now = min(now + stretch, 500 * MS)
            loop.run_until(now)
        runs.append((np.concatenate([row[2][0] for row in recorder.plants["muscles"]]),
                     [(row[0], row[4].tobytes()) for row in recorder.inputs["muscles"] if row[1] == 3]))
    for activation, effort in runs[1:]:
        np.testing.assert_array_equal(activation, runs[0][0])
        assert effort == runs[0][1]
    assert len({value for _, value in runs[0][1]}) > 10


def test_latency_of_the_wire_and_of_the_muscle_add_up() -> None:
    loop, recorder = loop_of(Muscles(delay_ms=20.0), watched="2000", latency_ms=7.5)
    loop.run_until(40 * MS)
    first = min(instant for instant, activation in seen(recorder).items() if activation.any())
    assert first == 28 * MS


@pytest.mark.parametrize("model", MODELS)
def test_a_run_goes_on_from_a_snapshot_and_tires_over_trials(model: str) -> None:
    loop, recorder = loop_of(tiring(model))
    loop.run_until(130 * MS)
    saved = loop.snapshot()
    loop.run_until(400 * MS)
    whole = seen(recorder)
    other, again = loop_of(tiring(model))
    other.restore(saved)
    other.run_until(400 * MS)
    for instant, activation in seen(again).items():
        np.testing.assert_array_equal(activation, whole[instant])
    loop.run_until(8_000 * MS)
    fitness = loop.states()["muscles"]
    loop.next_trial()
    muscles, after = tiring(model), loop.states()["muscles"]
    assert (muscles.read(after, ())[1] > muscles.read(fitness, ())[1]).all()
    assert (muscles.read(after, ())[1] < 0.999).all()


def test_each_trial_of_a_run_has_its_own_strength():
    last = []
    for _ in range(2):
        loop, recorder = loop_of(Muscles(variation=Variation(trial=0.1, muscle_trial=0.2, muscle_drift=0.2)))
        loop.run_until(300 * MS)
        first = seen(recorder)[300 * MS]
        loop.next_trial()
        loop.run_until(300 * MS)
        last.append(seen(recorder)[300 * MS])
        assert (abs(last[-1] / first - 1.0) > 1e-3).all()
    np.testing.assert_array_equal(*last)


def test_an_experiment_files_table_is_the_object() -> None:
    table = {
        "model": "ding2003", "delay_ms": 15.0, "ding2003": {"fatigue": {"recovery_s": 100.0}},
        "reflex": {"gain_s": 1.0, "muscles": ["FCR"]}, "tremor": {"band_hz": [4.0, 6.0]}}
    muscles = make(Muscles, table, {}, "blocks.muscles")
    assert muscles.ding2003.fatigue.recovery_s == 100.0
    assert muscles.reflex.muscles == ("FCR",)
    assert make(Muscles, plain(muscles), {}, "blocks.muscles") == muscles
    with pytest.raises(InputError, match=r"blocks\.muscles\.reflex\.limit"):
        make(Muscles, {"reflex": {"limit": 3.0}}, {}, "blocks.muscles")
