"""What the command line prints: tables, and a progress bar that moves."""

import io
import time

from fesloop.apps.cli import output


class Terminal(io.StringIO):
    """A terminal that remembers what was written to it."""

    def isatty(self):
        return True


def standing_for_stderr(stream, monkeypatch):
    """The stream in the place of standard error; in the test itself, as pytest puts its own back before."""
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    return stream


def wait_for(text, terminal):
    end = time.monotonic() + 120.0
    while text not in terminal.getvalue():
        assert time.monotonic() < end, f"{text!r} was never shown in {terminal.getvalue()!r}"
        time.sleep(0.01)


def test_a_bar_comes_up_before_anything_was_told_and_then_moves(monkeypatch):
    terminal = standing_for_stderr(Terminal(), monkeypatch)
    monkeypatch.setattr(output, "_QUIET_S", 0.01)
    with output.progress_bar("slow work") as bar:
        wait_for("slow work", terminal)
        for percent in (17, 64):
            bar(percent / 100)
            wait_for(f"{percent} %", terminal)


def test_short_work_shows_no_bar(monkeypatch):
    terminal = standing_for_stderr(Terminal(), monkeypatch)
    with output.progress_bar("quick work") as bar:
        bar(0.5)
    assert terminal.getvalue() == ""


def test_a_bar_is_no_part_of_a_log_file(monkeypatch):
    log = standing_for_stderr(io.StringIO(), monkeypatch)
    monkeypatch.setattr(output, "_QUIET_S", 0.0)
    with output.progress_bar("slow work") as bar:
        time.sleep(0.05)
        bar(0.5)
    assert log.getvalue() == ""
