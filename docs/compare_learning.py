"""Compare a learning agent with PID, predictive control and iterative learning on persons it has never seen.

    pip install 'fesloop[rl]'
    python docs/compare_learning.py --out learning

PPO (stable-baselines3) learns to open and close the free hand (`fesloop/Hand-v0`) of members 100 and up of a
cohort of virtual patients, each with a latency of the tracker of its own; the network sees what a controller
reads, and its own last action. It is judged on members 0 to 9 at 0, 100 and 200 ms, beside controllers whose
model was identified on each of these persons in three minutes. All are scored alike, on the recording of a
run: the agent's pulses are played by a block in the controller's place, which is the same to the bit.

Takes 15 minutes of one core for training and about ten for the rest, and prints a table; learning/result.json
has all runs.
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

import fesloop
from fesloop.experiment.metrics.grasp import charge_c
from fesloop.gym import LoopEnv, free_hand

PERSON = ("cohort=1", "tracker=ideal")
FREE = ("scene=free", "score.until_s=10")
TRAINED, JUDGED = range(100, 116), range(10)
LATENCIES_MS, JUDGED_MS = (0, 50, 100, 150, 200), (0, 100, 200)
AHEAD = (0, 4, 9, 14, 19)
"""Coming references that the network sees, in periods of 25 ms."""


class Persons(gymnasium.Wrapper):
    """Episodes of several persons, one after the other, as one environment.

    The observation is the measured angles, their age, coming references (rad, s), and the last action. An
    action below 0 is no drive.
    """

    def __init__(self, envs: Sequence[LoopEnv]) -> None:
        super().__init__(envs[0])
        self._envs, self._turn = envs, 0
        names = envs[0].observation_names
        self._seen = [k for k, name in enumerate(names) if name.startswith("measured") or (
            name.startswith("reference_preview[") and int(name.split("[")[1].split(",")[0]) in AHEAD)]
        self._channels = envs[0].action_space.shape[0]
        self.observation_space = spaces.Box(-np.inf, np.inf, (len(self._seen) + self._channels,), np.float64)
        self.action_space = spaces.Box(-1.0, 1.0, (self._channels,), np.float32)

    def reset(self, **given: Any) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode of the next person."""
        self._turn += 1
        self.env = self._envs[self._turn % len(self._envs)]
        observation, info = self.env.reset(**given)
        return self._observed(observation, np.zeros(self._channels)), info

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Act."""
        drive = np.clip(action, 0.0, 1.0).astype(np.float64)
        observation, reward, terminated, truncated, _ = self.env.step(drive)
        return self._observed(observation, drive), reward, terminated, truncated, {"drive": drive}

    def _observed(self, observation: np.ndarray, drive: np.ndarray) -> np.ndarray:
        return np.concatenate([observation[self._seen], drive])


def person(member: int, latency_ms: float) -> LoopEnv:
    """The free hand of a member, with the conversion of drives of an ordinary patient."""
    return free_hand([*PERSON, f"member={member}", "any_patient=true", f"tracker_latency_ms={latency_ms}"])


class Rewards(BaseCallback):
    """Keeps the mean reward of episodes."""

    def __init__(self) -> None:
        super().__init__()
        self.rewards: list[float] = []

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        infos = self.model.ep_info_buffer
        if infos:
            self.rewards.append(float(np.mean([info["r"] for info in infos])))
            print(f"{self.num_timesteps} steps, {time.process_time():.0f} s: reward {self.rewards[-1]:.2f}",
                  flush=True)


def trained(steps: int, seed: int) -> tuple[PPO, VecNormalize, Rewards]:
    """Train on the members 100 and up, each at one of the latencies."""
    from stable_baselines3.common.monitor import Monitor

    envs = [person(member, LATENCIES_MS[k % len(LATENCIES_MS)]) for k, member in enumerate(TRAINED)]
    groups = [envs[k::4] for k in range(4)]
    many = VecNormalize(DummyVecEnv([lambda group=group: Monitor(Persons(group)) for group in groups]),
                        gamma=0.97)
    model = PPO("MlpPolicy", many, n_steps=800, batch_size=400, n_epochs=10, gamma=0.97, learning_rate=5e-4,
                seed=seed, device="cpu", policy_kwargs={"log_std_init": -1.0})
    rewards = Rewards()
    model.learn(steps, callback=rewards)
    return model, many, rewards


@dataclass(frozen=True, kw_only=True)
class Played:
    """Pulses of an agent, in the place of the controller whose ports these are."""

    inputs: tuple = ()
    outputs: tuple = ()
    pulses: tuple = ()

    def init(self, context: Any) -> None:
        """No state."""

    def step(self, state: None, inputs: Any, tick: Any) -> tuple[np.ndarray]:
        """Pulses of this tick."""
        return (np.array(self.pulses[min(tick.index, len(self.pulses) - 1)]),)


def of_agent(model: PPO, many: VecNormalize, member: int, latency_ms: float, out: Path) -> dict[str, float]:
    """Error and charge of an episode without exploration."""
    env = Persons([person(member, latency_ms)])
    observation, _ = env.reset(seed=1)
    drives, over = [], False
    while not over:
        action, _ = model.predict(many.normalize_obs(observation), deterministic=True)
        observation, _, _, over, info = env.step(action)
        drives.append(info["drive"])
    pulses = tuple(env.env.pulses(drive).tolist() for drive in drives)
    given = fesloop.load("grasp_mpc", [*FREE, *PERSON, f"member={member}", "any_patient=true",
                                       f"tracker_latency_ms={latency_ms}"], 1)
    ports = given.wiring.node("controller").part
    played = Played(inputs=ports.inputs, outputs=ports.outputs, pulses=pulses)
    nodes = tuple(replace(node, part=played, rate="40") if node.name == "controller" else node
                  for node in given.nodes)
    return judged(fesloop.Experiment(
        name="agent", nodes=nodes, wires=given.wires, score=given.score, seed=1,
        duration_s=given.duration_s, record=given.record, patient=given.patient).run(out))


def judged(result: fesloop.Result) -> dict[str, float]:
    """Error of the last trial, deg RMS, and the charge of one phase of all its pulses, mC."""
    with fesloop.Recording(result.recording) as recording:
        given = recording.signal("stimulator.charge", recording.trials - 1)
        hertz = float(Fraction(recording.experiment["blocks"]["stimulator"]["frequency_hz"]))
        charge_mc = 1e3 * charge_c(given.times_ns / 1e9, given.values, hertz)
    return {"error_deg": result.metrics["joint_rmse_deg"][-1], "charge_mc": charge_mc}


CONTROLLERS = {
    "PID, tuned by the person's model": ("grasp_mpc", ["control=tuned_pid"]),
    "MPC, the person's model": ("grasp_mpc", []),
    "ILC, the person's model, third trial": ("grasp_ilc", ["trials=3"]),
    "MPC, an ordinary model": ("grasp_mpc", ["any_patient=true"])}


def of_controllers(member: int, latency_ms: float, model: str,
                   out: Path) -> Iterator[tuple[str, dict[str, float]]]:
    """Error and charge of each controller, by a person's model or, with `any_patient`, an ordinary one."""
    for name, (experiment, settings) in CONTROLLERS.items():
        own = [] if "any_patient=true" in settings else [f"model={model}"]
        given = [*FREE, *PERSON, f"member={member}", f"tracker_latency_ms={latency_ms}", *settings, *own]
        try:
            yield name, judged(fesloop.run(experiment, given, seed=1, out=out))
        except fesloop.InputError as fault:
            print(f"member {member}: {name}: {fault}")


