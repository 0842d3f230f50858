"""The muscles that move the hand: names and order, shared by electrodes, muscles, skeleton and controllers.

Extrinsic muscles lie in the forearm, under electrode arrays; intrinsic ones in the hand, out of their reach.
A digit behind a name is the finger that a slip moves.
"""

from __future__ import annotations

from fesloop.errors import InputError, did_you_mean

EXTRINSIC = (
    "ECRL", "ECRB", "EDC2", "EDC3", "EDC4", "EDC5", "EDM", "ECU", "EIP", "EPL", "EPB", "APL",
    "FCR", "PL", "FCU", "FDS2", "FDS3", "FDS4", "FDS5", "FDP2", "FDP3", "FDP4", "FDP5", "FPL")
"""Extensors and abductors, then flexors, of wrist, fingers and thumb."""
INTRINSIC = ("THENAR", "INT2", "INT3", "INT4", "INT5")
"""The thenar group, and for each finger its lumbrical and interossei lumped."""
MUSCLES = EXTRINSIC + INTRINSIC


def muscle(name: str) -> int:
    """Index of a muscle in `MUSCLES`; raises InputError for a name that is not there."""
    if name not in MUSCLES:
        raise InputError("muscle", f"{name!r}", ", ".join(MUSCLES), did_you_mean(name, MUSCLES))
    return MUSCLES.index(name)
