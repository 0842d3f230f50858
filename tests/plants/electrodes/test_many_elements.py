"""Numbers of elements that no array has are refused before tables of them are made."""

import pytest

from fesloop import load
from fesloop.errors import InputError
from fesloop.models.electrode_arrays import MOST_ELEMENTS, ElectrodeArray
from plants.stimulator import Stimulator


def test_as_many_as_are_allowed_are_made_and_one_more_is_refused():
    assert ElectrodeArray(rows=1, columns=MOST_ELEMENTS).elements == MOST_ELEMENTS
    with pytest.raises(InputError, match=f"at most {MOST_ELEMENTS}"):
        ElectrodeArray(rows=1, columns=MOST_ELEMENTS + 1)


def test_a_stimulator_makes_no_table_of_elements_that_do_not_fit_in_memory():
    with pytest.raises(InputError, match=r"stimulator\.elements: 2147483648"):
        Stimulator(elements=2**31, channels=8)


def test_a_patient_draws_no_gains_for_an_array_that_will_be_refused():
    with pytest.raises(InputError, match=r"array: 35000000000 elements"):
        load("grasp_ilc", ["blocks.electrodes.arrays=[{rows = 5, columns = 7_000_000_000}]"])
