"""Environments of gymnasium: the exact loop, its latencies, and messages for what does not fit."""

import subprocess
import sys
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="needs the extra gym")
import gymnasium
from gymnasium.utils.env_checker import check_env

import fesloop
from controllers.allocation import Allocation
from fesloop.errors import InputError
from fesloop.gym import LoopEnv
from fesloop.loop.order import Sampling
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port
from fesloop.loop.wiring import Wiring
from fesloop.show.film.stage import drawing_surface

HARD = ["latency_ms=50", "jitter_ms=40", "loss=0.2"]


@dataclass(frozen=True, kw_only=True)
class Script:
    """In the place of a controller: puts out given pulses, and keeps what it reads."""

    inputs: tuple
    outputs: tuple
    pulses: tuple

    def init(self, context):
        return SimpleNamespace(read=[])

    def step(self, state, inputs, tick):
        state.read.append([(tick.time_ns, *each[1:], np.copy(each.value)) for each in inputs])
        return (self.pulses[tick.index],)


def scripted(experiment, actions):
    """A recorded loop of the experiment as it is, its controller a script of the same drives."""
    node = experiment.wiring.node("controller")
    drives = node.part.allocation()
    pulses = tuple(drives.stimulation(np.float64(each) * drives.reach()) for each in actions)
    script = Script(inputs=node.part.inputs, outputs=node.part.outputs, pulses=pulses)
    nodes = [replace(each, part=script) if each.name == "controller" else each for each in experiment.nodes]
    return Loop(Wiring(nodes, experiment.wires, experiment.seed), recorder=Recorder(plant_rate="50"))


def draws():
    """Whether there is OpenGL; the README's tests need no package of Debian."""
    try:
        with drawing_surface(64, 64):
            return True
    except InputError:
        return False


def episode(env, actions, **reset):
    """Observations, rewards and infos of the actions."""
    seen, info = env.reset(**reset)
    rows = [(seen, 0.0, info)]
    for action in actions:
        seen, reward, _, over, info = env.step(action)
        rows.append((seen, reward, info))
        if over:
            break
    return list(zip(*rows, strict=True))


def drawn(env, count):
    return 0.6 * np.random.default_rng(5).random((count, *env.action_space.shape)).astype(np.float32)


def pick(env, observations, name):
    names = env.unwrapped.observation_names
    return np.array(observations)[:, [k for k, each in enumerate(names) if each.startswith(name)]]


@pytest.mark.filterwarnings("ignore:.*Box observation space")
@pytest.mark.parametrize("name", ["Finger", *(pytest.param(each, marks=pytest.mark.slow)
                                              for each in ("Hand", "Grasp"))])
def test_gymnasium_finds_no_fault(name):
    env = gymnasium.make(f"fesloop/{name}-v0")
    check_env(env.unwrapped, skip_render_check=not draws())
    assert len(env.unwrapped.observation_names) == env.observation_space.shape[0]
    env.close()


@pytest.mark.parametrize(("environment", "name", "settings", "steps", "truth"), [
    ("Finger", "finger_control", HARD, 300, "patient"),
    # No tick of the tracker but the first is one of the controller: the truth is evaluated for itself.
    ("Finger", "finger_control", [*HARD, "blocks.tracker.rate=73"], 300, "patient"),
    pytest.param("Grasp", "grasp_mpc", ["jitter_ms=20", "loss=0.1"], 400, "truth", marks=pytest.mark.slow)])
