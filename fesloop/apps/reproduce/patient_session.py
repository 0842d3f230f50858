"""What is done with one patient in one session: identified, then run after run with the model of that.

Recordings live in a temporary folder; only what is scored is kept. Whatever fails ends the session of its
patient, and is told in the result: a patient who cannot be identified counts, as one who failed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fesloop.errors import InputError, RunError
from fesloop.experiment.experiment import Experiment
from fesloop.experiment.files.parse import load
from fesloop.experiment.identifying import identifier
from fesloop.experiment.running.trial import run

Kept = dict[str, Any]
Key = tuple[str | int, ...]
COHORT, FIRST_SEED = 2, 100
"""Pilots were members of cohort 1 and the presets."""


@dataclass(frozen=True, slots=True)
class Session:
    """One patient, and what is done with them; a job for `fesloop.apps.reproduce.cohort.run_jobs`.

    Attributes
    ----------
    key: by which its result is found.
    patient: settings that say who it is, as of `fesloop run --set`.
    seed: of every run.
    steps: what is done, a function of a module, of the session and a folder for its files; what it gives
        is kept.
    """

    key: Key
    patient: tuple[str, ...]
    seed: int
    steps: Callable[[Session, Path], Kept]

    @property
    def name(self) -> str:
        """By which a user is told of it."""
        return " ".join(self.patient)

    def kept(self) -> Kept:
        """Do it; under `failed`, why it ended early, or ""."""
        with TemporaryDirectory(prefix="fesloop-") as folder:
            try:
                return {"failed": "", **self.steps(self, Path(folder))}
            except (InputError, RunError) as fault:
                return {"failed": str(fault)}

    def load(self, experiment: str, settings: Sequence[str] = ()) -> Experiment:
        """A shipped experiment with this patient."""
        return load(experiment, (*self.patient, *settings), self.seed)

    def ran(self, experiment: Experiment, folder: Path) -> Path:
        """The recording of a run; raises RunError where it did not get to its end."""
        result = run(experiment, folder)
        if result.status == "interrupted":
            raise KeyboardInterrupt
        if result.status != "done":
            raise RunError(f"{experiment.name}, {self.name}: {result.cause or result.status}")
        return Path(result.recording)

    def identified(self, experiment: str, folder: Path, settings: Sequence[str] = ()) -> Path:
        """The model file of this patient, identified in a shipped experiment through its tracker."""
        recording = self.ran(self.load(experiment, settings), folder)
        model = folder / "model.toml"
        identifier()(str(recording)).model.save(model)
        return model


def sessions(subjects: int, steps: Callable[[Session, Path], Kept]) -> list[Session]:
    """One session for each member of the cohort of `sci_c6` that nothing was tuned on."""
    return [Session((member,), ("patient=sci_c6", f"cohort={COHORT}", f"member={member}"),
                    FIRST_SEED + member, steps) for member in range(subjects)]
