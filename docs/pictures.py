"""Runs shipped experiments and draws the pictures of their page: `python docs/pictures.py [NAME]...`.

Pictures go to docs/_pictures, below 120 kB each, with `shown.json`, which says of each what was run and what
it came to. Some need a recording from the folder FESLOOP_RECORDINGS.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from fesloop import InputError, Recording
from fesloop.show.picture.draw import draw
from fesloop.show.picture.palette import BLACK, BLUE, GREEN, ORANGE, VERMILION, channel_colour, tidy
from fesloop.show.report.parts import Drawing
from fesloop.show.report.run.search import search_sections

PICTURES = Path(__file__).resolve().parent / "_pictures"
SHOWN = PICTURES / "shown.json"
MOST_BYTES = 120_000
_STYLE = ("text { font-family: sans-serif; fill: #262626 } text.faint { fill: #666 } .paper { fill: #fff } "
          f".stroke-plain {{ stroke: #777 }} .fill-series-0 {{ fill: {BLUE} }} "
          f".fill-series-1 {{ fill: {VERMILION} }} .fill-theory {{ fill: {GREEN} }}")
"""Style sheet of drawings outside a report, which has its own."""
_WIDE = 1200
"""Pixels of a picture's width, two for each that a page gives it (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """Experiment of a picture, and the part of its run that is drawn.

    Attributes
    ----------
    settings: of `fesloop run`; `{recordings}` is the folder of recordings, `{runs}` that of runs here.
    drawn: the hand at some instants, arrays at the last of them, time courses, or what a search found.
    at_s: instants; empty where `fesloop picture` chooses. trial: which; -1 the last.
    after: experiments whose runs it needs. options: of `fesloop run` besides.
    """

    drawn: Literal["hand", "arrays", "courses", "search"]
    settings: tuple[str, ...] = ()
    at_s: tuple[float, ...] = ()
    trial: int = -1
    after: tuple[str, ...] = ()
    options: tuple[str, ...] = ()


_GRASP_S = (1.5, 3.55, 5.5, 8.0)
SHOTS = {
    "finger_control": Shot(drawn="courses"),
    "finger_pid_latency": Shot(drawn="courses", settings=("latency_ms=60",)),
    "finger_mpc": Shot(drawn="courses"),
    "finger_ilc": Shot(drawn="courses"),
    "finger_fmu": Shot(drawn="courses"),
    "linear_loop": Shot(drawn="courses", settings=("latency_ms=60", "experiment.duration_s=20")),
    "grasp_cylinder": Shot(drawn="hand", at_s=(0.0, 2.5, 6.0, 9.6)),
    "pinch": Shot(drawn="hand", at_s=(0.0, 2.0, 5.0, 8.4)),
    "open_close": Shot(drawn="hand"),
    "grasp_mpc": Shot(drawn="hand", at_s=_GRASP_S),
    "grasp_emg": Shot(drawn="hand", at_s=(3.5, 6.2, 8.2, 11.0)),
    "pinch_mpc": Shot(drawn="hand", at_s=_GRASP_S),
    "key_mpc": Shot(drawn="hand", at_s=(1.5, 4.1, 5.5, 8.0)),
    "grasp_ilc": Shot(drawn="hand", at_s=_GRASP_S),
    "open_close_ilc": Shot(drawn="hand"),
    "hil_error_replay": Shot(drawn="courses", settings=("tracker=ideal",)),
    "hil_twin": Shot(drawn="courses", after=("finger_control",), settings=(
        "recording={runs}/finger_control-1.h5", "strength=1.0")),
    "hil_dry_stimulator": Shot(
        drawn="courses", settings=("log={runs}/given.log",), options=("--realtime",)),
    "hil_replay": Shot(drawn="courses", settings=("recording={recordings}/wrist/circle-250.npz",)),
    "replay": Shot(drawn="courses", settings=("recording={recordings}/wrist/circle-250.npz",)),
    "kortier2014": Shot(drawn="hand", settings=("motion=kortier_circles",), at_s=(9.0, 11.0, 13.0, 15.0)),
    "salchow2019": Shot(drawn="hand", settings=("motion=P1", "duration_s=32"), at_s=(6.0, 12.0, 18.0, 24.0)),
    "tracker_hour": Shot(drawn="hand", settings=("duration_s=90",), at_s=(20.0, 40.0, 60.0, 80.0)),
    "hold_grip_force": Shot(drawn="hand", at_s=(1.0, 6.0, 20.0, 39.0)),
    "fatigue": Shot(drawn="arrays", at_s=(60.2,)),
    "identify_patient": Shot(drawn="courses"),
    "identify_grasp": Shot(drawn="courses"),
    "identify_key": Shot(drawn="courses"),
    "sweep_grasp": Shot(drawn="courses"),
    "recruitment_sweep": Shot(drawn="arrays", settings=("elements=[16, 43]", "duration_s=8"), at_s=(2.75,)),
    "array_search_gp": Shot(drawn="search"),
    "array_search_two_phase": Shot(drawn="search"),
    "array_search_magnets": Shot(drawn="search"),
    "array_search_exhaustive": Shot(drawn="search"),
}


def main(names: list[str]) -> int:
    """Run and draw; exit code."""
    PICTURES.mkdir(exist_ok=True)
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            try:
                shown = json.loads(SHOWN.read_text()) if SHOWN.exists() else {}
                shown[name] = picture(name, SHOTS[name], Path(folder))
                SHOWN.write_text(json.dumps(dict(sorted(shown.items())), indent=1) + "\n")
            except (InputError, subprocess.CalledProcessError, LookupError) as fault:
                failed.append(name)
                print(f"{name}: {fault}", file=sys.stderr)
    return 1 if failed else 0


def picture(name: str, shot: Shot, folder: Path) -> dict[str, Any]:
    """Run an experiment and draw it; what the page says of its picture."""
    for before in shot.after:
        if not any((folder / "runs").glob(f"{before}-*.h5")):
            run(before, Shot(drawn="courses"), folder)
    return drawn_of(name, shot, run(name, shot, folder), folder)


def drawn_of(name: str, shot: Shot, result: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Draw a run by what `fesloop run --json` said of it; what the page says of its picture."""
    with Recording(result["recording"]) as recording:
        trial = range(recording.trials)[shot.trial]
        if shot.drawn == "search":
            (PICTURES / f"{name}.svg").write_text(search_svg(recording))
        elif shot.drawn == "courses":
            drawn = folder / f"{name}.png"
            courses(recording, trial, result["metrics"]).savefig(drawn)
            keep(drawn, PICTURES / f"{name}.png")
        else:
            pictures = draw(recording, folder, shot.at_s, trial).pictures
            keep([path for path in pictures if f"_{shot.drawn}" in path.stem][-1], PICTURES / f"{name}.png")
    settings = [each for each in shot.settings if "{" not in each]
    words = [*(f"--set {each}" for each in settings), *shot.options]
    return {"command": " ".join(["fesloop run", name, *words]), "drawn": shot.drawn, "trial": trial,
            "metrics": {key: value for key, value in result["metrics"].items()
                        if isinstance(value, list) and all(isinstance(each, float | bool) for each in value)}}