def test_an_episode_is_the_loop_to_the_last_bit(environment, name, settings, steps, truth):
    env = gymnasium.make(f"fesloop/{environment}-v0")
    actions = drawn(env, steps)
    observations, rewards, infos = episode(env, actions, seed=7, options={"settings": settings})
    assert len(observations) == steps + 1  # truncated by the last action, not before

    experiment = fesloop.load(name, settings, 7)
    loop = scripted(experiment, actions)
    loop.run_until(experiment.duration_ns - 1)
    script = loop.states()["controller"]
    inputs = experiment.wiring.node("controller").part.inputs
    for number, port in enumerate(inputs):
        ours = pick(env, observations[:-1], f"{port.name}[")
        if not ours.size:  # not wired
            continue
        theirs = [each[number] for each in script.read]
        assert ours.tobytes() == np.array([value.ravel() for *_, value in theirs]).tobytes()
        assert pick(env, observations[:-1], f"{port.name}.age_s").ravel().tolist() == [
            (now - max(oldest, 0)) / 1e9 for now, oldest, *_ in theirs]
        assert pick(env, observations[:-1], f"{port.name}.present").ravel().tolist() == [
            float(arrived >= 0) for *_, arrived, _ in theirs]
    blocks, plants, _, _ = loop.recorder.drain()
    times = [info["time_ns"] for info in infos[:-1]]
    if truth in plants:
        rows = [each for row in plants[truth] for each in zip(row[0], row[2][0], strict=True)]
    else:
        rows = [(row[1], row[5][0]) for row in blocks[truth]]
    ours = np.array([info["truth"] for info in infos[:-1]])
    last = np.searchsorted([time for time, _ in rows], times, side="right") - 1
    assert ours.tobytes() == np.array([rows[k][1] for k in last]).tobytes()
    assert np.ptp(ours) > 0.1
    loop.close()

    again = episode(env, actions, seed=7, options={"settings": settings})
    assert rewards == again[1]
    assert np.array(observations).tobytes() == np.array(again[0]).tobytes()
    assert not np.isnan(observations).any()


@pytest.mark.parametrize(("settings", "shared"), [
    ([], True), (["blocks.tracker.rate=200"], True), (["blocks.tracker.rate=73"], False),
    (["blocks.tracker.offset_ms=5"], False)])
def test_the_truth_is_evaluated_with_the_trackers_samples_where_their_ticks_meet(settings, shared):
    env = LoopEnv("finger_control", settings)
    order = env._base.wiring.order
    sampled = [each for each in order if isinstance(each, Sampling) and each.plant.name == "patient"]
    assert len(sampled) == (1 if shared else 2)


def test_latency_delays_what_is_seen_exactly():
    env = LoopEnv("finger_control", {"control": "pid"})
    actions = [np.full(4, 0.3)] * 60

    def measured(latency_ms):
        seen = episode(env, actions, seed=2, options={"settings": {"latency_ms": latency_ms}})[0]
        return pick(env, seen, "measured["), pick(env, seen, "measured.age_s").ravel()

    near, age = measured(20)
    assert set(age[2:].tolist()) == {0.02}
    far, age = measured(60)
    assert set(age[4:].tolist()) == {0.06}
    assert age[:4].tolist() == [0.0, 0.02, 0.04, 0.06]  # nothing has come: since the trial began
    assert far[3:].tobytes() == near[1:-2].tobytes()
    assert np.ptp(far) > 0.1
    # The tracker's samples come every 10 ms: one more ns, and the one before is the newest.
    assert set(measured(30)[1][4:].tolist()) == {0.03}
    assert set(measured(30.000001)[1][4:].tolist()) == {0.04}
    assert set(measured(20)[1][2:].tolist()) == {0.02}  # settings of an episode end with it


def test_the_reward_is_the_true_error_and_the_effort():
    env = LoopEnv("finger_control", ["score.after_s=0.1", "experiment.duration_s=0.4"], effort_weight=0.5)
    _, rewards, infos = episode(env, [np.full(4, 0.2)] * 20, seed=1)
    with pytest.raises(gymnasium.error.ResetNeeded, match="the episode has ended"):
        env.step(np.full(4, 0.2))
    error = np.array([np.mean((info["truth"] - info["reference"])**2) for info in infos])
    scored = np.array([info["time_ns"] >= 100_000_000 for info in infos])
    np.testing.assert_allclose(rewards[1:], (-error * scored - 0.5 * 0.04)[1:], rtol=1e-12)
    assert error.max() > 0.0


@pytest.mark.parametrize("name", ["Finger", *(pytest.param(each, marks=pytest.mark.slow)
                                              for each in ("Hand", "Grasp"))])
