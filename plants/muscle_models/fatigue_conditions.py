"""Fatigue of muscle in three conditions: able-bodied, soon and long after a spinal cord injury.

Calibrated: `fatigue_s` is such that isometric force has fallen by 44, 56 and 67 % after 180 contractions, as
in Bickel 2004 (JRRD 41(1):33).
"""

from __future__ import annotations

from plants.muscle_models.fitness import MuscleFatigue

CONDITIONS: dict[str, MuscleFatigue] = {
    "able_bodied": MuscleFatigue(fatigue_s=5.7),
    "sci_acute": MuscleFatigue(fatigue_s=2.9),
    "sci_chronic": MuscleFatigue(fatigue_s=1.1),
}
