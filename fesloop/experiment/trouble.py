"""Troubles of a run, the most important first, with which its summary and its report begin."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from fesloop.experiment.metrics.grasp_outcome import OUTCOMES
from fesloop.experiment.metrics.stimulation import Rows, Stimulated, commanded_signal, stimulated
from fesloop.experiment.recording.reading import Event, Extent

_STATUSES = {"running": "the run is not over, or was killed", "damaged": "the file of the run is damaged",
             "failed": "the run failed", "interrupted": "the run was interrupted"}
_WATCHDOG = "posture_"
"""Prefix of the statuses with which a safety block removes stimulation."""
_WITHHELD = ("stale_input", "no_posture")
"""Other statuses with which it does, once trackers are aligned: before, nothing is stimulated anyway."""
_UNHEARD = ("no_input", "stale_input")
"""Statuses of other blocks that have received nothing, or nothing new."""
_LIMITED = ("_limited", "_too_short", "_too_small")
"""Suffixes of statuses for limited pulses."""
_LEARNERS = ("ilc",)
"""Kinds of blocks that command nothing in the first trial, before they have learnt."""
_MOST_LOST = 0.5
"""Share of the commanded charge (chosen) below which safety has changed the trial."""
_STOPPED = ("emergency_stop", "charge_exhausted")
"""Statuses of a safety block after which there is no stimulation for the rest of the run."""
_FAILED = ("_failed", "non_finite")
"""Suffixes of statuses that make the metrics of a run doubtful."""
_LACKING = ("recording_incomplete", "repeated_samples")
"""Statuses of a replay whose recording lacks or repeats samples."""
_DISAGREE = "rates_disagree"
"""Status of a replay whose recording contradicts itself."""
_MOUNTING, _TURNING = "mounting_disagrees", "segment_calibration"
"""Status of a replay whose sensors have other axes than their segments, and the block that corrects them."""
_IMPLAUSIBLE = "implausible_angle"
"""Status of a tracker whose angles cannot be those of the joints."""
_MISFIT = "misfit"
"""Status of a tracker with a joint that does not move as its kind does."""
_ALIGNING, _ALIGNED = "aligning", "aligned"
_CONTRADICTED = "pose_contradicted"
"""Status of a tracker whose evidence contradicts the initial pose that it was given."""
_OVERRUN = "rates_beyond_range"
"""Status of a tracker whose gyroscopes have missed a part of a movement."""
_MOVES_DEG = 1.0
"""Distance (chosen) from the joints below which a reference requires no motion."""
_LEAST_ABOUT = 0.5
"""Least share (chosen) of a joint's rotation, squared, about the axis of its angle."""
_MOST_NAMED = 4
_WORSE = 1.01
"""Ratio below which two errors are shown as the same number."""
_ROSE = 1.1
"""Ratio (chosen) of the last trial's error to the first one's that noise does not reach."""
_ABOVE_LEAST, _ABOVE_LEAST_DEG = 2.0, 1.0
"""Ratio and difference (chosen) of the last trial's error and the least. The least of several errors is small
by chance, too: where muscles vary by 30 % from trial to trial, the last is often half as large again."""
_FEEDBACK = ("learning corrects what trials have in common; muscles that vary between them are corrected "
             "within a trial, by predictive control (block `mpc`, as in grasp_mpc)")
_SLOWER = ("the model is wrong, or drives are at their limits: identify the patient again, learn less from "
           "each trial (`memory.share`), or learn nothing (control=mpc)")


class Recorded(Rows, Protocol):
    """The parts of a recording that troubles are found in."""

    @property
    def status(self) -> str:
        """Status of the run at its end."""

    @property
    def trials(self) -> int:
        """Number of trials that have begun."""

    @property
    def events(self) -> Sequence[Event]:
        """All events, in order of time."""

    def extent(self, name: str, trial: int = 0) -> Extent:
        """First and last instant of a signal in a trial."""


@dataclass(frozen=True, slots=True)
class Trouble:
    """A trouble of a run.

    Attributes
    ----------
    kind: of `KINDS`. text: half a sentence.
    alike: whether all trials have it alike, so that it does not keep them from being compared.
    """

    kind: str
    text: str
    alike: bool = False

    @property
    def sentence(self) -> str:
        """The text as a sentence."""
        return f"{self.text[:1].upper()}{self.text[1:]}."


