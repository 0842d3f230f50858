"""Film of a recorded trial: the hand with its tracker's estimate, stimulation and time."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.files.patients import describe
from fesloop.experiment.recording.reading import Recording
from fesloop.hand import quaternion
from fesloop.loop.clock import NS_PER_S
from fesloop.show.best_trial import best_trial
from fesloop.show.film.panel import MOST_CHANNELS, TRUE_KEY, Channel, Panel, estimate_key
from fesloop.show.film.stage import Picture, Stage, drawing_surface
from fesloop.show.film.writers import FASTEST_HZ, writer_of
from fesloop.show.picture.cast import cast_of
from fesloop.show.picture.hand_mesh import Mesh
from fesloop.show.report.motion import hand_of, recorded_spans, view_into
from fesloop.show.report.recorded_hand import ESTIMATE, TRUTH, HandsAt, RecordedHand, hands_at, holdable

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
Progress = Callable[[float], None]
_FPS = {".mp4": Fraction(30), ".gif": Fraction(20)}
_SMALLEST_PX, _LARGEST_PX = 240, 3840
_SLOWEST, _FASTEST = 0.01, 100.0
_MOST_PICTURES = 20000
"""More pictures than eleven minutes of film (chosen: some hours of work)."""
_TOGETHER, _LOOKED_AT = 100, 60
"""Instants that are read together, and those by which the camera is placed."""
_FOREARM_SHARE = 0.5
"""Share of the shown forearm that is sure to be in the picture."""
_MARGIN_M = 0.008
_NEAR_M = 0.25
"""Distance from the wrist beyond which an object is not followed by the camera."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cut:
    """Part of a run that is filmed, and how.

    Attributes
    ----------
    trial: counted from 0; None: the best (`fesloop.show.best_trial`).
    from_s, until_s: instants of the trial; None: its recorded ends.
    fps: pictures a second of the film; None: 30, of a GIF 20.
    width, height: pixels. speed: seconds of the trial a second of film.
    """

    trial: int | None = None
    from_s: float | None = None
    until_s: float | None = None
    fps: float | None = None
    width: int = 1280
    height: int = 720
    speed: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Filmed:
    """A film: its file, trial, first and last instant, s, number of pictures, and notes on what it lacks."""

    path: Path
    trial: int
    from_s: float
    until_s: float
    fps: float
    pictures: int
    notes: tuple[str, ...]


def film(recording: Recording, out: Path, cut: Cut, progress: Progress = lambda share: None) -> Filmed:
    """Film a trial.

    `out`: file that ends in .mp4 or .gif; one of this name is replaced when the film is complete.

    Raises
    ------
    InputError: for a recording without a hand or without rows, a trial, instant, rate or size that cannot be,
        another suffix, a file that cannot be written, or where MP4 or OpenGL is not installed.
    RunError: where the encoder is missing.
    """
    write = writer_of(out)
    fps = _rate(cut, out)
    hand = hand_of(recording)
    spans = {} if hand is None else recorded_spans(recording, hand)
    if hand is None or not spans:
        found = "has no hand to film" if hand is None else f"holds no row of a hand (run {recording.status})"
        raise InputError(str(recording.path), found, "a recording of a hand, of a tracker with its 23 "
                         "angles, or of a finger whose three are scored")
    trial = _trial(recording, cut, spans)
    at_ns = _instants(cut, trial, spans[trial], fps)
    notes: list[str] = []
    _require_writable(out)
    part = out.with_name(f".{out.stem}.part{out.suffix}")
    try:
        with drawing_surface(cut.width, cut.height):
            write(part, _pictures(recording, hand, trial, at_ns, cut, notes, progress), fps)
        part.replace(out)
    except OSError as fault:
        raise InputError(f"--out {out}", f"cannot be written: {fault.strerror or fault}",
                         "a file in a writable folder with room") from None
    finally:
        part.unlink(missing_ok=True)
    return Filmed(path=out, trial=trial, from_s=float(at_ns[0]) / NS_PER_S,
                  until_s=float(at_ns[-1]) / NS_PER_S, fps=float(fps), pictures=len(at_ns),
                  notes=tuple(notes))


