"""Theory's lines as they were kept."""

import pytest

from fesloop.analysis.study.store.file import THEORY
from fesloop.errors import InputError
from fesloop.show.figures.content import Overlay
from fesloop.show.figures.theory_overlays import keep_overlays, kept_overlays

LINES = {"map": [Overlay(label="theory", x=[30.0, 10.5], y=[0.0, 5.0], panel="pid")],
         "curves": [Overlay(label="theory", x=[25.0], y=[], line=0.3), Overlay(label="other", x=[1.0], y=[])],
         "none": []}


def test_what_is_kept_comes_back(tmp_path):
    keep_overlays(tmp_path, "today", LINES)
    assert kept_overlays(tmp_path, "today") == LINES


def test_lines_of_another_store_do_not(tmp_path):
    keep_overlays(tmp_path, "today", LINES)
    assert kept_overlays(tmp_path, "yesterday") == {}
    assert kept_overlays(tmp_path / "elsewhere", "today") == {}


@pytest.mark.parametrize("text", [
    "", "[]", "{}", '{"created": "today", "figures": {"map": [{"label": "a"}]}}',
    '{"created": "today", "figures": {"map": [{"label": "a", "x": []}]}}'])
def test_a_damaged_file_is_told_in_one_line(tmp_path, text):
    (tmp_path / THEORY).write_text(text)
    with pytest.raises(InputError) as fault:
        kept_overlays(tmp_path, "today")
    assert "\n" not in str(fault.value)


def test_a_folder_that_is_not_there_is_told(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        keep_overlays(tmp_path / "nowhere", "today", LINES)