KINDS = ("broken_off", "recording", "pose", "safety", "failed", "noted", "not_held", "no_better", "rose")
"""Kinds of troubles, the most important first.

broken_off: the run did not get to its end. recording: gyroscope and accelerometer of the recording that was
played disagree on rotation, or its sensors have other axes than their segments, or a tracker's angles are
long outside what any joint can reach, so that no angle of the run is right. pose: what the sensors show
contradicts the initial pose that a tracker was given, or its gyroscopes missed a movement after it. safety:
no channel gave a pulse, or the safety block took stimulation away, or most of it. failed: a part failed,
such as a tracker that never took its initial pose. noted: what the experiment says of itself
(`notes`), such as that a model is poor, or a tracker's angle that is not about the axis of the joint's
turning. not_held: the object was not held in the last trial, or the person's attempts were not answered.
no_better: joints followed worse than had they not moved. rose: the last trial's error is more than a tenth
above the first one's, or twice the least and a degree above it, where the trials are `comparable`.
"""


def troubles(recording: Recorded, metrics: Mapping[str, Any], cause: str = "") -> list[Trouble]:
    """Find the troubles of a run, the most important first; `cause` of its failure, if known."""
    found: tuple[Iterable[str | Trouble], ...] = (
        _broken_off(recording, cause), _recording(recording), _pose(recording), _safety(recording, metrics),
        _failures(recording), (*_notes(recording), *_other_axis(metrics)),
        (*_unanswered(metrics), *_not_held(metrics)), _no_better(metrics), _rose(recording, metrics))
    every = [each if isinstance(each, Trouble) else Trouble(kind, each)
             for kind, several in zip(KINDS, found, strict=True) for each in several]
    return every if comparable(every) else [each for each in every if each.kind != "rose"]


def comparable(found: Iterable[Trouble]) -> bool:
    """Return whether the trials of a run were alike, so that their errors can be compared.

    Not so where stimulation was withheld in some, a part failed, a tracker lost its pose in some and not in
    others, or the recording played is not sound.
    """
    return not any(each.kind in ("recording", "pose", "safety", "failed") and not each.alike
                   for each in found)


def graveness(status: str) -> int:
    """Rank of an event's status, the gravest 0: failures, then what takes stimulation away, then the rest."""
    if status.endswith((*_FAILED, *_LACKING, _DISAGREE, _MOUNTING, _IMPLAUSIBLE, _MISFIT, _CONTRADICTED,
                        _OVERRUN)):
        return 0
    withheld = status.startswith(_WATCHDOG) or status in (*_WITHHELD, *_STOPPED)
    return 1 if withheld else 2


def _broken_off(recording: Recorded, cause: str) -> Iterator[str]:
    status = recording.status
    if status != "done":
        words = _STATUSES.get(status, f"the run ended as {status!r}") + reached(recording)
        yield f"{words}: {cause or 'numbers are of what was recorded until then'}"


def reached(recording: Recorded) -> str:
    """How far the recording of a run goes that broke off, as " at 3.2 of 10 s in trial 1 (of 0 to 2)".

    Empty where that is not known, as of a damaged file.
    """
    about, last = recording.experiment.get("experiment", {}), recording.trials - 1
    if recording.status == "damaged" or last < 0 or not recording.signals or "duration_s" not in about:
        return ""
    at_s = max(recording.extent(name, last).last_ns for name in recording.signals) / 1e9
    trials = about.get("trials", 1)
    which = f" in trial {last} (of 0 to {trials - 1})" if trials > 1 else ""
    return f" at {at_s:.3g} of {about['duration_s']:g} s{which}"


def _recording(recording: Recorded) -> Iterator[str]:
    """Troubles of the recording that a replay plays."""
    wrong_as = (_DISAGREE,) if _of_kind(recording, _TURNING) else (_DISAGREE, _MOUNTING)
    yield from dict.fromkeys(f"the recording played by `{event.where}` is wrong: {event.detail}"
                             for event in recording.events if event.status in wrong_as)
    wrong: dict[str, Event] = {}
    for event in recording.events:
        if event.status == _IMPLAUSIBLE:
            wrong.setdefault(event.where, event)
    yield from (f"the angles of `{where}` are wrong{_when(recording, event)}: {event.detail}"
                for where, event in wrong.items())


def _pose(recording: Recorded) -> Iterator[Trouble]:
    """Trackers that were given a wrong initial pose, or have lost it, each once."""
    wrong: dict[str, list[Event]] = {}
    for event in recording.events:
        if event.status in (_CONTRADICTED, _OVERRUN):
            wrong.setdefault(event.where, []).append(event)
    for where, events in wrong.items():
        first, trials = events[0], len({event.trial for event in events})
        which = f" and in {trials} of {recording.trials} trials" if trials > 1 else ""
        yield Trouble("pose", f"the angles of `{where}` are not to be trusted{_when(recording, first)}"
                      f"{which}: {first.detail}", alike=trials == recording.trials)


