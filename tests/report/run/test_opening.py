"""Of files that are cut short, foreign or newer, what can be read is shown, and what not is said."""

import shutil
from contextlib import suppress
from types import SimpleNamespace

import h5py
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.show.report.run import page as page_module
from fesloop.show.report.run.opening import readable
from fesloop.show.report.run.page import run_page


def cut(path, target, size):
    target.write_bytes(path.read_bytes()[:size])
    return target


@pytest.mark.parametrize("share", [0.1, 0.35, 0.6, 0.9, 0.999])
def test_of_a_file_that_was_cut_short_the_rest_is_shown(learning, tmp_path, share):
    path = cut(learning, tmp_path / "cut.h5", int(share * learning.stat().st_size))
    with readable(path) as (recording, notices):
        page = run_page(recording, notices)
    assert page.sentence.startswith("The file is damaged; in its readable part: ")
    assert page.sections[0].key == "lacking"
    told = [part.text for part in page.sections[0].parts]
    assert any("cut short" in text for text in told)
    assert any("rows are left" in text for text in told)
    assert page.title.endswith("(cut.h5)")


@pytest.mark.slow
@settings(deadline=None, max_examples=25)
@given(st.floats(0.0, 1.0))
def test_no_cut_gives_anything_but_what_is_left_or_a_clear_refusal(learning, tmp_path_factory, share):
    path = cut(learning, tmp_path_factory.mktemp("cut") / "cut.h5", int(share * learning.stat().st_size))
    with suppress(InputError), readable(path) as (recording, notices):
        assert recording.trials <= 3
        assert notices or share == 1.0


def test_another_version_is_told_of(learning, tmp_path):
    path = tmp_path / "newer.h5"
    shutil.copy(learning, path)
    with h5py.File(path, "r+") as file:
        file.attrs["format"] = "fesloop recording 2"
    with readable(path) as (recording, notices):
        assert "'fesloop recording 2'" in notices[0]
        assert "result" in [section.key for section in run_page(recording, notices).sections]


def test_a_sound_file_has_nothing_to_tell_of(learning):
    with readable(learning) as (_, notices):
        assert not notices


def test_of_a_foreign_file_the_contents_are_listed(tmp_path, capsys):
    path = tmp_path / "foreign.h5"
    with h5py.File(path, "w") as file:
        file["weather/rain"] = [1, 2, 3]
    assert main(["report", str(path)]) == 0
    out, err = capsys.readouterr()
    assert "no recording of fesloop" in err
    assert "weather/rain" in (tmp_path / "foreign.html").read_text()
    assert out.strip() == str(tmp_path / "foreign.html")


@pytest.mark.parametrize("content", [b"", b"hello\n", b"\x89HDF\r\n\x1a\n\x03" + bytes(200)])
def test_what_is_no_such_file_is_refused_in_one_line(tmp_path, capsys, content):
    path = tmp_path / "text.h5"
    path.write_bytes(content)
    assert main(["report", str(path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "text.html").exists()


@pytest.mark.parametrize(("best", "sentence", "said"), [
    (1, "It fell (the least, 3 deg, in trial 1).", ""), (2, "It fell to 3 deg in the last.", ""),
    (1, "It fell (the least, 3 deg, in trial 12).", " Trial 1, the best, is shown first."),
    (0, "It was held in 1 of 3 trials.", " Trial 0, the best, is shown first.")])
def test_the_headline_names_the_trial_that_the_page_opens_with(best, sentence, said, monkeypatch):
    monkeypatch.setattr(page_module, "sentence_of", lambda known: sentence)
    assert page_module._headline(SimpleNamespace(begun=3, best=best, last=2)) == sentence + said
