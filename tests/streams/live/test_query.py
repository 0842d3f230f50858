"""Looking for a stream: what is told while it does not answer, on a library that a test plays."""

import pytest
from lsl_parts import Info, Library

from fesloop.errors import InputError
from fesloop.streams.live.inlet import LslInlet
from fesloop.streams.live.query import StreamQuery, find


@pytest.fixture
def library(monkeypatch):
    made = Library()
    monkeypatch.setattr("fesloop.streams.live.query.open_library", lambda network: made)
    return made


@pytest.mark.parametrize(("found", "named"), [
    ([], "does not answer within 5 s; allowed: 'elsewhere'"), ([Info(), Info()], "2 streams fit.*source_id")])
def test_what_is_not_one_stream_is_refused(library, found, named):
    library.found = found
    with pytest.raises(InputError, match=named):
        find(StreamQuery(name="imus"))


def test_who_waits_is_told_what_for_and_what_there_is_instead(library, capsys):
    """Soon, in one line each time that there is something new, and no longer than was said."""
    library.found, library.there, said = [], [Info("imus")], []

    def say(text):
        said.append((library.passed_s, text))
        if len(said) == 1:
            library.there.append(Info("hands"))

    with pytest.raises(InputError, match=r"'imuz': does not answer within 20 s; allowed: 'imus'.*'hands'"):
        find(StreamQuery(name="imuz", timeout_s=20.0), say)
    assert library.passed_s == pytest.approx(20.0, abs=1.5)
    assert [passed_s for passed_s, _ in said] == [1.5, 3.0]
    assert "stream name 'imuz': does not answer yet; waiting for it 18 s more" in said[0][1]
    assert "did you mean 'imus'?" in said[0][1]
    assert "'hands'" in said[1][1]
    assert all("\n" not in text for _, text in said)

    library.there = []
    with pytest.raises(InputError, match="nor does any other"):
        find(StreamQuery(name="imuz"))
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("fesloop: stream name 'imuz': does not answer yet")
    assert printed.err.count("\n") == 1


def test_a_stream_that_comes_during_the_search_is_found(library):
    late, library.found = library.found, []
    assert find(StreamQuery(name="imus"), lambda text: library.found.extend(late)) is late[0]


def test_a_stream_that_answers_between_two_looks_is_found_and_not_named_as_another(library, capsys):
    library.found, library.there = [], [Info("others"), Info("imus")]
    assert find(StreamQuery(name="imus")) is library.there[1]
    LslInlet(stream="imus", sensors=1).seek()
    assert capsys.readouterr().err == ""
    library.there.append(Info("imus"))
    with pytest.raises(InputError, match="2 streams fit"):
        find(StreamQuery(name="imus"))


def test_a_stream_that_answers_is_not_announced(library, capsys):
    find(StreamQuery(name="imus"))
    assert capsys.readouterr().err == ""


def test_before_a_rehearsal_a_missing_stream_is_announced(library, capsys):
    block = LslInlet(stream="imuz", sensors=1, timeout_s=60.0)
    block.seek()
    assert capsys.readouterr().err == ""
    library.found, library.there = [], [Info("imus", 7)]
    block.seek()
    assert library.passed_s == 1.5
    assert capsys.readouterr().err == (
        "fesloop: stream name 'imuz': does not answer yet; the run waits up to 60 s for it when the loop is "
        "ready; allowed: 'imus' (type 'imus', source_id 'imus', 7 channels, 100 Hz); did you mean 'imus'?\n")