def _safety(recording: Recorded, metrics: Mapping[str, Any]) -> Iterator[str]:
    """Stimulation that was withheld or taken away, except by what keeps it off until trackers are aligned."""
    blocks = _of_kind(recording, "safety")
    events = [event for event in recording.events if event.where in blocks]
    aligned: dict[int, float] = {event.trial: math.inf for event in recording.events
                                 if event.status == _ALIGNING}
    aligned |= {event.trial: event.time_ns for event in recording.events if event.status == _ALIGNED}
    trials = {block: [stimulated(recording, block, trial, _from_ns(aligned, trial))
                      for trial in range(recording.trials)] for block in sorted(blocks)}
    without = {trial for each in trials.values()
               for trial in _without_pulse(recording, metrics, events, each)}
    stopped = [event for event in events if event.status in _STOPPED]
    if without:
        yield _no_pulse(recording, blocks, sorted(without), trials)
    if stopped:
        first = stopped[0]
        yield f"stimulation ended for good{_when(recording, first)}: {first.where}: {first.detail}"
    ramped = [event for event in events if _took_away(event, aligned) and event.trial not in without
              and not _idle(trials[event.where], event.trial)]
    if ramped:
        first = ramped[0]
        again = f", {len(ramped)} times in all" if len(ramped) > 1 else ""
        yield (f"stimulation was taken away{_when(recording, first)}{again}: {first.where}: {first.status}: "
               f"{first.detail}")
    if not (ramped or stopped):
        yield from _mostly_cut(recording, events, trials, without)


def _from_ns(aligned: Mapping[int, float], trial: int) -> int:
    """Instant at which a trial's trackers are aligned, as far as that is known; else 0."""
    since = aligned.get(trial, 0.0)
    return int(since) if math.isfinite(since) else 0


def _idle(trials: Sequence[Stimulated | None], trial: int) -> bool:
    """Return whether a safety block received no stimulation in a trial."""
    found = trials[trial] if trial < len(trials) else None
    return found is not None and found.commanded == 0.0 and found.passed == 0.0


def _took_away(event: Event, aligned: Mapping[int, float]) -> bool:
    """Return whether a safety block's event removes stimulation that an aligned tracker allows."""
    until = aligned.get(event.trial)
    if event.status == f"{_WATCHDOG}frozen":
        return until is None or event.time_ns > until
    if event.status.startswith(_WATCHDOG):
        return True
    # A tracker that is aligned from the start never says so, and nothing has arrived then.
    return event.status in _WITHHELD and event.time_ns > (0.0 if until in (None, math.inf) else until)


def _without_pulse(recording: Recorded, metrics: Mapping[str, Any], events: Sequence[Event],
                   trials: Sequence[Stimulated | None]) -> Iterator[int]:
    """Trials in which no channel gave a pulse, although there was something to do."""
    blocks = recording.experiment.get("blocks", {})
    learns = any(isinstance(table, dict) and table.get("kind") in _LEARNERS for table in blocks.values())
    still = metrics.get("unmoved_rmse_deg")
    for trial, found in enumerate(trials):
        if found is None or found.given > 0.0 or recording.status != "done":
            continue
        if learns and trial == 0 and found.commanded == 0.0:
            continue
        moves = isinstance(still, list) and trial < len(still) and _finite(still[trial]) \
            and still[trial] > _MOVES_DEG
        kept_off = any(event.trial == trial and event.status in _WITHHELD and event.time_ns > 0
                       for event in events)
        if found.commanded > 0.0 or moves or kept_off:
            yield trial


def _no_pulse(recording: Recorded, blocks: set[str], trials: Sequence[int],
              found: Mapping[str, Sequence[Stimulated | None]]) -> str:
    """Text for trials without a pulse, with the reason: the last status of safety, else of another block.

    Where no pulse came into the safety block, that is why, whatever the block said.
    """
    silent = [source for block in found
              if (each := found[block][trials[0]]) is not None and each.commanded == 0.0
              and (source := commanded_signal(recording, block)) in recording.signals]
    inside = [event for event in recording.events if event.trial == trials[0]]
    told = {event.status for event in inside}
    withheld: tuple[str, ...] = (*_WITHHELD, "negative")
    if _ALIGNED not in told and _ALIGNING in told:
        withheld = (*withheld, "not_aligned")
    kept_off = [event for event in inside if event.where in blocks
                and (event.status in withheld or event.status.startswith(_WATCHDOG))]
    cut = [event for event in inside if event.status.endswith(_LIMITED)
           or (event.where not in blocks and event.status in _UNHEARD)]
    why = kept_off or cut or [event for event in inside if event.where in blocks]
    which = f" in {len(trials)} of {recording.trials} trials" if recording.trials > 1 else ""
    if len(silent) == len(found):
        reason = next((f" ({each})" for each in _begins_never(recording)), "") or next(
            (f" ({each.where}: {each.status}: {each.detail})" for each in reversed(cut)), "")
        return f"no channel gave a pulse{which}: none was commanded: {', '.join(silent)} has none{reason}"
    if not why:
        return f"no channel gave a pulse{which}: nothing was commanded"
    last = why[-1]
    said = f"{last.where}: {last.status}{_when(recording, last)}: {last.detail}"
    return f"no channel gave a pulse{which}: {said}"


