"""Geometry of electrode arrays, and virtual electrodes in place of those of other arrays."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from fesloop.errors import InputError
from fesloop.forms.schema import plain
from fesloop.models.electrode_arrays import (
    FARTHEST_MM,
    USUAL,
    ArrayLayout,
    ElectrodeArray,
    ElectrodeArrays,
    VirtualElectrode,
    arrays_in_words,
    distances_mm,
)

RADIUS_MM = 40.0
GRIDS = st.builds(ArrayLayout, rows=st.integers(1, 5), columns=st.integers(1, 5),
                  pitch_mm=st.floats(5.0, 20.0).map(lambda pitch: (pitch, pitch)),
                  centre_deg=st.floats(-400.0, 400.0), centre_mm=st.floats(100.0, 150.0))


def listed(layout):
    """The elements of a grid as positions."""
    places = layout.places(RADIUS_MM)
    return ArrayLayout(positions=tuple((math.degrees(around / RADIUS_MM), along) for around, along in places))


def cut_at_the_girth(layout):
    return layout.rows * layout.pitch_mm[0] > math.pi * RADIUS_MM


@given(GRIDS)
def test_positions_of_a_grid_are_places_and_neighbours_of_the_grid(grid):
    assume(not cut_at_the_girth(grid))
    same = listed(grid)
    np.testing.assert_allclose(same.places(RADIUS_MM), grid.places(RADIUS_MM), atol=1e-9)
    assert sorted(same.neighbours(RADIUS_MM)) == sorted(grid.neighbours(RADIUS_MM))


@given(st.lists(st.tuples(st.floats(-60.0, 60.0), st.floats(40.0, 200.0)), min_size=4, max_size=12))
def test_neighbours_by_position_are_edges_of_the_delaunay_triangulation(positions):
    places = np.array(positions) * (math.radians(RADIUS_MM), 1.0)
    apart = distances_mm(places, places, RADIUS_MM) + 1e9 * np.eye(len(places))
    assume(apart.min() > 1.0 and np.linalg.svd(places - places.mean(axis=0))[1][-1] > 5.0)
    edges = {frozenset(edge) for triangle in Delaunay(places).simplices for edge in
             ((triangle[0], triangle[1]), (triangle[1], triangle[2]), (triangle[0], triangle[2]))}
    found = ArrayLayout(positions=tuple(positions)).neighbours(RADIUS_MM)
    assert {frozenset(pair) for pair in found} <= edges
    for one in range(len(places)):  # the nearest element is always a neighbour
        nearest = np.flatnonzero(apart[one] <= apart[one].min() + 1e-9)
        assert len(nearest) > 1 or tuple(sorted((one, int(nearest[0])))) in found


@given(st.integers(3, 12), st.floats(0.0, 360.0))
def test_a_bracelet_is_closed(count, first_deg):
    bracelet = ArrayLayout(positions=tuple((first_deg + 360.0 * k / count, 100.0) for k in range(count)))
    ring = {tuple(sorted((k, (k + 1) % count))) for k in range(count)}
    assert set(bracelet.neighbours(RADIUS_MM)) == ring


@given(st.floats(-720.0, 720.0), st.floats(-720.0, 720.0), st.floats(0.0, 200.0))
def test_distances_on_the_skin_are_the_shorter_way_round(one_deg, other_deg, along):
    places = np.radians([[one_deg], [other_deg]]) * RADIUS_MM
    one, other = np.hstack([places, [[0.0], [along]]])
    chord = 2.0 * RADIUS_MM * abs(math.sin(math.radians(one_deg - other_deg) / 2.0))
    arc = 2.0 * RADIUS_MM * math.asin(min(1.0, chord / (2.0 * RADIUS_MM)))
    found = distances_mm(one[np.newaxis], other[np.newaxis], RADIUS_MM)
    np.testing.assert_allclose(found, math.hypot(arc, along), atol=1e-5)


@given(st.lists(st.sampled_from(range(59)), min_size=1, max_size=8, unique=True))
def test_the_nearest_elements_of_the_same_arrays_are_the_same(elements):
    channels = tuple(VirtualElectrode(elements=(element,)) for element in elements)
    assert ElectrodeArrays(arrays=USUAL).in_place_of(channels) == channels


@given(st.permutations(range(59)), st.lists(st.floats(0.01, 1.0), min_size=1, max_size=4))
def test_the_nearest_elements_keep_the_current(order, weights):
    shares = np.array(weights) / sum(weights)
    electrode = VirtualElectrode(elements=tuple(order[:len(shares)]), shares=tuple(shares.tolist()))
    coarse = ElectrodeArrays(arrays=(ElectrodeArray(rows=8, columns=5, pitch_mm=(31.0, 25.0), pad_mm=5.0),))
    made = coarse.in_place_of([electrode])[0]
    assert sum(made.shares or (1.0,)) == pytest.approx(1.0)
    apart = distances_mm(ElectrodeArrays(arrays=USUAL).pads(RADIUS_MM), coarse.pads(RADIUS_MM), RADIUS_MM)
    for element in electrode.elements:
        assert apart[element][list(made.elements)].min() == apart[element].min() <= FARTHEST_MM


@pytest.mark.parametrize(("away_mm", "refused"), [(19.9, False), (20.1, True)])
def test_the_nearest_element_lies_at_most_twenty_millimetres_away(away_mm, refused):
    one = ElectrodeArrays(arrays=(ElectrodeArray(positions=((0.0, 106.0 + away_mm),)),))
    middle = [VirtualElectrode(elements=(17,))]  # row 2 of 5, column 3 of 7: the middle, 0 deg and 106 mm
    if refused:
        with pytest.raises(InputError, match="lies 20 mm from it; allowed: at most 20 mm"):
            one.in_place_of(middle)
    else:
        assert one.in_place_of(middle) == (VirtualElectrode(elements=(0,)),)


def test_areas_are_those_of_discs():
    small, large = ElectrodeArray(rows=1, columns=2, pad_mm=5.0), ElectrodeArray(
        rows=1, columns=1, centre_deg=90.0, pad_mm=10.0)
    assert ElectrodeArrays(arrays=(small,)).areas_cm2 == pytest.approx(0.25 * math.pi)
    assert ElectrodeArrays(arrays=(small, large)).areas_cm2 == pytest.approx(
        (0.25 * math.pi, 0.25 * math.pi, math.pi))


def test_words_tell_arrays_apart():
    def words(*arrays):
        return arrays_in_words({"arrays": plain(arrays)})

    assert arrays_in_words(None) == arrays_in_words({}) == words(*USUAL) == ""
    own = ElectrodeArray(rows=2, columns=3)
    assert words(own).startswith("2 x 3 at 16 x 16 mm (")
    assert words(own) != words(ElectrodeArray(rows=2, columns=3, centre_deg=1.0))
    assert words(ElectrodeArray(positions=((0.0, 50.0),))).startswith("1 positions (")


@pytest.mark.parametrize(("make", "where", "found"), [
    (lambda: ElectrodeArrays(arrays=()), "arrays", "none"),
    (lambda: ElectrodeArrays(arrays=(ElectrodeArray(rows=2, columns=2, pitch_mm=(12.0, 20.0)),)
                             ).require_apart(RADIUS_MM), "arrays", "elements 0 and 2 overlap: 12 mm apart"),
    (lambda: ElectrodeArrays(arrays=(ElectrodeArray(rows=1, columns=1), ElectrodeArray(rows=1, columns=1))
                             ).require_apart(RADIUS_MM), "arrays", "elements 0 and 1 overlap"),
    (lambda: ElectrodeArrays(arrays=USUAL).require_apart(15.0), "arrays", " overlap: "),
    (lambda: ElectrodeArrays(arrays=(ElectrodeArray(rows=1, columns=1),),
                             channels=(VirtualElectrode(elements=(1,)),)),
     "channels[0].elements", "element 1 does not exist"),
    (lambda: ElectrodeArrays(arrays=USUAL[:1]).in_place_of([VirtualElectrode(elements=(50,))]),
     "channels", "channel 0 has element 50"),
    (lambda: ElectrodeArrays(arrays=(ElectrodeArray(rows=1, columns=1),)).in_place_of(
        [VirtualElectrode(elements=(17,)), VirtualElectrode(elements=(18,))]),
     "channels", "channels 0 and 1 would both have element 0"),
    (lambda: ElectrodeArrays(arrays=USUAL).in_place_of([VirtualElectrode(elements=(59,))]),
     "channels", "element 59 of channel 0 is none of the usual arrays"),
    (lambda: ArrayLayout(rows=2, columns=2, positions=((0.0, 50.0),)), "array", "2 rows, 2 columns and 1"),
])
def test_contradictions_are_refused(make, where, found):
    with pytest.raises(InputError) as fault:
        make()
    assert fault.value.where == where
    assert found in fault.value.found