def _rate(cut: Cut, out: Path) -> Fraction:
    """Pictures a second. Raises InputError for numbers of a cut that cannot be."""
    suffix = out.suffix.lower()
    most = FASTEST_HZ[suffix]
    fps = _FPS[suffix] if cut.fps is None else cut.fps
    if not 1.0 <= fps <= most:
        raise InputError(f"--fps {float(fps):g}", f"is no rate of a film {suffix}", f"1 to {most}")
    if not _SLOWEST <= cut.speed <= _FASTEST:
        raise InputError(f"--speed {cut.speed:g}", "is too slow or too fast", f"{_SLOWEST:g} to {_FASTEST:g}",
                         "0.25 is a quarter of real time")
    for pixels in (cut.width, cut.height):
        if not _SMALLEST_PX <= pixels <= _LARGEST_PX or pixels % 2:
            raise InputError(f"--size {cut.width}x{cut.height}", f"{pixels} pixels",
                             f"even numbers from {_SMALLEST_PX} to {_LARGEST_PX}", "such as 1280x720")
    return Fraction(fps).limit_denominator(1001)


def _trial(recording: Recording, cut: Cut, spans: Mapping[int, tuple[int, int]]) -> int:
    """The trial of a cut. Raises InputError for one that is not recorded."""
    if cut.trial is None:
        chosen = best_trial(recording)
        return chosen if chosen in spans else max(spans)
    if cut.trial not in spans:
        numbers = f"{min(spans)} to {max(spans)}" if len(spans) > 1 else str(min(spans))
        raise InputError(f"--trial {cut.trial}", "is not in the recording", numbers)
    return cut.trial


def _instants(cut: Cut, trial: int, span_ns: tuple[int, int], fps: Fraction) -> Instants:
    """Instants of the pictures, ns. Raises InputError for times that are not recorded."""
    first_s, last_s = (end / NS_PER_S for end in span_ns)
    for option, given in (("--from", cut.from_s), ("--until", cut.until_s)):
        if given is not None and not first_s <= given <= last_s:
            raise InputError(f"{option} {given:g}", f"is not in what is recorded of trial {trial}",
                             f"{first_s:g} to {last_s:g} s")
    begin_s = first_s if cut.from_s is None else cut.from_s
    end_s = last_s if cut.until_s is None else cut.until_s
    if not begin_s < end_s:
        raise InputError(f"--until {end_s:g}", f"is not after --from {begin_s:g}",
                         f"more than {begin_s:g}, up to {last_s:g} s")
    step_s = Fraction(cut.speed).limit_denominator(10000) / fps
    count = math.floor(Fraction(end_s - begin_s) / step_s + Fraction(1, 1000)) + 1
    if count > _MOST_PICTURES:
        raise InputError("film", f"of {count} pictures", f"at most {_MOST_PICTURES}",
                         "give --from and --until, a lower --fps, or a higher --speed")
    steps = [round(number * step_s * NS_PER_S) for number in range(count)]
    return np.minimum(round(begin_s * NS_PER_S) + np.array(steps, dtype=np.int64), span_ns[1])


def _require_writable(out: Path) -> None:
    """Raise InputError if a file cannot be made in the folder, which is made if it is missing."""
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        if out.is_dir():
            raise InputError(f"--out {out}", "is a folder", "a file that ends in .mp4 or .gif")
        writable = os.access(out.parent, os.W_OK)
    except OSError as fault:
        raise InputError(f"--out {out}", f"cannot be written: {fault.strerror}",
                         "a file in a writable folder") from None
    if not writable:
        raise InputError(f"--out {out}", "its folder cannot be written", "a file in a writable folder")


def _pictures(recording: Recording, hand: RecordedHand, trial: int, at_ns: Instants, cut: Cut,
              notes: list[str], progress: Progress) -> Iterator[Picture]:
    """Pictures of the instants, in their order."""
    panel = _panel(recording, hand, trial, cut, at_ns, notes)
    looked_at = np.unique(np.linspace(at_ns[0], at_ns[-1], _LOOKED_AT).astype(np.int64))
    seen = hands_at(recording, hand, trial, looked_at)
    view = view_into(seen.postures, holdable(seen.solids))
    if view is None:
        raise InputError(str(recording.path), f"no posture of trial {trial} is finite between these times",
                         "another trial or other times")
    stage = Stage(hand.shapes, seen.solids, panel.hand.width, panel.hand.height)
    try:
        middle, width_m, height_m = framed(hand.shapes, seen, view)
        for first in range(0, len(at_ns), _TOGETHER):
            now_ns = at_ns[first:first + _TOGETHER]
            found = hands_at(recording, hand, trial, now_ns)
            wrists = _wrists(found)
            for i, now in enumerate(now_ns):
                if np.isfinite(wrists[i]).all():
                    stage.look(view, wrists[i] + middle, width_m, height_m)
                picture = stage.picture({name: rows[i] for name, rows in found.hands.items()},
                                        found.solid_poses[i])
                yield panel.around(picture, float(now) / NS_PER_S)
                progress((first + i + 1) / len(at_ns))
    finally:
        stage.close()