def _begins_never(recording: Recorded) -> Iterator[str]:
    """Texts on blocks whose `begin_s` is the end of a trial or later."""
    trial_s = recording.experiment.get("experiment", {}).get("duration_s", math.inf)
    for name, table in recording.experiment.get("blocks", {}).items():
        begin_s = table.get("begin_s", 0.0) if isinstance(table, dict) else 0.0
        if _finite(begin_s) and begin_s >= trial_s:
            yield f"{name}: begin_s is {begin_s:g} s, and a trial ends at {trial_s:g} s"


def _mostly_cut(recording: Recorded, events: Sequence[Event],
                trials: Mapping[str, Sequence[Stimulated | None]], without: set[int]) -> Iterator[str]:
    """Trials in which safety lets through less than half of the charge that is commanded."""
    for block, each in trials.items():
        cut = [(trial, found) for trial, found in enumerate(each) if found is not None
               and trial not in without and found.passed < _MOST_LOST * found.commanded]
        if cut:
            trial, found = cut[-1]
            why = next((f": {event.status}{_when(recording, event)}" for event in events
                        if event.where == block and event.status.endswith(_LIMITED)), "")
            which = f" in trial {trial}" if recording.trials > 1 else ""
            share = 100.0 * found.passed / found.commanded
            yield f"{block} let through {share:.2g} % of the charge that was commanded{which}{why}"


def _failures(recording: Recorded) -> Iterator[str]:
    """Parts that failed, samples that a recording lacks, and trackers that never aligned."""
    done: set[tuple[str, str]] = set()
    events = recording.events
    yield from dict.fromkeys(f"the recording played by `{event.where}` lacks samples: {event.detail}"
                             for event in events if event.status in _LACKING)
    for event in events:
        if not event.status.endswith(_FAILED) or event.status.startswith(_WATCHDOG):
            continue
        if (event.where, event.status) in done:
            continue
        done.add((event.where, event.status))
        later = next((each for each in events if each.where == event.where and each.trial == event.trial
                      and each.status == _ALIGNED and each.time_ns > event.time_ns), None)
        never = "" if later is None else f"; aligned{_when(recording, later)} only"
        if later is None and event.status.startswith("initial_pose"):
            never = "; never aligned in that trial"
        yield f"{event.where}: {event.status}{_when(recording, event)}: {event.detail}{never}"
    aligned = {(event.where, event.trial) for event in events if event.status == _ALIGNED}
    blocks = recording.experiment.get("blocks", {})
    for event in events:
        knows = "initial_pose_s" in blocks.get(event.where, ()) \
            or any(where == event.where for where, _ in aligned)
        failed = any(where == event.where for where, _ in done)
        if event.status == _ALIGNING and knows and not failed and (event.where, event.trial) not in aligned:
            yield f"{event.where}: never aligned in trial {event.trial}"
            return


def _notes(recording: Recorded) -> Iterator[str]:
    about = recording.experiment.get("experiment", {})
    yield from (str(note) for note in about.get("notes", ()) if note)


def _other_axis(metrics: Mapping[str, Any]) -> Iterator[str]:
    """Joints of a replay whose angle is about an axis that they hardly turn about."""
    shares = metrics.get("flexion_axis_share")
    few = [f"{pair} ({100.0 * share:.2g} %)" for pair, share in shares.items()
           if _finite(share) and share < _LEAST_ABOUT] if isinstance(shares, dict) else []
    if few:
        more = f" and {len(few) - _MOST_NAMED} more" if len(few) > _MOST_NAMED else ""
        which = ", ".join(few[:_MOST_NAMED])
        yield (f"angles are about z, about which little of the joints' turning is: {which}{more}: they rest "
               "on sensors whose axes are their segments'; state them (`sensors.NAME.axes` in the layout) or "
               "calibrate (block `segment_calibration`), unless a joint does not flex")


