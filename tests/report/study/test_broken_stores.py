"""Of what is damaged, unfinished or of another version, what can be read is shown, and what not is said."""

import json
import sqlite3
from contextlib import closing

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from study_stores import change, write_store

from fesloop.errors import InputError
from fesloop.show.report.page import page_html
from fesloop.show.report.parts import Notice
from fesloop.show.report.study.page import study_page

AXES = {"latency_ms": list(range(0, 400, 4)), "law": ["pid", "mpc"]}


def notices(page):
    return [part.text for section in page.sections for part in section.parts if isinstance(part, Notice)]


def tell(path, statement, *values):
    with closing(sqlite3.connect(path)) as store, store:
        store.execute(statement, values)


def told(path):
    """The page, or the line that says why there is none."""
    try:
        return page_html(study_page(path))
    except InputError as fault:
        return "\n" not in str(fault) and str(path) in str(fault)


def write(path, outcome=lambda levels, replicate: {"error_deg": 1.0 + levels["latency_ms"]}):
    return write_store(path, AXES, 2, outcome)


def test_a_study_under_way_shows_what_is_over(tmp_path):
    page = study_page(write(tmp_path / "a.sqlite", lambda levels, replicate:
                            {"error_deg": 1.0} if levels["law"] == "mpc" and not replicate else None))
    assert "300 of its 400 runs are not over yet" in page.sentence
    assert ("runs", "100 of 400 over") in list(page.facts)


def test_a_study_that_has_just_begun_says_so(tmp_path):
    page = study_page(write(tmp_path / "a.sqlite", lambda levels, replicate: None))
    assert "None of its 400 runs is over yet." in page.sentence
    assert any("Nothing to show yet" in text for text in notices(page))
    assert page_html(page)


def test_a_store_without_a_plan_is_no_fault(tmp_path):
    path = write_store(tmp_path / "a.sqlite", {"latency_ms": []}, 1, lambda levels, replicate: {})
    page = study_page(path)
    assert "No run is planned." in page.sentence
    assert page_html(page)


def test_another_version_is_refused_in_one_line(tmp_path):
    path = write(tmp_path / "a.sqlite")
    tell(path, "UPDATE about SET value = 'fesloop study 9' WHERE key = 'format'")
    with pytest.raises(InputError, match="'fesloop study 9'; allowed: 'fesloop study 2'"):
        study_page(path)


def test_a_store_that_was_cut_is_refused_in_one_line(tmp_path):
    path = write(tmp_path / "a.sqlite")
    whole = path.read_bytes()
    path.write_bytes(whole[:int(0.8 * len(whole))])
    assert told(path) is True


@pytest.mark.slow
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(share=st.floats(0.0, 0.999), at=st.floats(0.0, 0.95), bytes_=st.binary(min_size=1, max_size=2000))
def test_whatever_is_broken_gives_a_page_or_one_line(tmp_path, share, at, bytes_):
    path = tmp_path / "a.sqlite"
    if not (tmp_path / "whole").exists():
        (tmp_path / "whole").write_bytes(write(tmp_path / "b.sqlite").read_bytes())
    whole = bytearray((tmp_path / "whole").read_bytes())
    place = int(at * len(whole))
    whole[place:place + len(bytes_)] = bytes_
    path.write_bytes(bytes(whole[:max(1, int(share * len(whole)))]) if share < 0.7 else bytes(whole))
    assert told(path)


@pytest.mark.parametrize("content", [b"", b"not a database", b"\x89HDF\r\n\x1a\n" + bytes(100)])
def test_a_foreign_file_is_told_in_one_line(tmp_path, content):
    path = tmp_path / "a.sqlite"
    path.write_bytes(content)
    with pytest.raises(InputError, match="study") as fault:
        study_page(path)
    assert "\n" not in str(fault.value)


def test_a_foreign_database_is_told_in_one_line(tmp_path):
    path = tmp_path / "a.sqlite"
    tell(path, "CREATE TABLE music (title TEXT)")
    with pytest.raises(InputError, match="not a study's store"):
        study_page(path)


def test_nothing_there_is_told(tmp_path):
    with pytest.raises(InputError, match=r"holds no study\.sqlite"):
        study_page(tmp_path)


def test_a_study_that_does_not_say_what_it_asks_is_told(tmp_path):
    path = write(tmp_path / "a.sqlite")
    tell(path, "UPDATE about SET value = '{' WHERE key = 'study'")
    assert told(path) is True


def test_a_changed_row_is_shown_and_said(tmp_path):
    path = write(tmp_path / "a.sqlite")
    tell(path, "DELETE FROM results WHERE id = 'run 3 0'")
    page = study_page(path)
    assert page.sentence.startswith("Its store is damaged")
    assert page.sections[0].key == "damage"
    assert "its rows are not those that fesloop wrote" in notices(page)[0]
    assert ("runs", "399 of 400 over") in list(page.facts)
    assert page_html(page)


def test_rows_that_do_not_fit_are_one_line(tmp_path):
    path = write(tmp_path / "a.sqlite")
    change(path, "UPDATE results SET metrics = ? WHERE id = 'run 50 0'", json.dumps([1]))
    assert told(path) is True
