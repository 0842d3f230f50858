"""Integers and Booleans of an FMU: rounded once, never bent to fit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from plants.fmu.description import FmuDescription, FmuVariable
from plants.fmu.library import as_type
from plants.fmu.plant import _checked_starts

INTEGERS = st.sampled_from([np.int8, np.uint8, np.int16, np.uint16, np.int32, np.uint32, np.int64, np.uint64])


def described(variable):
    return FmuDescription(
        version=2, interface="co_simulation", identifier="m", token="t", variables={variable.name: variable},
        states=0, indicators=0, completes_steps=False, saves=False, once=False, needs_tool=False,
        internal_step_s=0.0, has_sources=False)


@given(value=st.floats(), kind=INTEGERS)
def test_an_integer_input_is_the_nearest_or_none(value, kind):
    limits = np.iinfo(kind)
    try:
        found = as_type(np.array([value]), np.dtype(kind), False).astype(kind)
    except OverflowError:
        assert not np.isfinite(value) or not limits.min <= round(value) <= limits.max
    else:
        assert int(found[0]) == round(value)


@pytest.mark.parametrize(("value", "expected"), [(1.7, 1), (0.4, 0), (0.6, 1), (-3.0, 0), (np.nan, 0)])
@pytest.mark.parametrize("kind", [np.int32, np.bool_])
def test_a_boolean_input_is_true_above_a_half(value, expected, kind):
    assert as_type(np.array([value]), np.dtype(kind), True).astype(kind)[0] == expected


@pytest.mark.parametrize(("kind", "value", "words"), [
    ("Integer", 2.7, "a whole number"), ("Integer", 4e9, "a whole number"), ("Integer", 2**31, "a whole"),
    ("Integer", float("nan"), "a whole number"), ("Enumeration", 1.5, "a whole number"),
    ("Boolean", 2, "true or false"), ("Integer", 7.0, ""), ("Boolean", 1, ""), ("Boolean", False, "")])
def test_a_start_value_fits_its_type_or_is_refused(kind, value, words):
    description = described(FmuVariable("k", 0, kind, "parameter", "fixed", (), "1", 0.0))
    if not words:
        assert _checked_starts(description, {"k": value}) == (("k", value),)
        return
    with pytest.raises(InputError, match=words):
        _checked_starts(description, {"k": value})


@pytest.mark.parametrize(("causality", "variability", "words"), [
    ("structuralParameter", "fixed", "starts.k: is a structural parameter"),
    ("local", "constant", "starts.k: is not a settable variable of the FMU"),
    ("parameter", "constant", "starts.k: is not a settable variable of the FMU"),
    ("output", "constant", "starts.k: is no"), ("independent", "continuous", "starts.k: is no"),
    ("calculatedParameter", "fixed", "starts.k: is no"), ("parameter", "fixed", ""),
    ("parameter", "tunable", ""), ("input", "discrete", ""), ("local", "fixed", "")])
def test_only_what_can_have_an_effect_is_a_start_value(causality, variability, words):
    description = described(FmuVariable("k", 0, "Integer", causality, variability, (), "1", 0.0))
    if not words:
        assert _checked_starts(description, {"k": 3}) == (("k", 3),)
        return
    with pytest.raises(InputError, match=words) as refused:
        _checked_starts(description, {"k": 3})
    assert "\n" not in str(refused.value)


def test_inputs_are_named_among_what_can_have_a_start_value():
    description = described(FmuVariable("u1", 0, "Real", "input", "continuous", (), "1", 0.0))
    with pytest.raises(InputError, match=r"starts\.u9: .*allowed: u1"):
        _checked_starts(description, {"u9": 1.0})