def _unanswered(metrics: Mapping[str, Any]) -> Iterator[str]:
    """Attempts of the last trial that no trigger answered."""
    missed, answered = metrics.get("missed_triggers"), metrics.get("intention_to_reference_s")
    if isinstance(missed, list) and missed and missed[-1]:
        never = isinstance(answered, list) and answered and not _finite(answered[-1])
        yield (f"{missed[-1]} of the person's attempts were not answered"
               + (": the reference never moved, and errors are those of a hand at rest" if never else ""))


def _not_held(metrics: Mapping[str, Any]) -> Iterator[str]:
    """Text on how often the object was held, and why not, if the last trial did not hold it."""
    held = metrics.get("held")
    if not isinstance(held, list) or not held or held[-1] is not False:
        return
    outcomes = metrics.get("object_outcome") or []
    reasons: dict[str, list[int]] = {}
    for trial, (each, outcome) in enumerate(zip(held, outcomes, strict=False)):
        if each is False and outcome in OUTCOMES:
            reasons.setdefault(OUTCOMES[outcome], []).append(trial)
    lost = held.count(False)
    alike = len(reasons) == 1 and len(next(iter(reasons.values()))) == lost
    why = "; ".join(text if alike else f"{text} ({_trials(trials)})" for text, trials in reasons.items())
    if len(held) == 1:
        how = "not held"
    else:
        how = f"held in {held.count(True) or 'none'} of {len(held)} trials"
        how += f" (unknown for {held.count(None)})" if None in held else ""
        how += ", not in the last" if any(held) else ""
    yield f"the object was {how}{': ' if why else ''}{why}"


def _trials(numbers: Sequence[int]) -> str:
    """Trials in words: trial 2, or trials 0, 2 and 3."""
    if len(numbers) == 1:
        return f"trial {numbers[0]}"
    return f"trials {', '.join(map(str, numbers[:-1]))} and {numbers[-1]}"


def _no_better(metrics: Mapping[str, Any]) -> Iterator[str]:
    """Joints that followed worse than if they had stayed where the trial began, or as badly."""
    errors, still = metrics.get("joint_rmse_deg"), metrics.get("unmoved_rmse_deg")
    if not (isinstance(errors, list) and isinstance(still, list) and errors and len(still) == len(errors)):
        return
    if _finite(errors[-1]) and _finite(still[-1]) and errors[-1] > still[-1] > _MOVES_DEG:
        which = f" in the last of {len(errors)} trials" if len(errors) > 1 else ""
        how = "worse" if errors[-1] > _WORSE * still[-1] else "no better"
        yield (f"the joints followed {how}{which} than if they had not moved ({errors[-1]:.3g} deg RMS; "
               f"{still[-1]:.3g} deg had they stayed where the trial began)")


def _rose(recording: Recorded, metrics: Mapping[str, Any]) -> Iterator[str]:
    """Text on a last trial that is worse than the first one or, by a wider margin, than the best one."""
    errors = metrics.get("joint_rmse_deg")
    if not isinstance(errors, list) or len(errors) < 2 or not _finite(errors[-1]):
        return
    first, last = errors[0], errors[-1]
    best = min((trial for trial, error in enumerate(errors) if _finite(error)), key=errors.__getitem__)
    learns = any(_of_kind(recording, kind) for kind in _LEARNERS)
    remembers = any(isinstance(table, dict) and isinstance(table.get("memory"), dict)
                    for table in recording.experiment.get("blocks", {}).values())
    remedy = f": {_FEEDBACK}" if learns else f": {_SLOWER}" if remembers else ""
    if _finite(first) and last > _ROSE * first:
        yield (f"the tracking error rose from {first:.3g} deg RMS in the first of {len(errors)} trials "
               f"to {last:.3g} deg in the last, and was least in trial {best}, {errors[best]:.3g} deg"
               f"{remedy}")
    elif last > max(_ABOVE_LEAST * errors[best], errors[best] + _ABOVE_LEAST_DEG):
        yield (f"the tracking error is {last:.3g} deg RMS in the last of {len(errors)} trials, and was "
               f"{errors[best]:.3g} deg in trial {best}{remedy}")


def _finite(value: Any) -> bool:
    return isinstance(value, (int, float)) and bool(np.isfinite(value))


def _of_kind(recording: Recorded, kind: str) -> set[str]:
    blocks = recording.experiment.get("blocks", {})
    return {name for name, table in blocks.items() if isinstance(table, dict) and table.get("kind") == kind}


def _when(recording: Recorded, event: Event) -> str:
    trial = f" of trial {event.trial}" if recording.trials > 1 else ""
    return f" at {event.time_ns / 1e9:.3g} s{trial}"
