"""The table [score] of an experiment: which signals are compared with which."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from fesloop.errors import InputError
from fesloop.experiment.metrics.cycles import CycleScore
from fesloop.experiment.metrics.grasp_outcome import GraspScore
from fesloop.experiment.metrics.search import SearchScore
from fesloop.experiment.record_spec import outputs_of
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.nodes import Node
from fesloop.loop.signals import Port


@dataclass(frozen=True, slots=True, kw_only=True)
class IntentionScore:
    """A person's attempts, and the signals that follow them.

    Attributes
    ----------
    attempt: number of the attempt under way, 0 for none (`intention`).
    phase: number of the reference's phase (`triggered_phases`, `proportional_posture`): a change to one above
        0 is a trigger.
    angles: true angles of the hand, rad.
    after_s: attempts and triggers before do not count, such as those of a calibration.
    grace_s: time after an effort in which a trigger still answers it (chosen).
    move_deg: change of an angle since the trigger that counts as movement (chosen).
    """

    attempt: str
    phase: str
    angles: str
    after_s: float = 0.0
    grace_s: float = 0.5
    move_deg: float = 3.0

    def __post_init__(self) -> None:
        for key in ("after_s", "grace_s"):
            duration_ns(getattr(self, key), NS_PER_S, key)
        if not 0.0 < self.move_deg < math.inf:
            raise InputError("move_deg", f"{self.move_deg:g}", "above 0")

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that are compared."""
        return self.attempt, self.phase, self.angles

    def faults(self, shapes: Mapping[str, tuple[int | None, ...]]) -> Iterator[InputError]:
        """Faults: signals that do not exist, or are no single number; `shapes` are those of all outputs."""
        for key in ("attempt", "phase", "angles"):
            name = getattr(self, key)
            if name not in shapes:
                yield InputError(f"score.intention.{key}", f"there is no signal {name!r}",
                                 ", ".join(sorted(shapes)))
            elif key != "angles" and shapes[name] != ():
                yield InputError(f"score.intention.{key}", f"{name!r} has shape {shapes[name]}", "one number")


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Signals that are compared, each named as "node.port".

    Attributes
    ----------
    truth: joint angles of the plant, rad.
    reference: desired angles; with `truth` they give joint_rmse_deg. `truth` alone gives range_deg, the range
        of motion that each joint uses.
    estimate: angles that a tracker estimates; with `truth` they give tracker_rmse_deg.
    orientation: a tracker's orientation quaternions, compared with the reference of the recording that
        the node `recording` plays.
    recording: node that plays a recording.
    joints: names of the joints, keys of their own metrics; empty: 23 angles are the hand's freedoms.
    fingertips: positions of fingertips, (tips, 3), m.
    trackers: nodes whose output `fingertips` is compared with them; gives fingertip_rmse_mm.
    tips: names of the fingertips, keys of their own metrics; empty: F1, F2, ...
    grasp: a grasp of an object. cycles: a contraction that repeats.
    search: a search for elements that cause a movement.
    intention: a person's attempts, and how the hand follows them.
    after_s: initial part of each trial that is not scored. until_s: end of the scored part for joint angles,
        such as before an object is touched; None: the end of the trial.
    """

    truth: str | None = None
    reference: str | None = None
    estimate: str | None = None
    orientation: str | None = None
    recording: str | None = None
    joints: tuple[str, ...] = ()
    fingertips: str | None = None
    trackers: tuple[str, ...] = ()
    tips: tuple[str, ...] = ()
    grasp: GraspScore | None = None
    cycles: CycleScore | None = None
    search: SearchScore | None = None
    intention: IntentionScore | None = None
    after_s: float = 0.0
    until_s: float | None = None

    def __post_init__(self) -> None:
        if self.until_s is not None:
            if not self.until_s > self.after_s:
                raise InputError("until_s", f"{self.until_s:g}", f"above after_s, {self.after_s:g}")
            duration_ns(self.until_s, NS_PER_S, "until_s")
        if not (math.isfinite(self.after_s) and self.after_s >= 0.0):
            raise InputError("after_s", f"{self.after_s}", "0 or more seconds")

    def faults(self, nodes: Sequence[Node], left_out: Sequence[str] = ()) -> list[InputError]:
        """Faults: signals and nodes that do not exist, do not fit, or are `left_out` of the recording."""
        outputs = [name for node in nodes for name, _ in outputs_of(node)]
        signals = [(key, getattr(self, key))
                   for key in ("truth", "reference", "estimate", "orientation", "fingertips")]
        signals += [("trackers", f"{name}.fingertips") for name in self.trackers]
        inner = [("grasp", name) for _, name, _ in self.grasp.signals()] if self.grasp else []
        inner += [("cycles", self.cycles.signal)] if self.cycles else []
        inner += [("search", name) for name in self.search.signals] if self.search else []
        inner += [("intention", name) for name in self.intention.signals] if self.intention else []
        faults = [InputError(f"score.{key}", f"there is no signal {name!r}", ", ".join(sorted(outputs)))
                  for key, name in signals if name is not None and name not in outputs]
        faults += [InputError(f"score.{key}", f"{name!r} is left out of the recording", "what is recorded",
                              "take it out of record.leave_out")
                   for key, name in signals + inner if name in left_out]
        if bool(self.trackers) != (self.fingertips is not None):
            faults.append(InputError("score.trackers", f"{list(self.trackers)} with fingertips "
                                     f"{self.fingertips!r}", "both, or neither"))
        players = [node.name for node in nodes if hasattr(node.part, "source")]
        if self.recording is not None and self.recording not in players:
            faults.append(InputError("score.recording", f"{self.recording!r} plays no recording",
                                     ", ".join(players) or "no node does"))
        if self.orientation is not None and self.recording is None:
            faults.append(InputError("score.recording", "is missing", ", ".join(players) or "no node does",
                                     "name the node whose recording holds the reference"))
        shapes = {name: port.shape for node in nodes for name, port in outputs_of(node)}
        ports = {name: port for node in nodes for name, port in outputs_of(node)}
        faults += self._unit_faults(ports)
        faults += self._angle_faults(ports)
        faults += self._tip_faults(shapes)
        for score in (self.grasp, self.cycles, self.search, self.intention):
            faults += score.faults(shapes) if score is not None else ()
        if self.grasp is not None and self.grasp.pulses is not None:
            faults += _pulse_faults(self.grasp.pulses, nodes)
        tips = shapes.get(self.fingertips or "", ())[:1]
        if self.tips and tips and tips != (len(self.tips),):
            faults.append(InputError("score.tips", f"{len(self.tips)} names", f"{tips[0]}, one a fingertip"))
        named = self.truth or self.estimate
        joints = shapes.get(named or "", ()) or (1,)
        if self.joints and joints != (len(self.joints),) and (named is None or named in shapes):
            faults.append(InputError("score.joints", f"{len(self.joints)} names",
                                     f"as many as the signals have values: {joints}"))
        faults += [InputError("score.joints", f"{name!r} is listed twice", "each joint once")
                   for name in dict.fromkeys(self.joints) if self.joints.count(name) > 1]
        return faults

    def _unit_faults(self, ports: Mapping[str, Port]) -> list[InputError]:
        """Faults: signals in another unit than their score; a signal without a unit ("1") is no angle."""
        read = [(key, getattr(self, key), unit) for key, unit in (
            ("truth", "rad"), ("reference", "rad"), ("estimate", "rad"), ("orientation", "1"),
            ("fingertips", "m"))]
        read += [("trackers", f"{name}.fingertips", "m") for name in self.trackers]
        grasp = self.grasp.units() if self.grasp else ()
        read += [(f"grasp.{key}", name, unit) for key, name, unit in grasp]
        read += [("search.truth", self.search.truth, "rad")] if self.search else []
        read += [("intention.angles", self.intention.angles, "rad")] if self.intention else []
        return [_unit_fault(f"score.{key}", name, ports[name].unit, unit)
                for key, name, unit in read if name in ports and ports[name].unit != unit]

    def _angle_faults(self, ports: Mapping[str, Port]) -> list[InputError]:
        """Faults: signals with another number of angles than the truth; unknown sizes are not checked."""
        truth = ports.get(self.truth or "")
        faults = []
        for key in ("truth", "reference", "estimate"):
            name = getattr(self, key)
            port = ports.get(name or "")
            if port is None or port.unit != "rad":
                continue
            if truth and None not in (*port.shape, *truth.shape) \
                    and (port.shape or (1,)) != (truth.shape or (1,)):
                faults.append(InputError(f"score.{key}", f"{name!r} has shape {port.shape}",
                                         f"{truth.shape}, as {self.truth!r}"))
        return faults

    def _tip_faults(self, shapes: Mapping[str, tuple[int | None, ...]]) -> list[InputError]:
        """Faults: signals that are no positions, or other fingertips than the truth."""
        truth = shapes.get(self.fingertips or "")
        if truth is None:
            return []
        if len(truth) != 2 or truth[1] != 3:
            return [InputError("score.fingertips", f"{self.fingertips!r} has shape {truth}",
                               "(tips, 3), positions")]
        given = {f"{name}.fingertips": shapes.get(f"{name}.fingertips", truth) for name in self.trackers}
        return [InputError("score.trackers", f"{name!r} has shape {shape}",
                           f"{truth}, as {self.fingertips!r}")
                for name, shape in given.items() if None not in shape and shape != truth]


def _unit_fault(where: str, name: str, found: str, unit: str) -> InputError:
    """Fault of a signal in another unit."""
    if found != "1":
        return InputError(where, f"{name!r} is in {found!r}", f"a signal in {unit!r}")
    return InputError(where, f"{name!r} has no unit", f"a signal in {unit!r}",
                      f"if its values are in {unit!r}, set that as the unit of the port "
                      "(`unit` in an FMU's output_ports, `output_unit` of state_space); else leave it out")


def _pulse_faults(signal: str, nodes: Sequence[Node]) -> list[InputError]:
    """Faults: a signal of a node that has no pulse frequency."""
    timed = [node.name for node in nodes if hasattr(node.part, "frequency_hz")]
    if signal.partition(".")[0] in timed or signal.partition(".")[0] not in [node.name for node in nodes]:
        return []
    return [InputError("score.grasp.pulses", f"{signal!r} is of a node without a frequency_hz",
                       "a signal of " + (", ".join(timed) or "a stimulator"))]
