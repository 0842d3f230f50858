"""Fits a tracker's error process to one half of recordings, and judges it by the other halves."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.tracker_error.error_record import ErrorRecord
from fesloop.analysis.tracker_error.judging import Judgement, judge
from fesloop.analysis.tracker_error.measured_errors import MeasuredErrors, measured_errors
from fesloop.analysis.tracker_error.series_fit import FEWEST, SeriesFit, fit_series
from fesloop.errors import InputError, InputErrors
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording, Signal
from fesloop.experiment.running import Experiment
from fesloop.given_files import exists
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.wire import least_burst
from fesloop.models.correlation import correlation_of
from fesloop.models.error_process import ErrorProcess
from fesloop.models.error_steps import along
from fesloop.streams.blocks.replay import Replay
from fesloop.streams.formats.published import CHAIN5
from fesloop.streams.motion_file import FORMAT as MOTION
from fesloop.streams.reading import form_of

_STEADY_NS = NS_PER_MS // 100
"""Difference below which ages are equal (chosen: without effect in a loop)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageTimes:
    """Least age of estimates, the random age above it, loss and its bursts, as in `ErrorProcess`."""

    age_ms: float
    jitter: Duration
    loss: float
    burst_messages: float


def message_times(signal: Signal, lost: NDArray[np.bool_], before_ns: int) -> MessageTimes:
    """Age and loss of the estimates that the tracker sent before an instant.

    An estimate is lost where its newest capture is not later than that of the one before, or where a sample
    for it was lost (`lost`, (ticks,)). The age above the least is modelled as exponential.
    """
    early = (signal.times_ns < before_ns) & (signal.newest_ns >= 0)
    newest = signal.newest_ns[early]
    if newest.size < 2:
        return MessageTimes(age_ms=0.0, jitter=ZERO, loss=0.0, burst_messages=0.0)
    missing = lost[early] | (np.diff(newest, prepend=-1) <= 0)
    ages = (signal.left_ns[early] - newest)[~missing]
    least = int(ages.min()) if ages.size else 0
    above_ms = (ages - least) / NS_PER_MS
    jitter = ZERO
    if ages.size and above_ms.max() * NS_PER_MS > _STEADY_NS:
        jitter = Duration(kind="exponential", mean_ms=float(above_ms.mean()), high_ms=float(above_ms.max()))
    share, burst = _bursts(missing)
    return MessageTimes(age_ms=least / NS_PER_MS, jitter=jitter, loss=share, burst_messages=burst)


def sample_ms(signal: Signal) -> float:
    """Median time between the captures of estimates, ms; 0 for fewer than two."""
    steps = np.diff(np.unique(signal.newest_ns[signal.newest_ns >= 0]))
    return float(np.median(steps)) / NS_PER_MS if steps.size else 0.0


def _bursts(missing: NDArray[np.bool_]) -> tuple[float, float]:
    """Share of missing estimates, and mean number of them in a row; 0 where none is missing."""
    count = int(missing.sum())
    if not count or count == missing.size:
        return (0.0, 0.0)
    begins = int(missing[0]) + int((missing[1:] & ~missing[:-1]).sum())
    share = count / missing.size
    return share, max(count / begins, least_burst(share))


