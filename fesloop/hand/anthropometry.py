"""Sizes of a subject's hand: measured, or from the length of the hand.

Fingers F1 (thumb) to F5 (little finger) after doi 10.3390/s19010208. Lengths are functional: from one
centre of rotation to the next.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean

Array = NDArray[np.float64]
Five = tuple[float, float, float, float, float]
Three = tuple[float, float, float]

FINGERS = ("F1", "F2", "F3", "F4", "F5")
BONES = tuple(f"{finger}{bone}" for finger in FINGERS for bone in ("mpd" if finger == "F1" else "pmd"))
"""Bones of the digits, from the palm to the tip."""
PARTS = ("palm", *BONES)
"""Parts of the hand that touch objects."""
FINGERTIPS = tuple(f"{finger}d" for finger in FINGERS)
"""The parts at the ends of the digits."""
JOINTED = ("hand", *BONES)
"""Segments that a joint moves: the hand, and the bones of the digits."""
PHALANX_RATIOS = np.array([[.251, .196, .158], [.245, .143, .097], [.266, .170, .108],
                           [.244, .165, .107], [.204, .117, .093]])
"""Segments over hand length (Buchholz, Armstrong and Goldstein 1992, as quoted in later hand models): of the
thumb metacarpal, proximal, distal; of the fingers proximal, middle, distal."""
METACARPAL_RATIOS = np.array([.118, .463, .446, .421, .414])
"""Wrist's centre to the thumb's CMC joint and to the fingers' MCP joints over hand length. Fingers: as above.
Thumb: .073 hand lengths distal and .196 breadths radial (Sancho-Bru 2012, from Buchholz), a breadth being
.47 lengths."""
METACARPAL_ANGLES_DEG = np.array([-58.0, -15.0, 0.0, 13.6, 27.6])
"""Directions of these from that of the middle finger's, + ulnar. Thumb: doi 10.3390/s19010208, figure 3.
Fingers: those of Buchholz's joint centres, which lie .447, .409, .368 hand lengths distal, at the distances
above."""
FOREARM_RATIO = .146 / .108
"""Forearm over hand length (Drillis and Contini 1966, as in Winter's Biomechanics and Motor Control)."""
SOFT_TISSUE_MM: Five = (5.67, 3.84, 3.95, 3.95, 3.73)
"""Between bone and skin at the fingertip, mean (doi 10.3390/s19010208, table 3, after Buryanov)."""
THICKNESS_RATIOS = .45 * np.array([.185, .153, .159, .148, .133])
"""Thickness of the fingertip over hand length: over hand breadth in Sancho-Bru 2012; a breadth of .45 hand
lengths is chosen (85.8 and 190.2 mm in Ibeachu 2011)."""
WIDTH_OF_THICKNESS = 1.2
"""Chosen: a fingertip is that much wider than thick."""
WIDTH_RATIO = .45
"""Width of the hand across the MCP joints over its length (85.8 of 190.2 mm in Ibeachu 2011)."""

_HAND_MM = (100.0, 260.0)
_SEGMENT_MM = (5.0, 120.0)
_FOREARM_MM = (100.0, 400.0)
_TIP_MM = (3.0, 40.0)
_WIDTH_MM = (40.0, 140.0)
SHIFT_MM, TILT_DEG = (-20.0, 20.0), (-45.0, 45.0)
"""Ranges of components of `HandSize.joints_mm` and `axes_deg`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HandSize:
    """Measures of a hand, and the deviations of one person's bones; those left out follow from its length.

    Attributes
    ----------
    side: of the body.
    hand_mm: from the wrist's crease to the tip of the middle finger (190 is chosen, a man's).
    palm_mm: from the wrist's centre to the MCP joint of the middle finger; the other MCP joints and the
        thumb's CMC joint follow in proportion.
    fingers_mm: F1 to F5, straight, each from its first joint (thumb: CMC, fingers: MCP) to the skin of the
        tip; soft tissue is taken off, then Buchholz' proportions divide it.
    segments_mm: (5, 3), functional lengths of the bones themselves, in place of `fingers_mm`.
    forearm_mm: from the elbow to the wrist.
    soft_tissue_mm: between bone and skin at the tips.
    tip_thickness_mm, tip_width_mm: of the fingertips, for the points of contact.
    width_mm: across the MCP joints; the first joints' distances from the middle finger's line follow it.
    joints_mm: (5, 3), displacement of the first joints of F1 to F5 from these places: dorsal, distal, ulnar.
    axes_deg: by segment, such as `F2m`, the tilt of the axes of the joint that moves it: a rotation vector
        about x, y and z of the segment.

    Raises InputError for lengths no hand has.
    """

    side: Literal["left", "right"] = "right"
    hand_mm: float = 190.0
    palm_mm: float | None = None
    fingers_mm: Five | None = None
    segments_mm: tuple[Three, Three, Three, Three, Three] | None = None
    forearm_mm: float | None = None
    soft_tissue_mm: Five = SOFT_TISSUE_MM
    tip_thickness_mm: Five | None = None
    tip_width_mm: Five | None = None
    width_mm: float | None = None
    joints_mm: tuple[Three, Three, Three, Three, Three] | None = None
    axes_deg: dict[str, Three] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if self.side not in ("left", "right"):
            raise InputError("hand.side", f"{self.side!r}", "'left', 'right'")
        _require("hand_mm", self.hand_mm, (), _HAND_MM)
        if self.fingers_mm is not None and self.segments_mm is not None:
            raise InputError("hand.fingers_mm", "given beside segments_mm", "one of the two", "leave one out")
        _require("soft_tissue_mm", self.soft_tissue_mm, (5,), (0.0, 15.0))
        for key, shape, limits in (
                ("palm_mm", (), _SEGMENT_MM), ("fingers_mm", (5,), (20.0, 200.0)),
                ("segments_mm", (5, 3), _SEGMENT_MM), ("forearm_mm", (), _FOREARM_MM),
                ("tip_thickness_mm", (5,), _TIP_MM), ("tip_width_mm", (5,), _TIP_MM),
                ("width_mm", (), _WIDTH_MM), ("joints_mm", (5, 3), SHIFT_MM)):
            value = getattr(self, key)
            if value is not None:
                _require(key, value, shape, limits)
        for name, tilt in self.axes_deg.items():
            if name not in JOINTED:
                raise InputError(f"hand.axes_deg.{name}", "is not moved by a joint", ", ".join(JOINTED),
                                 did_you_mean(name, JOINTED))
            _require(f"axes_deg.{name}", tilt, (3,), TILT_DEG, "deg")

    @property
    def outwards(self) -> float:
        """+1 for the left hand, whose axes point dorsal, distal, ulnar; -1 for the right: opposite."""
        return 1.0 if self.side == "left" else -1.0

    @property
    def segments(self) -> Array:
        """Functional lengths (5, 3), m."""
        if self.segments_mm is not None:
            return 1e-3 * np.array(self.segments_mm)
        if self.fingers_mm is None:
            return 1e-3 * self.hand_mm * PHALANX_RATIOS
        bone = np.array(self.fingers_mm) - np.array(self.soft_tissue_mm)
        shares = PHALANX_RATIOS / PHALANX_RATIOS.sum(axis=1, keepdims=True)
        return np.asarray(1e-3 * bone[:, np.newaxis] * shares)

    @property
    def first_joints(self) -> Array:
        """Thumb's CMC and fingers' MCP joints from the wrist's centre, (5, 2), m: distal, ulnar."""
        palm = METACARPAL_RATIOS[2] * self.hand_mm if self.palm_mm is None else self.palm_mm
        distance = 1e-3 * palm * METACARPAL_RATIOS / METACARPAL_RATIOS[2]
        angle = np.deg2rad(METACARPAL_ANGLES_DEG)
        wide = 1.0 if self.width_mm is None else self.width_mm / (WIDTH_RATIO * self.hand_mm)
        return np.asarray(distance[:, np.newaxis] * np.stack([np.cos(angle), wide * np.sin(angle)], axis=1))

    @property
    def reach(self) -> float:
        """Distance from the wrist's centre to the skin of the middle finger's tip, straight, m."""
        shift = 0.0 if self.joints_mm is None else 1e-3 * self.joints_mm[2][1]
        return float(self.first_joints[2, 0] + shift + self.segments[2].sum() + 1e-3 * self.soft_tissue_mm[2])

    @property
    def forearm(self) -> float:
        """Length of the forearm, m."""
        return 1e-3 * (FOREARM_RATIO * self.hand_mm if self.forearm_mm is None else self.forearm_mm)

    @property
    def tips(self) -> Array:
        """Soft tissue, thickness, width of the fingertips F1 to F5, (5, 3), m."""
        thick = THICKNESS_RATIOS * self.hand_mm if self.tip_thickness_mm is None else self.tip_thickness_mm
        wide = WIDTH_OF_THICKNESS * np.asarray(thick) if self.tip_width_mm is None else self.tip_width_mm
        return 1e-3 * np.stack([self.soft_tissue_mm, thick, wide], axis=1)


def _require(key: str, value: object, shape: tuple[int, ...], limits: tuple[float, float],
             unit: str = "mm") -> None:
    """Raise InputError unless `value` is numbers of that shape within the limits."""
    low, high = limits
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"hand.{key}", f"{value}", f"numbers of shape {shape}") from None
    if numbers.shape != shape:
        raise InputError(f"hand.{key}", f"shape {numbers.shape}", f"shape {shape}")
    bad = numbers[~((numbers >= low) & (numbers <= high))]
    if bad.size:
        raise InputError(f"hand.{key}", f"{bad.flat[0]:g} {unit}", f"{low:g} to {high:g} {unit}",
                         "lengths are in millimetres" if unit == "mm" else "")