def _wrists(seen: HandsAt) -> Array:
    """Position (t, 3) of the wrist, which the camera follows."""
    return seen.hands[TRUTH if TRUTH in seen.hands else ESTIMATE][:, 0, 4:]


def framed(shapes: Mapping[str, Sequence[Mesh]], seen: HandsAt,
           view: Sequence[float]) -> tuple[Array, float, float]:
    """Middle of the picture (3,), from the wrist, and its width and height, m, in which all postures fit."""
    way = np.asarray(view) / np.linalg.norm(view)
    right = np.cross(way, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(right, way)])
    wrists = _wrists(seen)[:, np.newaxis]
    points = []
    for name, rows in seen.hands.items():
        for segment, mesh in enumerate(shapes[name]):
            if len(mesh.vertices):
                low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
                share = _FOREARM_SHARE if segment == 0 else 1.0
                points.append(_corners(share * low, share * high, rows[:, segment]) - wrists)
    for number, solid in enumerate(seen.solids):
        if holdable([solid]):
            half = np.array(solid.half_sizes)
            poses = seen.solid_poses[:, number].copy()
            poses[np.linalg.norm(poses[:, 4:] - wrists[:, 0], axis=1) > _NEAR_M] = np.nan
            points.append(_corners(-half, half, poses) - wrists)
    every = np.concatenate([each.reshape(-1, 3) for each in points])
    flat = every[np.isfinite(every).all(axis=1)] @ axes.T
    low, high = flat.min(axis=0) - _MARGIN_M, flat.max(axis=0) + _MARGIN_M
    width, height = high - low
    return np.asarray(0.5 * (low + high) @ axes), float(width), float(height)


def _corners(low: Array, high: Array, poses: Array) -> Array:
    """Corners (t, 8, 3) of a box at poses (t, 7)."""
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), axis=-1).reshape(-1, 3)
    return np.asarray(quaternion.rotate(poses[:, np.newaxis, :4], corners) + poses[:, np.newaxis, 4:])


def _panel(recording: Recording, hand: RecordedHand, trial: int, cut: Cut, at_ns: Instants,
           notes: list[str]) -> Panel:
    """Title, keys and channels of a trial."""
    cast = cast_of(recording)
    keys = [TRUE_KEY] if TRUTH in hand.shapes else []
    if ESTIMATE in hand.shapes:
        keys.append(estimate_key(hand.pose_signals[ESTIMATE].partition(".")[0]))
    words = [f"trial {trial} (of 0 to {recording.trials - 1})" if recording.trials > 1 else "",
             f"seed {recording.seed}", "" if cut.speed == 1.0 else f"shown at {cut.speed:g} times real time"]
    patient = recording.experiment.get("patient")
    if patient:
        words.insert(1, describe({**patient, "file": Path(patient["file"]).stem}))
    channels, note = channels_of(recording, cast.stimulation, trial)
    if not channels:
        notes.append(note)
    span_s = float(at_ns[0]) / NS_PER_S, float(at_ns[-1]) / NS_PER_S
    return Panel(cut.width, cut.height, recording.name, "  ·  ".join(each for each in words if each), keys,
                 channels, span_s, note)


def channels_of(recording: Recording, signal: str, trial: int) -> tuple[list[Channel], str]:
    """Channels that are stimulated in a trial, those of the greatest charge if there are many; and a note.

    `signal`: commanded stimulation (channels, 2), A and s; empty if there is none.
    """
    if not signal:
        return [], "no stimulation is shown: none is recorded"
    times_ns, column = recording.column(signal, trial)
    if not times_ns.size or column.shape[2:] != (2,):
        return [], f"no stimulation is shown: {signal} holds no currents and pulse widths in trial {trial}"
    values = np.nan_to_num(column[:])
    every = [Channel(number=number, times_s=times_ns / NS_PER_S, current_ma=1e3 * values[:, number, 0],
                     width_us=1e6 * values[:, number, 1]) for number in range(values.shape[1])]
    most = [float(channel.charge_uc.max()) for channel in every]
    used = [channel for channel, charge in zip(every, most, strict=True) if charge > 0.0]
    if not used:
        return every[:MOST_CHANNELS], "no channel is stimulated in this trial"
    used.sort(key=lambda channel: -most[channel.number])
    shown = sorted(used[:MOST_CHANNELS], key=lambda channel: channel.number)
    rest = len(every) - len(used)
    words = [f"{len(used) - len(shown)} weaker ones are left out"] if len(used) > len(shown) else []
    if rest:
        words.append(f"{rest} more {'is' if rest == 1 else 'are'} not used")
    return shown, ", ".join(words)
