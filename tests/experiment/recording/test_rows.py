"""What the loop's recorder holds, as rows of a recording."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.experiment.recording.form import EVENT, event_rows

SIZES = {field: EVENT[field].itemsize for field in ("where", "status", "detail")}


def stored(text):
    """The text in each field of an event, as it is read again."""
    (row,) = event_rows([(0, text, text, text)], 0)
    return {field: row[field].decode() for field in SIZES}


@given(st.text(st.characters(exclude_characters="\0", codec="utf-8"), max_size=300))
def test_long_texts_end_in_dots_after_a_whole_letter(text):
    for field, found in stored(text).items():
        if len(text.encode()) <= SIZES[field]:
            assert found == text
        else:
            assert found.endswith("...")
            assert text.startswith(found[:-3])
            assert SIZES[field] - 4 < len(found.encode()) <= SIZES[field]


@pytest.mark.parametrize("letter", ["µ", "°", "→", "𝛼"])
def test_a_letter_of_several_bytes_is_not_split(letter):
    for before in range(4):
        assert stored("x" * before + 100 * letter)["status"].rstrip(".").strip("x") == letter * (
            (SIZES["status"] - 3 - before) // len(letter.encode()))


def test_what_is_no_letter_is_marked():
    """Names of files can be any bytes."""
    assert stored("no \udcff.h5")["detail"] == "no ?.h5"
