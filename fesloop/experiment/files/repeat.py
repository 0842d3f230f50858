"""A run once more, from its recording: execution times that were measured are taken as they were."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording


def document_of(path: Path) -> dict[str, Any]:
    """Tables of a recorded experiment, with every measured execution time as recorded.

    Raises InputError for a file that is no recording.
    """
    with Recording(path) as recording:
        document = copy.deepcopy(recording.experiment)
        for name, table in document["blocks"].items():
            if table.get("execution", {}).get("kind") == "measured":
                trials = [_durations_ns(recording, name, trial) for trial in range(recording.trials)]
                table["execution"] = {"kind": "recorded", "recorded_ns": trials}
        return document


def _durations_ns(recording: Recording, block: str, trial: int) -> list[int]:
    """How long each step that a block executed took."""
    signal = next((name for name in recording.signals if name.startswith(f"{block}.")), None)
    if signal is None:
        raise InputError(str(recording.path), f"measured times of {block!r}, which puts nothing out",
                         "a measured block with an output", "run the experiment anew instead")
    steps = recording.signal(signal, trial)
    durations: list[int] = (steps.left_ns - steps.times_ns).tolist()
    return durations
