"""One patient's session: identification, then runs with the identified model.

Recordings are in a temporary folder; only scores are kept. A failure ends the patient's session and is part
of the result: a patient who cannot be identified counts as one who failed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fesloop.errors import InputError, RunError
from fesloop.experiment.files.parse import load
from fesloop.experiment.registry import identifier
from fesloop.experiment.running import Experiment, run

Kept = dict[str, Any]
Key = tuple[str | int, ...]
COHORT, FIRST_SEED = 2, 100
"""Cohort and first seed of the subjects; pilots were members of cohort 1 and the presets."""


@dataclass(frozen=True, slots=True)
class Session:
    """One patient and the steps of the session; a job for `fesloop.apps.reproduce.cohort.run_jobs`.

    Attributes
    ----------
    key: of the result.
    patient: settings that define the patient, as in `fesloop run --set`.
    seed: of every run.
    steps: function of the session and of a folder for its files, defined in a module; its result is kept.
    """

    key: Key
    patient: tuple[str, ...]
    seed: int
    steps: Callable[[Session, Path], Kept]

    @property
    def name(self) -> str:
        """Name in messages."""
        return " ".join(self.patient)

    def kept(self) -> Kept:
        """Run the steps; the result has under `failed` why they ended early, or ""."""
        with TemporaryDirectory(prefix="fesloop-") as folder:
            try:
                return {"failed": "", **self.steps(self, Path(folder))}
            except (InputError, RunError) as fault:
                return {"failed": str(fault)}

    def load(self, experiment: str, settings: Sequence[str] = ()) -> Experiment:
        """Load a shipped experiment with this patient."""
        return load(experiment, (*self.patient, *settings), self.seed)

    def ran(self, experiment: Experiment, folder: Path) -> Path:
        """Run and return the recording. Raises RunError if the run did not end."""
        result = run(experiment, folder)
        if result.status == "interrupted":
            raise KeyboardInterrupt
        if result.status != "done":
            raise RunError(f"{experiment.name}, {self.name}: {result.cause or result.status}")
        return Path(result.recording)

    def identified(self, experiment: str, folder: Path, settings: Sequence[str] = ()) -> Path:
        """Identify this patient in a shipped experiment through its tracker; return the model file."""
        return self.model_of(self.ran(self.load(experiment, settings), folder), folder)

    def model_of(self, recording: Path, folder: Path) -> Path:
        """Identify the patient of a recording; return the model file, written in `folder`."""
        model = folder / f"{recording.stem}.toml"
        identifier()(str(recording)).model.save(model)
        return model


def sessions(subjects: int, steps: Callable[[Session, Path], Kept]) -> list[Session]:
    """Make a session for each member of the cohort of `sci_c6` on which nothing was tuned."""
    return [Session((member,), ("patient=sci_c6", f"cohort={COHORT}", f"member={member}"),
                    FIRST_SEED + member, steps) for member in range(subjects)]
