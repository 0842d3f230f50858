"""Where force sensors are: stated by their block, used by controllers that read them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.force_sensors import contact_force, require_count, wired_places
from fesloop.errors import InputError
from fesloop.experiment.files.parse import load
from fesloop.hand.anthropometry import FINGERTIPS, PARTS
from fesloop.hand.grip import grip_force
from fesloop.loop.signals import Sensors

NEWTON = st.floats(0.0, 30.0)


def part_of(name, node):
    return next(each.part for each in load(*name).wiring.nodes if each.name == node)


@pytest.mark.parametrize(("settings_", "places"), [([], PARTS), (["glove=fingertips"], FINGERTIPS)])
def test_controllers_know_where_the_wired_sensors_are(settings_, places):
    for name in ("grasp_mpc", "grasp_ilc"):
        for node in ("controller", "grip"):
            assert part_of((name, settings_), node).places == places
    assert part_of(("hold_grip_force", settings_), "grip").places == places


@given(st.lists(NEWTON, min_size=16, max_size=16), st.lists(st.sampled_from(PARTS), unique=True))
@settings(deadline=None)
def test_contact_is_the_strongest_of_the_places_that_count(newton, counting):
    forces = np.array(newton)
    force, place = contact_force(forces, PARTS, tuple(counting))
    assert force == max(forces[PARTS.index(each)] for each in counting or PARTS)
    assert force == forces[PARTS.index(place)]
    assert place in (counting or PARTS)
    assert contact_force(forces, (), ())[0] == forces.max()


def test_a_force_that_is_no_number_hides_no_contact():
    assert contact_force(np.array([math.nan, 0.2, 0.7, math.nan, 0.1]), FINGERTIPS, ()) == (0.7, "F3d")


def test_places_are_those_of_the_source_unless_it_has_other_names():
    assert wired_places((), {"force": Sensors(FINGERTIPS)}) == FINGERTIPS
    assert wired_places(FINGERTIPS, {"force": Sensors(FINGERTIPS)}) == FINGERTIPS
    assert wired_places(FINGERTIPS, {"force": Sensors(("a", "b", "c", "d", "e"))}) == FINGERTIPS
    assert wired_places(FINGERTIPS, {}) == FINGERTIPS
    with pytest.raises(InputError, match="remove it"):
        wired_places(("F1d", "palm"), {"force": Sensors(FINGERTIPS)})
    with pytest.raises(InputError, match="'a' is no part of the hand"):
        wired_places((), {"force": Sensors(("a", "b"))})
    with pytest.raises(InputError, match="5 wired forces have no names"):
        require_count((), {"force": (5,)})


@pytest.mark.parametrize(("setting", "message"), [
    ("blocks.controller.fingertips=5", "'fingertips' is now called 'places'"),
    ("blocks.grip.fingertips=5", "'fingertips' is now called 'places'"),
    ("blocks.grip.thumb=0", "'thumb' is now called 'places'"),
    ('blocks.controller.places=["F1d", "F2d"]', "places: F1d, F2d; allowed: palm, F1m"),
    ('blocks.controller.contact_places=["F9"]', "'F9' is no part of the hand"),
    ('blocks.grip.places=["palm", "palm"]', "'palm' is listed twice"),
    ("blocks.force.places=[]", "is empty")])
@pytest.mark.parametrize("name", ["grasp_mpc", "grasp_ilc"])
def test_sensors_that_cannot_be_are_refused_in_one_line(name, setting, message):
    with pytest.raises(InputError) as fault:
        load(name, [setting])
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)


def test_contact_where_no_sensor_is_is_refused():
    with pytest.raises(InputError, match="F2m: no force sensor is there"):
        load("grasp_mpc", ["glove=fingertips", 'blocks.controller.contact_places=["F2m"]'])


def test_forces_of_another_shape_are_refused():
    with pytest.raises(InputError, match=r"shape"):
        load("grasp_mpc", ['wires."hand.contact_force->force.contact_force".from="hand.angles"'])


@given(st.lists(NEWTON, min_size=4, max_size=4), st.sampled_from(["p", "m", "d"]), st.floats(0.0, 1.0),
       st.sets(st.sampled_from(PARTS), min_size=1))
@settings(deadline=None)
def test_what_has_no_sensor_makes_the_grip_look_weaker_never_stronger(newton, row, share, felt):
    """Fingers of one row against thumb and palm: with all parts the grip is the force of either side."""
    parts = dict.fromkeys(PARTS, 0.0) | {f"F{i}{row}": newton[i - 2] for i in range(2, 6)}
    parts |= {"F1d": share * sum(newton), "palm": (1.0 - share) * sum(newton)}
    whole = grip_force(np.array(list(parts.values())), PARTS)
    assert whole == pytest.approx(sum(newton))
    places = tuple(place for place in PARTS if place in felt)
    part = grip_force(np.array([parts[place] for place in places]), places)
    assert part <= whole * (1.0 + 1e-12)
    if set(places) >= {f"F{i}{row}" for i in range(2, 6)}:
        assert part == pytest.approx(whole)
