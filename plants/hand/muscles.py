"""Forces, fibres and moment arms of the 29 muscles that move the hand.

Moment arms are constant: a tendon's length is linear in the joint angles. They are the magnitudes at the
neutral posture; those at the joints of the fingers and the wrist hold for left and right hands alike, since
all angles have the same meaning on both sides.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.movements import MUSCLES
from fesloop.hand.segments import SegmentTree

Array = NDArray[np.float64]


class Muscle(NamedTuple):
    """A muscle's force and fibre: peak isometric force, N, optimal fibre length, mm, and passive stiffness
    of the whole muscle, N/m, where the hand rests."""

    force_n: float
    fibre_mm: float
    passive_n_m: float


FLEXOR_SHARE, EXTENSOR_SHARE = 0.3, 0.5
"""Fraction of the peak forces of the MoBL-ARMS model (Saul 2015, doi 10.1080/10255842.2014.916698), as in
MyoHand (myo-sim 0.2.4), chosen so that the wrist's largest moments are as measured: flexion 5.2 to 18.7,
extension 3.4 to 9.4, radial deviation 7.9 to 15.3, ulnar 5.9 to 11.9 N m (Delp 1996, doi
10.1016/0021-9290(96)00029-2). Unscaled they give a flexion of 42 and an extension of 15."""
MOBL_ARMS_N = {
    "ECRL": 337.3, "ECRB": 252.2, "EDC2": 48.8, "EDC3": 94.4, "EDC4": 109.2, "EDC5": 39.4, "EDM": 72.4,
    "ECU": 192.9, "EIP": 47.3, "EPL": 88.3, "EPB": 46.0, "APL": 116.7, "FCR": 407.9, "PL": 101.0,
    "FCU": 479.8, "FDS2": 162.5, "FDS3": 258.8, "FDS4": 171.2, "FDS5": 75.3, "FDP2": 197.3, "FDP3": 212.4,
    "FDP4": 172.9, "FDP5": 236.8, "FPL": 201.0, "INT2": 183.6, "INT3": 257.2, "INT4": 250.8, "INT5": 155.7,
    "THENAR": 330.0}
"""Peak forces before scaling. EDC5: 39.4, where MyoHand has 139.4. INT: both interossei and the
lumbrical of MyoHand together. THENAR: chosen, its opponens of 180 and as much again for the rest."""
FIBRES_MM = {
    "ECRL": 81.0, "ECRB": 58.5, "EDC2": 70.0, "EDC3": 72.4, "EDC4": 62.6, "EDC5": 65.0, "EDM": 67.5,
    "ECU": 62.2, "EIP": 58.9, "EPL": 54.0, "EPB": 67.9, "APL": 71.3, "FCR": 62.8, "PL": 63.8, "FCU": 50.9,
    "FDS2": 72.0, "FDS3": 70.0, "FDS4": 73.0, "FDS5": 70.0, "FDP2": 66.0, "FDP3": 66.0, "FDP4": 68.0,
    "FDP5": 62.0, "FPL": 55.1, "INT2": 40.0, "INT3": 40.0, "INT4": 40.0, "INT5": 40.0, "THENAR": 45.0}
"""FDP and FDS: resting lengths of Brand 1981. Other extrinsic muscles: Holzbaur 2005
(doi 10.1007/s10439-005-3320-7), recalled. Intrinsic ones are chosen (MyoHand: 33 to 54)."""
PASSIVE_N_M = {"FDP": 20.0, "FDS": 20.0, "EDC": 40.0, "EIP": 10.0, "EDM": 20.0, "FPL": 30.0, "EPL": 20.0,
               "INT": 20.0, "THE": 20.0}
"""Passive stiffness by the first three letters of a name; all others 10. Chosen: with the joints' own
stiffness the MCP joint is as stiff as measured, tendons included, and the fingers follow the wrist
(tenodesis)."""

WRIST_MM = {
    "ECRL": (-10.2, -23.6), "ECRB": (-13.7, -14.2), "EDC2": (-17.3, -2.3), "EDC3": (-17.8, 2.2),
    "EDC4": (-17.3, 9.1), "EDC5": (-11.1, 9.9), "EDM": (-9.5, 14.5), "ECU": (-5.7, 27.8),
    "EIP": (-12.8, 2.8), "EPL": (-7.5, -22.7), "EPB": (-1.0, -34.2), "APL": (7.0, -26.8),
    "FCR": (17.7, -4.0), "PL": (21.7, -7.2), "FCU": (18.4, 15.0), "FDS2": (14.8, -9.6),
    "FDS3": (14.8, -7.3), "FDS4": (14.8, -1.3), "FDS5": (14.8, 0.4), "FDP2": (13.1, -9.6),
    "FDP3": (13.1, -5.3), "FDP4": (13.1, -2.7), "FDP5": (13.1, -0.9), "FPL": (15.1, -20.8)}
"""Flexion and ulnar deviation. Flexion of FCR, PL, FDS, FDP, FPL, APL, ECRB, ECRL, ECU, EPL: published wrist
moment arms at 0 deg. The others, and all of deviation: MyoHand (myo-sim 0.2.4) at its neutral posture, but
for FCU's deviation, which is chosen: MyoHand's 10.6 leaves the largest ulnar moment below the measured."""
FINGER_MM = {
    "FDP2": (10.1, 9.8, 6.5), "FDP3": (11.6, 10.7, 7.0), "FDP4": (10.4, 10.4, 6.8), "FDP5": (8.9, 8.5, 6.0),
    "FDS2": (12.1, 8.3, 0.0), "FDS3": (14.0, 8.7, 0.0), "FDS4": (13.0, 8.5, 0.0), "FDS5": (9.8, 7.4, 0.0),
    "EDC2": (-8.6, -2.9, -0.8), "EDC3": (-9.4, -3.2, -0.9), "EDC4": (-7.9, -2.7, -0.7),
    "EDC5": (-5.9, -2.0, -0.5), "EIP": (-9.2, -3.1, -0.9), "EDM": (-5.7, -1.9, -0.5),
    "INT2": (6.6, -2.6, -1.6), "INT3": (6.6, -2.6, -1.6), "INT4": (6.6, -2.6, -1.6),
    "INT5": (6.6, -2.6, -1.6)}
"""Flexion of MCP, PIP, DIP. FDP, FDS: Ketchum 1978. EDC2 and INT at the MCP: An 1983
(doi 10.1016/0021-9290(83)90053-X) as usually quoted; other extensors at the MCP: MyoHand. Extensors at PIP
and DIP in the proportions in which EDC extends the joints (Nimbarte 2008, doi 10.1186/1749-799X-3-8). INT at
PIP and DIP chosen, for all fingers alike. No tendon abducts: interossei cancel out, others are small."""
THUMB_MM = {
    "FPL": (11.0, 0.0, 0.0, 7.1, 8.8), "EPL": (-6.7, -9.0, 0.0, -9.0, -5.2),
    "EPB": (-12.5, 0.8, 0.0, -9.1, 0.0),
    "APL": (-7.0, 10.0, 0.0, 0.0, 0.0), "THENAR": (10.0, 8.0, 4.0, 6.0, -1.0)}
"""Flexion and palmar abduction in the resting thumb's own plane, and pronation, at the CMC joint; flexion of
MCP and IP. Directions: Smutz 1998 (doi 10.1016/S0021-9290(98)00043-8): FPL a flexor alone, EPL extensor and
adductor, EPB extensor and mild abductor, APL extensor and abductor, the thenar group flexor and abductor.
Magnitudes of EPL, EPB and of FPL at MCP and IP: MyoHand; others chosen."""


ADULT_MM = 190.0
"""Length of the hand to which all numbers here apply (chosen: the default). Another hand is built to scale s:
lengths grow as s, forces as its square, moments, stiffness and damping as its cube."""


def passive_n_m(name: str) -> float:
    """Passive stiffness of a whole muscle, N/m, in the resting adult hand."""
    return PASSIVE_N_M.get(name[:3], 10.0)


def muscles(scale: float = 1.0) -> tuple[Muscle, ...]:
    """Force and fibre of every muscle, in the order of `MUSCLES`, of a hand built to scale."""
    rows = []
    for name in MUSCLES:
        share = EXTENSOR_SHARE if name[0] in "EA" else FLEXOR_SHARE
        rows.append(Muscle(scale**2 * share * MOBL_ARMS_N[name], scale * FIBRES_MM[name],
                           scale * passive_n_m(name)))
    return tuple(rows)


def moment_arms(tree: SegmentTree, thumb_pronation: float, scale: float = 1.0) -> Array:
    """Moment arms (29, d) of all muscles about the hand's freedoms, m; positive: tension increases the angle.

    `thumb_pronation`, rad, is that of the resting thumb, in whose plane the arms at its CMC joint are given.
    """
    arms = np.zeros((len(MUSCLES), len(tree.freedoms)))
    # Axes of the pronated thumb in the frame before pronation: its z flexes, its -x abducts.
    sine, cosine = np.sin(thumb_pronation), np.cos(thumb_pronation)
    for i, name in enumerate(MUSCLES):
        placed = dict(zip(("wrist_flexion", "wrist_abduction"), WRIST_MM.get(name, ()), strict=False))
        if name in FINGER_MM:
            finger = {"EIP": "F2", "EDM": "F5"}.get(name, f"F{name[-1]}")
            joints = (f"{finger}_{joint}_flexion" for joint in ("mcp", "pip", "dip"))
            placed.update(zip(joints, FINGER_MM[name], strict=True))
        if name in THUMB_MM:
            flexion, abduction, pronation, mcp, ip = THUMB_MM[name]
            placed.update({
                "F1_cmc_flexion": cosine * flexion + sine * abduction,
                "F1_cmc_abduction": sine * flexion - cosine * abduction,
                "F1_cmc_pronation": pronation, "F1_mcp_flexion": mcp, "F1_ip_flexion": ip})
        for freedom, millimetres in placed.items():
            arms[i, tree.freedom(freedom)] = 1e-3 * scale * millimetres
    return arms