def run(name: str, shot: Shot, folder: Path) -> dict[str, Any]:
    """Result of `fesloop run --json`."""
    places = {"runs": str(folder / "runs"), "recordings": os.environ.get("FESLOOP_RECORDINGS", "")}
    settings = [word for each in shot.settings for word in ("--set", each.format(**places))]
    program = str(Path(sys.executable).with_name("fesloop"))
    command = [program, "run", name, *settings, *shot.options, "--json", "--out", places["runs"]]
    answer: dict[str, Any] = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    return answer


def courses(recording: Recording, trial: int, metrics: dict[str, Any]) -> Figure:
    """Posture at the left; error by trial, or else what is stimulated, at the right."""
    figure = Figure(figsize=(8.0, 2.6), dpi=150, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    _posture(left, recording, trial)
    errors = metrics.get("joint_rmse_deg", [])
    if len(errors) > 1:
        right.plot(np.arange(len(errors)), errors, "o-", color=BLUE)
        right.set_ylim(bottom=0.0)
        tidy(right, "trial", "joint_rmse_deg")
    else:
        _stimulation(right, recording, trial)
    return figure


def search_svg(recording: Recording) -> str:
    """The arrays by how good each element was: the report's drawing, with colours of its own."""
    sections = search_sections(recording)
    drawing = next(part for section in sections for part in section.parts if isinstance(part, Drawing))
    start = drawing.svg.index(">") + 1
    return f"{drawing.svg[:start]}<style>{_STYLE}</style>{drawing.svg[start:]}\n"


def _posture(axes: Axes, recording: Recording, trial: int) -> None:
    """First row of what is scored: as wanted, true, and as the tracker has it."""
    score = recording.experiment["score"]
    known = {role: score[role] for role in ("truth", "reference", "estimate") if score.get(role)}
    if not known:
        known = {"reference": "reference.angles", "estimate": "tracker.angles"}
    looks = {"truth": (BLACK, "-"), "reference": (BLUE, "--"), "estimate": (ORANGE, "-")}
    for role, name in known.items():
        signal = recording.signal(name, trial)
        colour, style = looks[role]
        rows = signal.values.reshape(len(signal.times_ns), -1)
        axes.plot(signal.times_ns / 1e9, np.degrees(rows[:, 0]), style, color=colour, linewidth=1.3,
                  label=f"{role} ({name.partition('.')[0]})")
    axes.legend(fontsize=8, frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    tidy(axes, "s", "deg" if recording.trials == 1 else f"deg, trial {trial}")


def _stimulation(axes: Axes, recording: Recording, trial: int) -> None:
    """Charge of each channel's pulses."""
    names = [name for name in (*recording.signals, *recording.inputs) if name.endswith(".stimulation")]
    signal = recording.signal(next((name for name in names if name.startswith("safety")), names[0]), trial)
    for channel, pulses in enumerate(np.moveaxis(signal.values, 1, 0)):
        axes.step(signal.times_ns / 1e9, pulses.prod(axis=1) * 1e6, where="post", linewidth=1.0,
                  color=channel_colour(channel))
    tidy(axes, "s", "charge of a pulse, uC", f"{signal.name}, by channel")


def keep(drawn: Path, target: Path) -> None:
    """A picture as it is committed: small, in as many colours as it takes to stay below the limit."""
    with Image.open(drawn) as whole:
        picture = whole.convert("RGB")
    if picture.width > _WIDE:
        high = round(picture.height * _WIDE / picture.width)
        picture = picture.resize((_WIDE, high), Image.Resampling.LANCZOS)
    for colours in (256, 128, 64, 32):
        picture.quantize(colours, dither=Image.Dither.NONE).save(target, optimize=True)
        if target.stat().st_size < MOST_BYTES:
            return
    raise InputError(str(target), f"{target.stat().st_size} bytes", f"below {MOST_BYTES}", "draw less")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or list(SHOTS)))