def test_pictures_show_the_hand_move_and_change_no_bit_of_the_episode(name):
    if not draws():
        pytest.skip("nothing draws in three dimensions here")
    plain = gymnasium.make(f"fesloop/{name}-v0")
    filmed = gymnasium.make(f"fesloop/{name}-v0", render_mode="rgb_array")
    actions = drawn(plain, 60)
    seen = [[], []]
    for episodes in range(2):  # the second is after a reset
        pictures = []
        for env, rows in zip((plain, filmed), seen, strict=True):
            rows.append(env.reset(seed=episodes)[0])
            for k, action in enumerate(actions):
                if env is filmed and k % 20 == 0:
                    pictures.append(env.render())
                observation, reward, *_ = env.step(action)
                rows.append(np.append(observation, reward))
        assert all(each.shape == (480, 640, 3) and each.dtype == np.uint8 for each in pictures)
        hand = [np.mean(each.min(axis=2) < 200) for each in pictures]
        assert all(0.03 < share < 0.6 for share in hand), hand
        assert (pictures[0] != pictures[-1]).mean() > 0.001
    assert np.concatenate(seen[0]).tobytes() == np.concatenate(seen[1]).tobytes()
    assert plain.unwrapped.render() is None
    filmed.close()
    with pytest.raises(gymnasium.error.ResetNeeded):
        filmed.unwrapped.render()


@pytest.mark.slow
def test_an_object_that_is_never_given_is_penalised():
    env = gymnasium.make("fesloop/Grasp-v0", effort_weight=0.0)
    _, rewards, infos = episode(env, [np.zeros(8)] * 400, seed=1)
    hold = [reward for reward, info in zip(rewards, infos, strict=True)
            if 6.2e9 <= info["time_ns"] <= 8.5e9]
    assert set(hold) == {-1.0}
    # It waits in front of the fingers, which leave no room for it.
    places = np.array([info["object"] for info in infos])
    np.testing.assert_array_equal(places, np.tile([-0.006, 0.362, 0.0], (len(infos), 1)))
    assert 0.15 < infos[-1]["object_away_m"] < 0.25


def test_pulses_of_an_action_are_those_that_the_stimulator_is_told():
    env = gymnasium.make("fesloop/Finger-v0").unwrapped
    env.reset(seed=1)
    share = np.linspace(0.2, 0.8, env.action_space.shape[0])
    env.step(share)
    told = env.loop.newest("controller")["stimulation"]
    np.testing.assert_array_equal(told, env.pulses(share))
    assert (told[:, 1] > 0.0).all()
    assert not env.pulses(0.0 * share)[:, 1].any()
    env.close()


def test_seeds_come_from_the_environment_where_none_is_given():
    env = LoopEnv("finger_control")
    first = [env.reset(seed=4)[1]["seed"], *(env.reset()[1]["seed"] for _ in range(2))]
    again = [env.reset(seed=4)[1]["seed"], *(env.reset()[1]["seed"] for _ in range(2))]
    assert first == again
    assert first[0] == 4
    assert len(set(first)) == 3


@dataclass(frozen=True, kw_only=True)
class Button:
    """An emergency stop, pressed at half a second."""

    inputs: tuple = ()
    outputs: tuple = field(default=(Port("stop"),), init=False)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (float(tick.time_ns >= 500_000_000),)


def test_an_emergency_stop_terminates():
    given = fesloop.load("finger_control")
    experiment = fesloop.Experiment(
        name="stopped", nodes=(*given.nodes, fesloop.Node("button", Button(), "50")), duration_s=2.0,
        wires=(*given.wires, fesloop.Wire("button.stop", "safety.stop")), score=given.score)
    env = LoopEnv(experiment)
    env.reset(seed=1)
    terminated = [env.step(np.zeros(4))[2] for _ in range(26)]
    assert terminated.index(True) == 25  # the tick after that of half a second
    with pytest.raises(gymnasium.error.ResetNeeded, match="the episode has ended"):
        env.step(np.zeros(4))
    with pytest.raises(InputError, match="settings: given with an experiment"):
        env.reset(options={"settings": ["latency_ms=3"]})


