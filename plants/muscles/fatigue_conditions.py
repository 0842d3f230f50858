"""Fatigue of muscle in three conditions: able-bodied, soon and long after a spinal cord injury.

Calibrated to Bickel 2004 (JRRD 41(1):33): after 180 isometric contractions of the quadriceps, half of the
time, peak torque had fallen by 44, 56 and 67 %. A contraction is six pulses 70 ms apart; that it lasts six
intervals, 420 ms, and the rest as long, and that force falls as that of fully recruited muscle, is assumed.
`fatigue_s` is fitted so, one number a condition. Not fitted: `floor` and `frequency_weight` are those of
Riener's equation, `recovery_s` is the time constant of recovery of Ding 2003 (doi
10.1016/S1050-6411(03)00102-0), of the same muscle, able-bodied, here taken for all. (With 45 s, as models of
Riener's type have it, the fit would be 5.7, 2.9 and 1.1 s, and hardly any stimulated grasp could be held.)
"""

from __future__ import annotations

from plants.muscles.fitness import MuscleFatigue

RECOVERY_S = 127.0
CONDITIONS: dict[str, MuscleFatigue] = {
    "able_bodied": MuscleFatigue(fatigue_s=13.6, recovery_s=RECOVERY_S),
    "sci_acute": MuscleFatigue(fatigue_s=7.8, recovery_s=RECOVERY_S),
    "sci_chronic": MuscleFatigue(fatigue_s=3.7, recovery_s=RECOVERY_S),
}
