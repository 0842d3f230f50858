"""Tables written as TOML are read back the same."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.forms.toml import toml_text

TEXT = st.text(st.characters(exclude_categories=["Cs"]))
SCALARS = TEXT | st.booleans() | st.integers(-2**63, 2**63 - 1) | st.floats(allow_nan=False)
ITEMS = SCALARS | st.lists(SCALARS, max_size=3) | st.dictionaries(TEXT, SCALARS, max_size=2)
VALUES = SCALARS | st.lists(ITEMS, max_size=3)
TABLES = st.recursive(st.dictionaries(TEXT, VALUES, max_size=3),
                      lambda below: st.dictionaries(TEXT, VALUES | below, max_size=3), max_leaves=12)


@given(TABLES)
def test_what_is_written_is_read(tables):
    assert tomllib.loads(toml_text(tables)) == tables


def test_it_reads_as_a_person_would_write_it():
    assert toml_text({"name": "anna", "strength": {"overall": 0.5, "muscles": {"FDP2": 1.0}}}) == (
        'name = "anna"\n\n[strength]\noverall = 0.5\n\n[strength.muscles]\nFDP2 = 1.0\n')


def test_lists_of_tables_read_as_a_person_would_write_them():
    tables = {"blocks": {"arrays": [{"rows": 5}, {"rows": 6}]},
              "wires": [{"from": "a", "jitter": {"kind": "zero"}}]}
    assert toml_text(tables) == (
        '\n[blocks]\narrays = [\n    { rows = 5 },\n    { rows = 6 },\n]\n'
        '\n[[wires]]\nfrom = "a"\njitter = { kind = "zero" }\n')


def test_what_has_no_place_in_toml_is_refused():
    with pytest.raises(TypeError, match="no place"):
        toml_text({"side": None})
