"""Functions of commands: `fesloop.run`, `study`, `report`, `film`, `identify`, `export_block`."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fesloop.errors import InputError

if TYPE_CHECKING:
    from fesloop.analysis.study.results.study_results import StudyResults
    from fesloop.experiment.files.settings import Settings
    from fesloop.experiment.recording.reading import Recording
    from fesloop.experiment.running import Experiment, Result
    from fesloop.models.patient_model import PatientModel


def run(
    experiment: str | Path | Experiment, settings: Settings = (), *, seed: int | None = None,
    out: str | Path = "runs",
) -> Result:
    """Run an experiment, as `fesloop run` does, and return its result: metrics, and where it is recorded.

    Parameters
    ----------
    experiment: name of a shipped experiment, path of a TOML file or a recording, or an Experiment.
    settings: {KEY: VALUE} or ["KEY=VALUE"], as `--set`: variants of the file, aliases and dotted key paths;
        {"blocks.controller": {"kind": "own_pid", "rate": "50"}} replaces a block.
    seed: takes the place of the file's.
    out: folder of the recording.

    Raises InputError, InputErrors for bad input, and what `Experiment.run` raises.
    """
    from fesloop.apps.progress import run_progress
    from fesloop.experiment.files.parse import load
    from fesloop.experiment.running import Experiment

    if not isinstance(experiment, Experiment):
        made = load(experiment, settings, seed)
    elif settings:
        raise InputError("settings", "given with an experiment that is made already",
                         "settings with a name or a path", "give them to fesloop.load")
    else:
        made = experiment if seed is None else experiment.with_seed(seed)
    with run_progress(made.name) as progress:
        return made.run(out, progress=progress)


def study(
    study: str | Path | Mapping[str, Any], form: str = "", *, out: str | Path = "studies",
    workers: int | None = None,
) -> StudyResults:
    """Run a study, or its remaining runs, as `fesloop study` does, and return its results.

    Parameters
    ----------
    study: name of a shipped study, path of a TOML file, or the tables of one, in which `experiment` may be an
        Experiment: {"study": {"name": "mine", "experiment": experiment, "metrics": {...}}, "axes": {...}}.
        Blocks may be of classes of the notebook or script (`fesloop.block`).
    form: of the file, such as "full"; empty: the file itself.
    out: folder in which the study has its own.
    workers: processes; None: one per core. A script starts them under `if __name__ == "__main__":`.

    Raises InputError, InputErrors for bad input, and what `run_study` raises.
    """
    from fesloop.analysis.study.design.study_file import read_study, study_of
    from fesloop.analysis.study.engine.coordinator import run_study
    from fesloop.analysis.study.results.study_results import load
    from fesloop.apps.progress import study_progress

    if isinstance(study, Mapping):
        made = study_of(study, form, Path())
    elif isinstance(study, (str, Path)):
        made = read_study(study, form)
    else:
        raise InputError("study", f"is of type {type(study).__name__}", "a name, a path, or tables",
                         'give an experiment as {"study": {"experiment": ...}}')
    with study_progress(made.name) as watch:
        store = run_study(made, out, workers=workers, watch=watch).store
    results = load(store)
    if made.figures:
        from fesloop.show.figures.drawing import draw_all

        for name, fault in draw_all(results, made, store.parent)[1].items():
            warnings.warn(f"figure {name} cannot be drawn: {fault}", stacklevel=2)
    return results


def report(*sources: str | Path | Result | Recording | StudyResults, out: str | Path | None = None) -> Path:
    """Write the report of a run, of several, or of a study, as `fesloop report` does; return its path.

    Parameters
    ----------
    sources: recordings or results of runs, or one folder or the results of a study.
    out: path of the HTML file; None: beside the first source.

    Raises InputError for sources that have no report.
    """
    from fesloop.apps.report_pages import page_of, report_path
    from fesloop.show.report.page import write_page

    paths = [_path_of(each) for each in sources]
    if not paths:
        raise InputError("report", "of nothing", "recordings, results of runs, or a study's folder")
    target = report_path(paths, out)
    write_page(page_of(paths, lambda share: None)[1], target)
    return target


def film(
    recording: str | Path | Result, out: str | Path | None = None, *, trial: int | None = None,
    from_s: float | None = None, until_s: float | None = None, fps: float | None = None,
    size: tuple[int, int] = (1280, 720), speed: float = 1.0,
) -> Path:
    """Film a trial of a run, as `fesloop film` does, and return the film's path.

    Parameters
    ----------
    recording: the run, or its recording.
    out: file that ends in .mp4 (extra `film`) or .gif; None: an MP4 beside the recording.
    trial: counted from 0; None: the one that held its object with the least error.
    from_s, until_s: first and last instant of the trial, s; None: all that is recorded.
    fps: pictures per second of the film; None: 30, of a GIF 20.
    size: width and height, pixels, even numbers.
    speed: 1 is real time, 0.25 a quarter of it.

    Raises InputError for a recording without a hand, for values that cannot be, for a file that cannot be
    written, and where PyAV or OpenGL is not installed.
    """
    from fesloop.experiment.recording.reading import Recording
    from fesloop.show.film.opengl import require_opengl

    require_opengl()
    from fesloop.show.film.film import Cut
    from fesloop.show.film.film import film as write_film

    path = _path_of(recording)
    cut = Cut(trial=trial, from_s=from_s, until_s=until_s, fps=fps, width=size[0], height=size[1],
              speed=speed)
    with Recording(path) as opened:
        return write_film(opened, path.with_suffix(".mp4") if out is None else Path(out), cut).path


def identify(
    recording: str | Path | Result, *, measured: str = "", method: Literal["subspace", "fir"] = "subspace",
    opened_deg: float | None = None,
) -> PatientModel:
    """Identify the model of a patient from a run with a block `excitation`, as `fesloop identify` does.

    Parameters
    ----------
    recording: the run, or its recording.
    measured: signal to be predicted; empty: that of the block of kind `synergies`.
    method: of the linear dynamics after recruitment.
    opened_deg: flexion of the fingers of the opened hand that elements are chosen for, after a sweep; None:
        that of the shipped grasps, 18.

    `model.save("own_model.toml")` writes the file that controllers read; `model.usable` tells whether they
    take it. Raises InputError for a recording that shows no model.
    """
    from fesloop.experiment.registry import identifier

    model: PatientModel = identifier()(str(_path_of(recording)), measured=measured, method=method,
                                       opened_deg=opened_deg).model
    return model


def _path_of(given: Any) -> Path:
    """Path of a recording or a study: given, or of a result, an open recording or results."""
    if isinstance(given, (str, Path)):
        return Path(given)
    return Path(getattr(given, "recording", None) or given.path)


def export_block(
    experiment: str | Path | Experiment, block: str, format: Literal["c", "fmu"] = "c",
    out: str | Path | None = None, *, settings: Settings = (),
) -> Path:
    """Write a controller as C sources or as an FMU, as `fesloop export --block` does; return folder or file.

    Parameters
    ----------
    experiment: name of a shipped experiment, path of a TOML file or a recording, or an Experiment.
    block: name of a block of the kind pid, tuned_pid, ilc or mpc.
    format: "c" for a folder of sources, "fmu" for FMI 2.0 co-simulation, which needs a C compiler.
    out: new folder, or a new file ending in .fmu; None: exports/EXPERIMENT-BLOCK-FORMAT.
    settings: as in `run`.

    Raises InputError for a block that cannot be exported and a target that exists, RunError if the compiler
    fails.
    """
    from fesloop.experiment.block_code import export_code
    from fesloop.experiment.files.parse import load
    from fesloop.experiment.running import Experiment

    if isinstance(experiment, Experiment) and settings:
        raise InputError("settings", "given with an experiment that is made already",
                         "settings with a name or a path", "give them to fesloop.load")
    made = experiment if isinstance(experiment, Experiment) else load(experiment, settings)
    return export_code(made, block, format, out)[0]