def identified(member: int, out: Path) -> str:
    """Model file of a person, from three minutes of stimulation; empty if it explains too little."""
    target = out / f"model-{member}.toml"
    if not target.exists():
        result = fesloop.run("identify_grasp", [*PERSON, f"member={member}"], seed=1, out=out / "runs")
        fesloop.identify(result).save(target)
    return str(target)


def interval(values: Sequence[float], rng: np.random.Generator) -> tuple[float, float, float]:
    """Mean, and its 95 % interval by bootstrap over persons."""
    drawn = rng.choice(values, (4000, len(values))).mean(axis=1)
    return float(np.mean(values)), *(float(each) for each in np.quantile(drawn, [0.025, 0.975]))


def table(rows: Sequence[dict[str, Any]]) -> str:
    """Rows of a Markdown table: error and charge of each controller at each latency."""
    rng, lines = np.random.default_rng(0), []
    for name in dict.fromkeys(row["controller"] for row in rows):
        cells = []
        for latency in JUDGED_MS:
            there = [row for row in rows if (row["controller"], row["latency_ms"]) == (name, latency)]
            mean, low, high = interval([row["error_deg"] for row in there], rng)
            charge = np.mean([row["charge_mc"] for row in there])
            persons = "" if len(there) == len(JUDGED) else f", {len(there)} persons"
            cells.append(f"{mean:.1f} ({low:.1f} to {high:.1f}), {charge:.1f} mC{persons}")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    head = " | ".join(f"{latency} ms" for latency in JUDGED_MS)
    return "\n".join([f"| controller | {head} |", "|---" * (1 + len(JUDGED_MS)) + "|", *lines])


def main() -> None:
    """Train, judge, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("learning"))
    parser.add_argument("--steps", type=int, default=422_400, help="of training")
    parser.add_argument("--persons", type=int, default=len(JUDGED), help="how many are judged")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    torch.set_num_threads(1)
    warnings.filterwarnings("ignore", category=UserWarning)
    given.out.mkdir(parents=True, exist_ok=True)
    began = time.process_time()
    model, many, rewards = trained(given.steps, given.seed)
    cpu_hours = (time.process_time() - began) / 3600.0
    model.save(given.out / "policy.zip")
    many.save(str(given.out / "normalisation.pkl"))
    many.training = False
    rows = []
    for member in range(given.persons):
        own = identified(member, given.out)
        for latency in JUDGED_MS:
            found = [("PPO", of_agent(model, many, member, latency, given.out / "runs"))]
            found += of_controllers(member, latency, own, given.out / "runs")
            rows += [{"controller": name, "member": member, "latency_ms": latency, **each}
                     for name, each in found]
            print(rows[-len(found):], flush=True)
    found = {"steps": model.num_timesteps, "cpu_hours": cpu_hours, "rewards": rewards.rewards, "rows": rows}
    (given.out / "result.json").write_text(json.dumps(found, indent=1) + "\n")
    print(f"{model.num_timesteps} steps, {cpu_hours:.2f} hours of processor time")
    print(table(rows))


if __name__ == "__main__":
    main()
