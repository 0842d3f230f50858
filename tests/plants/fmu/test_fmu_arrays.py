"""Start values of FMI 3.0 arrays: what the FMU has, and what its ports show, before the first message."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.block import Context
from plants.fmu import Fmu

NUMBERS = st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3)
SIZES = ('start="3"', 'valueReference="4"')


def followed(plant, steps=20):
    """Outputs of a plant whose input stays at what it is before the first message."""
    state = plant.init(Context("plant"))
    (port,) = plant.inputs
    for _ in range(steps):
        plant.advance(state, [port.initial_value()], 0, 0)
    (values,) = plant.read(state, [])
    plant.close(state)
    return values


def risen(start, steps=20):
    """The same in closed form."""
    return np.asarray(start) * (1.0 - math.exp(-steps * 1e-3 / 0.1))


@pytest.mark.parametrize("isolate", [True, False])
@pytest.mark.parametrize("dimension", SIZES)
@pytest.mark.parametrize(("said", "start"), [("1 2 3", (1, 2, 3)), ("4 4 4", (4, 4, 4)), ("-5", (-5,) * 3)])
def test_an_array_has_its_start_values_until_the_first_message(small3, isolate, dimension, said, start):
    made = ", ".join(map(str, start))
    plant = Fmu(path=str(small3(f"STARTS={made}", start=said, dimension=dimension)), isolate=isolate)
    np.testing.assert_array_equal(plant.inputs[0].initial_value(), start)
    np.testing.assert_allclose(followed(plant), risen(start), rtol=1e-12)


@settings(max_examples=8, deadline=None)
@given(start=NUMBERS)
def test_an_array_is_given_start_values(start, small3_made):
    plant = Fmu(path=small3_made, starts={"u": tuple(start)}, isolate=False)
    np.testing.assert_array_equal(plant.inputs[0].initial_value(), start)
    np.testing.assert_allclose(followed(plant), risen(start), rtol=1e-12, atol=1e-300)


def test_an_array_is_given_start_values_in_a_file(small3_made, tmp_path):
    experiment = from_document({
        "experiment": {"name": "given", "duration_s": 0.02},
        "blocks": {"plant": {"kind": "fmu", "path": small3_made, "starts": {"u": [1, 2.5, 3]},
                             "input_ports": [{"name": "u", "variables": ["u"], "unit": "rad"}]},
                   "reference": {"kind": "minimum_jerk", "rate": "50", "times_s": [0.0, 0.1],
                                 "angles_deg": [[0, 0, 0], [30, 30, 30]]}},
        "wires": [{"from": "reference.angles", "to": "plant.u", "latency_ms": 500}]})
    result = experiment.run(tmp_path)
    with Recording(result.recording) as recording:
        signal = recording.signal("plant.y")
        assert signal.times_ns[-1] > 0
        steps = int(signal.times_ns[-1] // 1_000_000)
        np.testing.assert_allclose(signal.values[-1], risen([1, 2.5, 3], steps), rtol=1e-12)


@pytest.mark.parametrize(("value", "words"), [
    (7.0, r"starts\.u: 7\.0 for an array of shape \[3\]; allowed: a list of 3 numbers"),
    ((1.0, 2.0), "a list of 3 numbers"), (((1.0, 2.0, 3.0),), "a list of 3"), ((1.0, "2", 3.0), "a value of"),
    ((1.0, math.nan, 3.0), r"starts\.u: nan")])
def test_start_values_that_do_not_fit_an_array(small3_made, value, words):
    with pytest.raises(InputError, match=words):
        Fmu(path=small3_made, starts={"u": value})


def test_a_list_is_no_start_value_of_a_scalar(small3_made):
    with pytest.raises(InputError, match=r"starts\.h: \(1\.0,\); allowed: a value of type Float64"):
        Fmu(path=small3_made, starts={"h": (1.0,)})


@pytest.mark.parametrize("said", ["1 2", "1 2 3 4"])
def test_a_description_with_too_few_or_many_start_values_is_refused(small3, said):
    with pytest.raises(InputError, match=r"gives \d start values for the 3 elements of 'u'"):
        Fmu(path=str(small3(start=said)))


@pytest.fixture(scope="module")
def small3_made(small3):
    """One for all."""
    return str(small3())
