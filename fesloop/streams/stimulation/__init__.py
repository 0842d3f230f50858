"""Recordings of stimulated muscle: torque, force and movement against pulse width, current and posture."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from fesloop.streams.stimulation.files import import_stimulation, open_stimulation
    from fesloop.streams.stimulation.recording import (
        ForceCourse,
        Movement,
        SteadyTrials,
        StimulationRecording,
        TorqueCourse,
        relative_to_visit,
    )

__all__ = ["ForceCourse", "Movement", "SteadyTrials", "StimulationRecording", "TorqueCourse",
           "import_stimulation", "open_stimulation", "relative_to_visit"]

__getattr__ = found_in(__name__, {
    **dict.fromkeys(("import_stimulation", "open_stimulation"), "files"),
    **dict.fromkeys(("ForceCourse", "Movement", "SteadyTrials", "StimulationRecording", "TorqueCourse",
                     "relative_to_visit"), "recording")})
