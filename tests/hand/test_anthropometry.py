"""Lengths of a hand: from its length, as measured, and those no hand has."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from fesloop.errors import InputError
from fesloop.hand.anthropometry import METACARPAL_ANGLES_DEG, METACARPAL_RATIOS, SOFT_TISSUE_MM, HandSize

FIVE = (1.0, 1.0, 1.0, 1.0, 1.0)


@given(st.floats(100.0, 260.0))
def test_the_middle_fingers_ray_makes_up_the_hands_length(hand_mm):
    size = HandSize(hand_mm=hand_mm)
    ray = size.first_joints[2, 0] + size.segments[2].sum()
    assert 1e-3 * hand_mm - 2.0 * 1e-3 * SOFT_TISSUE_MM[2] < ray < 1e-3 * hand_mm


@pytest.mark.parametrize(("finger", "distal", "radial_breadths"), [(1, .447, .251), (3, .409, -.206),
                                                                   (4, .368, -.402)])
def test_finger_joints_lie_where_buchholz_has_them(finger, distal, radial_breadths):
    # Joint centres over hand length and breadth, a second table of the same study.
    angle = np.deg2rad(METACARPAL_ANGLES_DEG[finger])
    assert METACARPAL_RATIOS[finger] * np.cos(angle) == pytest.approx(distal, abs=.003)
    breadth = -METACARPAL_RATIOS[finger] * np.sin(angle) / radial_breadths
    assert .46 < breadth < .49


def test_soft_tissue_comes_off_measured_fingers_and_proportions_divide_the_rest():
    fingers = (110.0, 95.0, 105.0, 98.0, 78.0)
    size = HandSize(hand_mm=185.0, fingers_mm=fingers)
    np.testing.assert_allclose(1e3 * size.segments.sum(axis=1) + SOFT_TISSUE_MM, fingers)
    np.testing.assert_allclose(size.segments[1, 0] / size.segments[1, 1], .245 / .143)
    thick_skinned = HandSize(hand_mm=185.0, fingers_mm=fingers, soft_tissue_mm=(9.0, 9.0, 9.0, 9.0, 9.0))
    assert (thick_skinned.segments < size.segments).all()


def test_what_is_measured_goes_before_what_follows():
    segments = ((45.0, 36.0, 28.0), (46.0, 26.0, 18.0), (50.0, 31.0, 20.0), (45.0, 30.0, 20.0),
                (37.0, 21.0, 17.0))
    size = HandSize(palm_mm=90.0, segments_mm=segments, forearm_mm=250.0, tip_thickness_mm=(14.0,) * 5)
    np.testing.assert_allclose(size.segments, 1e-3 * np.array(segments))
    assert size.first_joints[2].tolist() == [0.09, 0.0]
    assert np.hypot(*size.first_joints[1]) == pytest.approx(0.09 * .463 / .446)
    assert size.forearm == pytest.approx(0.25)
    np.testing.assert_allclose(size.tips[:, 1:], [[0.014, 0.0168]] * 5)


def test_a_hand_reads_from_an_experiment_file():
    written = '{"side": "left", "hand_mm": 182.0, "fingers_mm": [110.0, 95.0, 105.0, 98.0, 78.0]}'
    size = TypeAdapter(HandSize).validate_json(written, strict=True)
    assert size == HandSize(side="left", hand_mm=182.0, fingers_mm=(110.0, 95.0, 105.0, 98.0, 78.0))


@pytest.mark.parametrize(("fields", "said"), [
    ({"side": "middle"}, "'left', 'right'"),
    ({"hand_mm": -190.0}, "hand.hand_mm: -190 mm; allowed: 100 to 260 mm"),
    ({"hand_mm": 0.19}, "lengths are in millimetres"),
    ({"hand_mm": float("nan")}, "nan mm"),
    ({"palm_mm": 0.0}, "hand.palm_mm: 0 mm"),
    ({"fingers_mm": (110.0, 95.0, -105.0, 98.0, 78.0)}, "hand.fingers_mm: -105 mm"),
    ({"fingers_mm": (110.0, 95.0)}, r"shape \(2,\); allowed: shape \(5,\)"),
    ({"segments_mm": ((45.0, 36.0), (46.0, 26.0, 18.0))}, r"numbers of shape \(5, 3\)"),
    ({"fingers_mm": FIVE, "segments_mm": (FIVE[:3],) * 5}, "given beside segments_mm"),
    ({"soft_tissue_mm": (5.0, 4.0, 4.0, 4.0, 40.0)}, "hand.soft_tissue_mm: 40 mm"),
])
def test_lengths_no_hand_has_are_refused_in_one_line(fields, said):
    with pytest.raises(InputError, match=said) as caught:
        HandSize(**fields)
    assert "\n" not in str(caught.value)