def test_any_block_that_puts_out_pulses_can_be_replaced():
    with pytest.raises(InputError, match=r"blocks\.safety: has no currents for the agent"):
        LoopEnv("finger_control", controller="safety")
    widths = Allocation(recruitment=None, current_ma=(20.0,) * 4, full_scale_us=300.0)
    env = LoopEnv("finger_control", controller="safety", drives=widths)
    assert "stimulation[0,0]" in env.observation_names
    env.reset(seed=1)
    env.step(np.full(4, 0.5))
    given = env.loop.states()["safety"].pulses
    np.testing.assert_allclose(given, np.tile([20e-3, 150e-6], (4, 1)), rtol=1e-12)


@pytest.mark.parametrize(("make", "message"), [
    (lambda: LoopEnv("finger_contrl"), "did you mean 'finger_control'"),
    (lambda: LoopEnv("finger_control", ["lantency_ms=3"]), "lantency_ms"),
    (lambda: LoopEnv("finger_control", controller="control"), "did you mean 'controller'"),
    (lambda: LoopEnv("finger_control", controller="tracker"), "whose one output is pulses"),
    (lambda: LoopEnv("finger_control", effort_weight=-1.0), "effort_weight: -1.0; allowed"),
    (lambda: LoopEnv("finger_control", drives=Allocation(recruitment=None, current_ma=(20.0,))),
     "drives: 1 channels; allowed: 4"),
    (lambda: LoopEnv("hil_dry_stimulator"), "is live"),
    (lambda: LoopEnv("finger_control", render_mode="human"), "render_mode: 'human'; allowed"),
    (lambda: LoopEnv("salchow2019"), "there is no block 'controller'")])
def test_what_does_not_fit_is_refused_in_one_line(make, message):
    with pytest.raises(InputError, match=message) as refused:
        make()
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("act", "message"), [
    (lambda env: env.step(np.zeros(3)), r"action: shape \(3,\); allowed: shape \(4,\), each from .*; scale"),
    (lambda env: env.step([0.0, 0.0, 1.5, 0.0]), r"action: \[0.0, 0.0, 1.5, 0.0\]"),
    (lambda env: env.step(np.full(4, np.nan)), "action: .*nan"),
    (lambda env: env.reset(options={"setings": []}), "options.setings: is unknown; allowed: settings"),
    (lambda env: env.reset(options={"settings": ["lantency_ms=3"]}), "lantency_ms"),
    (lambda env: env.reset(options={"settings": ["control=pid"]}), "changes the entries of the observation")])
def test_a_wrong_action_or_option_is_refused_and_the_episode_stays(act, message):
    env = LoopEnv("finger_control")
    env.reset(seed=1)
    env.step(np.zeros(4))
    with pytest.raises(InputError, match=message) as refused:
        act(env)
    assert "\n" not in str(refused.value)
    assert env.step(np.zeros(4))[4]["time_ns"] == 40_000_000


def test_a_wrong_id_and_a_step_before_reset_are_gymnasiums_to_refuse():
    with pytest.raises(gymnasium.error.NameNotFound, match="Finger"):
        gymnasium.make("fesloop/Fingr-v0")
    with pytest.raises(gymnasium.error.ResetNeeded):
        LoopEnv("finger_control").step(np.zeros(4))


@pytest.mark.slow
def test_environments_run_in_processes_of_their_own():
    many = gymnasium.make_vec("fesloop/Finger-v0", 2, "async", vector_kwargs={"context": "spawn"})
    one = gymnasium.make("fesloop/Finger-v0")
    try:
        first, _ = many.reset(seed=[3, 4])
        assert first[0].tobytes() == one.reset(seed=3)[0].tobytes()
        for action in drawn(one, 20):
            seen, rewards, *_ = many.step(np.stack([action, action]))
            ours, reward, *_ = one.step(action)
            assert seen[0].tobytes() == ours.tobytes()
            assert rewards[0] == reward
        assert seen[1].tobytes() != ours.tobytes()
    finally:
        many.close()


def test_gymnasium_is_loaded_by_its_module_alone():
    code = "import fesloop, fesloop.apps.functions, sys; print('gymnasium' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "False\n"


def test_without_gymnasium_the_remedy_is_named():
    code = ("import sys; sys.modules['gymnasium'] = None\ntry: import fesloop.gym\n"
            "except ImportError as fault: print(fault)")
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "fesloop.gym: gymnasium is not installed; pip install 'fesloop[gym]'\n"
