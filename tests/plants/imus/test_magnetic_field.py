"""The magnetic field against Biot and Savart's law, Maxwell's equations and the dipole's printed values."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.hand import quaternion
from plants.imus.disturbances import Dipole, MagneticField, place_carried

NOWHERE = {"strength_ut": 0.0}


def test_berlin_has_its_horizontal_and_vertical_field():
    """Niemegk observatory, 60 km off, rounded: 18.8 uT horizontal, 46 uT down."""
    east, north, up = 1e6 * MagneticField().earth
    assert east == 0.0
    assert north == pytest.approx(18.7, abs=0.3)
    assert up == pytest.approx(-46.0, abs=0.3)


def test_declination_turns_the_field_towards_east():
    east, north, _ = MagneticField(declination_deg=30.0).earth
    assert math.degrees(math.atan2(east, north)) == pytest.approx(30.0)


def test_on_axis_and_equator_of_a_dipole():
    """B = mu_0 m / (2 pi r^3) on the axis, half of it and opposite at the equator: 1 A m^2 at 10 cm."""
    field = MagneticField(**NOWHERE, dipoles=(Dipole(position=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 1.0)),))
    on_axis, equator = field.in_room([[0.0, 0.0, 0.1], [0.1, 0.0, 0.0]])
    np.testing.assert_allclose(on_axis, [0.0, 0.0, 200e-6], atol=1e-18)
    np.testing.assert_allclose(equator, [0.0, 0.0, -100e-6], atol=1e-18)


def test_far_from_a_current_loop_the_field_is_the_dipoles():
    """Biot and Savart summed over a loop of 2 mm radius that carries the moment."""
    radius, moment = 2e-3, 0.5
    angle = np.linspace(0.0, 2.0 * np.pi, 2001)
    ring = radius * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    middle, step = 0.5 * (ring[1:] + ring[:-1]), np.diff(ring, axis=0)
    point = np.array([0.11, -0.05, 0.08])
    away = point - middle
    current = moment / (np.pi * radius**2)
    expected = 1e-7 * current * (np.cross(step, away) / np.linalg.norm(away, axis=1)[:, None]**3).sum(axis=0)
    field = MagneticField(**NOWHERE, dipoles=(Dipole(position=(0, 0, 0), moment=(0, 0, moment)),))
    np.testing.assert_allclose(field.in_room(point), expected, rtol=2e-3, atol=1e-8)


@given(place=st.tuples(*[st.floats(-0.3, 0.3)] * 3), moment=st.tuples(*[st.floats(-2.0, 2.0)] * 3))
@settings(max_examples=40, deadline=None)
def test_no_sources_and_no_currents_outside_the_magnets(place, moment):
    field = MagneticField(dipoles=(Dipole(position=(0.5, 0.0, 0.1), moment=moment),
                                   Dipole(position=(0.0, -0.5, 0.0), moment=(0.3, 0.1, -0.2))))
    h = 1e-4
    steps = np.array(place) + h * np.stack([np.eye(3), -np.eye(3)])
    plus, minus = field.in_room(steps)
    gradient = (plus - minus) / (2.0 * h)
    size = np.abs(gradient).max() + 1e-6
    assert abs(np.trace(gradient)) < 1e-5 * size
    assert np.abs(gradient - gradient.T).max() < 1e-5 * size


def test_inside_a_magnet_the_field_is_uniform_and_its_normal_part_continuous():
    field = MagneticField(**NOWHERE, dipoles=(Dipole(position=(0, 0, 0), moment=(0, 0, 1), radius_m=0.01),))
    centre, inside, outside = field.in_room([[0, 0, 0], [0, 0, 0.00999], [0, 0, 0.01001]])
    np.testing.assert_array_equal(centre, inside)
    assert outside[2] == pytest.approx(inside[2], rel=4e-3)
    assert np.isfinite(centre).all()


def test_a_carried_magnet_moves_and_turns_with_its_site():
    rng = np.random.default_rng(3)
    orientation = quaternion.normalized(rng.normal(size=(4, 4)))
    position = rng.normal(size=(4, 3))
    field = MagneticField(dipoles=(Dipole(position=(0.01, 0.02, 0.03), moment=(0.1, 0.2, 0.3), carrier="F2d"),
                                   Dipole(position=(1.0, 0.0, 0.0), moment=(1.0, 0.0, 0.0))))
    assert field.carriers == ("F2d",)
    assert len(field.fixed) == 1
    placed = np.empty((1, 7))
    place_carried(field.carried, np.array([2]), orientation, position, placed)
    matrix = quaternion.to_matrix(orientation[2])
    np.testing.assert_allclose(placed[0, :3], position[2] + matrix @ [0.01, 0.02, 0.03], atol=1e-15)
    np.testing.assert_allclose(placed[0, 3:6], matrix @ [0.1, 0.2, 0.3], atol=1e-15)
    assert placed[0, 6] == 0.005


@pytest.mark.parametrize(("make", "name"), [
    (lambda: MagneticField(strength_ut=-1.0), "strength_ut"),
    (lambda: MagneticField(inclination_deg=91.0), "inclination_deg"),
    (lambda: MagneticField(declination_deg=math.nan), "declination_deg"),
    (lambda: Dipole(position=(0.0, 0.0), moment=(0.0, 0.0, 1.0)), "position"),
    (lambda: Dipole(position=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 1.0), radius_m=0.0), "radius_m")])
def test_parameters_that_cannot_be_are_named(make, name):
    with pytest.raises(InputError, match=name):
        make()