PLAYER = "hil_replay"
"""Shipped experiment that plays a recording through a tracker."""
Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Differences:
    """Parts of an angle's error in the first half of each of several recordings.

    Attributes
    ----------
    angle: its name.
    bias_deg: constant parts. lead_ms: leads of the estimates, of regressions of their own.
    random_deg: RMS of the rest, once the process's constant part and what follows from the motion are
        subtracted.
    """

    angle: str
    bias_deg: tuple[float, ...]
    lead_ms: tuple[float, ...]
    random_deg: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FittedError:
    """An error process and its judgements.

    Attributes
    ----------
    process: fitted on the first halves of the recordings.
    recordings: recordings and their trackers, in words.
    judgements: on the second half of each recording, in turn, one per angle.
    differences: of each angle between recordings; empty for one recording.
    too_slow: angles whose error changes too slowly to be estimated from the fitted half.
    left_out: angles with too few known errors in either half.
    ahead_ms: median `lead_s` of the moved angles; negative where the estimates lag. No tracker leads by more
        than `half_sample_ms`: beyond that the reference is late (`reference_late_ms` corrects it).
    half_sample_ms: half the period of the tracker's samples. A tracker that applies the newest rate to the
        whole period before it, as VQF does, leads by so much where gyroscopes sample an instant.
    recorded_reference: whether the errors are against a recording's reference rather than a simulation's
        truth.
    trackers: kinds of the trackers that played recordings, each once.
    fitted_s, judged_s: length of both halves. from_s: beginning of the first, the scored part once aligned.
    """

    process: ErrorProcess
    recordings: tuple[str, ...]
    judgements: tuple[Judgement, ...]
    differences: tuple[Differences, ...]
    too_slow: tuple[str, ...]
    left_out: tuple[str, ...]
    ahead_ms: float
    half_sample_ms: float
    recorded_reference: bool
    trackers: tuple[str, ...]
    fitted_s: float
    judged_s: float
    from_s: float

    def report(self) -> dict[str, Any]:
        """The fit as plain tables."""
        each = len(self.judgements) // len(self.recordings)
        angles = [{"recording": number // each + 1, **judgement.as_table()}
                  for number, judgement in enumerate(self.judgements)]
        return {"source": self.process.source, "recordings": list(self.recordings),
                "fitted_s": self.fitted_s, "judged_s": self.judged_s, "from_s": self.from_s,
                "ahead_ms": self.ahead_ms, "half_sample_ms": self.half_sample_ms,
                "recorded_reference": self.recorded_reference, "trackers": list(self.trackers),
                "age_ms": self.process.age_ms, "loss": self.process.loss,
                "angles": angles, "differences": [asdict(each) for each in self.differences],
                "too_slow_to_tell": list(self.too_slow), "left_out": list(self.left_out)}


def fit_error(*paths: str, settings: tuple[str, ...] = (), reference_late_ms: float = 0.0, seed: int = 0,
              progress: Progress | None = None) -> FittedError:
    """Fit the error process of a tracker.

    Parameters
    ----------
    paths: runs (.h5) that score a tracker against a reference or a truth; or recordings of inertial sensors
        with a reference, which `hil_replay` then plays. One process is fitted to all of them.
    settings: of these runs, "KEY=VALUE" each, such as "tracker=vqf". The default tracker is that of
        `hil_replay`, or `constrained` for the sensors of chain5, whose joints are known.
    reference_late_ms: delay of the stamps of the recording's reference: see `FittedError`.
    seed: of the runs of the process by which it is judged.
    progress: called with the fitted share.

    Raises InputError for a run or a recording with nothing, or too little, to compare.
    """
    if not math.isfinite(reference_late_ms):
        raise InputError("--reference-late", f"{reference_late_ms}", "a finite number of ms")
    late_ns = round(reference_late_ms * NS_PER_MS)
    return fit_measured(*(_measured(path, settings, late_ns) for path in paths), seed=seed, progress=progress)


def _measured(path: str, settings: tuple[str, ...], late_ns: int) -> MeasuredErrors:
    """Errors in a run, or in a recording that is played."""
    if not exists(Path(path)):
        raise InputError(path, "there is no such file",
                         "a run (.h5), or a recording of sensors with a reference",
                         "paths start from the current folder, FESLOOP_RECORDINGS or not")
    if _is_run(path):
        if settings:
            raise InputError(f"--set {settings[0]}", f"is given for {path}, which is a finished run",
                             "settings for a recording of sensors only")
        with Recording(path) as recording:
            return measured_errors(recording, late_ns)
    with (TemporaryDirectory() as folder,
          Recording(player(path, settings).run(folder).recording) as recording):
        return measured_errors(recording, late_ns)


def player(path: str, settings: tuple[str, ...]) -> Experiment:
    """`hil_replay` of a recording; a chain with known joints is tracked by `constrained` by default."""
    given = f"recording={path}", *settings
    try:
        experiment = load(PLAYER, given)
    except InputError as fault:  # of an experiment that the user did not name
        raise _without(f"{PLAYER}: blocks.recording: ", fault) from None
    if any(setting.startswith(("tracker=", "blocks.tracker.")) for setting in settings):
        return experiment
    played = [node.part.source for node in experiment.nodes if isinstance(node.part, Replay)]
    chain = any(source.source_format == CHAIN5 for source in played)
    return load(PLAYER, (*given, "tracker=constrained")) if chain else experiment


def _without(prefix: str, fault: InputError) -> InputError:
    """The fault, its place without a prefix."""
    each = [InputError(one.where.removeprefix(prefix), one.found, one.allowed, one.remedy)
            for one in (fault.faults if isinstance(fault, InputErrors) else [fault])]
    return InputErrors(each) if len(each) > 1 else each[0]


def _is_run(path: str) -> bool:
    """Whether a file is a run rather than a recording of sensors; both may be HDF5."""
    if not path.endswith(".h5"):
        return False
    try:
        return not form_of(Path(path)).startswith(MOTION)
    except InputError:  # a run under way or killed, or no run: opening it as a run reports which
        return True


def fit_measured(*measured: MeasuredErrors, seed: int = 0, progress: Progress | None = None) -> FittedError:
    """Fit a process to the first halves of measured errors, and judge it by the second ones.

    Raises InputError where no angle has enough known errors in both halves of each recording.
    """
    records = [{record.name: record for record in each.records} for each in measured]
    names = list(dict.fromkeys(name for some in records for name in some))
    halves = {name: [_halves(some[name], each.cut_s) for some, each in zip(records, measured, strict=True)]
              for name in names if all(name in some for some in records)}
    sources = tuple(each.source for each in measured)
    if not halves:
        raise InputError(", ".join(sources), "have no angle in common", "recordings of the same joints")
    enough = {name: pairs for name, pairs in halves.items()
              if min(int(half.known.sum()) for pair in pairs for half in pair) >= FEWEST}
    if not enough:
        raise InputError(", ".join(sources), f"no angle has {FEWEST} known errors in both halves",
                         "a longer recording with a reference")
    fits = []
    for number, pairs in enumerate(enough.values()):
        fits.append(fit_series(*(first for first, _ in pairs)))
        if progress is not None:
            progress((number + 1) / len(enough))
    times = _pooled([message_times(each.estimates, each.lost, round(each.cut_s * NS_PER_S))
                     for each in measured])
    matrix = correlation_of([fit.innovations for fit in fits])
    process = ErrorProcess(
        series=tuple(fit.series for fit in fits), correlation=tuple(map(tuple, matrix.tolist())),
        age_ms=times.age_ms, jitter=times.jitter, loss=times.loss, burst_messages=times.burst_messages,
        source="; ".join(sources))
    judgements = tuple(judge(fit, *pairs[number], seed) for number in range(len(measured))
                       for fit, pairs in zip(fits, enough.values(), strict=True))
    leads = [fit.series.lead_s for fit in fits if fit.series.moved]
    return FittedError(
        process=process, recordings=sources, judgements=judgements,
        differences=tuple(map(_differences, fits, enough.values())) if len(measured) > 1 else (),
        ahead_ms=1e3 * float(np.median(leads)) if leads else 0.0,
        half_sample_ms=0.5 * float(np.median([sample_ms(each.estimates) for each in measured])),
        recorded_reference=any(each.recorded for each in measured),
        trackers=tuple(dict.fromkeys(each.tracker for each in measured if each.tracker)),
        fitted_s=_length(enough, 0), judged_s=_length(enough, 1),
        from_s=float(next(iter(enough.values()))[0][0].times_s[0]),
        too_slow=tuple(fit.series.name for fit in fits if fit.too_slow),
        left_out=tuple(name for name in names if name not in enough))


Halves = tuple[ErrorRecord, ErrorRecord]


def _halves(record: ErrorRecord, cut_s: float) -> Halves:
    return record.part(-float("inf"), cut_s), record.part(cut_s, float("inf"))


def _differences(fit: SeriesFit, pairs: list[Halves]) -> Differences:
    """Parts of an angle's error in each first half."""
    leads, rests = [], []
    row = replace(fit.series, bias_deg=0.0).row()
    for (first, _), bias_deg in zip(pairs, fit.biases_deg, strict=True):
        known = first.known
        rest = first.error - along(row, first.angle, first.rate) - math.radians(bias_deg)
        rests.append(math.degrees(float(np.sqrt(np.mean(np.square(rest[known]))))))
        design = np.stack([np.ones(known.sum()), first.angle[known], first.rate[known]], axis=1)
        leads.append(1e3 * float(np.linalg.lstsq(design, first.error[known], rcond=None)[0][2]))
    return Differences(angle=fit.series.name, bias_deg=fit.biases_deg, lead_ms=tuple(leads),
                       random_deg=tuple(rests))


def _pooled(times: list[MessageTimes]) -> MessageTimes:
    """Age and loss of the messages of several recordings, each with the same weight."""
    if len(times) == 1:
        return times[0]
    least = min(each.age_ms for each in times)
    mean = float(np.mean([each.age_ms + (each.jitter.mean_ms or 0.0) for each in times])) - least
    high = max(each.age_ms + (each.jitter.high_ms or 0.0) for each in times) - least
    lossy = [each.burst_messages for each in times if each.burst_messages]
    loss = float(np.mean([each.loss for each in times]))
    return MessageTimes(
        age_ms=least, loss=loss,
        burst_messages=max(float(np.mean(lossy)), least_burst(loss)) if lossy else 0.0,
        jitter=Duration(kind="exponential", mean_ms=mean, high_ms=high) if mean > 0.0 else ZERO)


def _length(halves: Mapping[str, list[Halves]], which: int) -> float:
    """Sum of the lengths of one half of each recording, s."""
    return sum(float(np.ptp(pair[which].times_s)) for pair in next(iter(halves.values())))
