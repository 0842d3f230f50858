"""Opening, losing and finding a stream again, and its clock, on a library that a test plays."""

import time
from types import SimpleNamespace

import numpy as np
import pytest

from fesloop.errors import InputError
from fesloop.streams.live import source as source_module
from fesloop.streams.live.source import LslSource, StreamLost, Wanted, find, monotonic_offset_ns

AHEAD_S = 5.0
"""By how much LSL's clock is ahead of Python's here."""


class Nothing:
    """A description that has nothing in it."""

    def child(self, name):
        return self

    def empty(self):
        return True


class Info:
    """What is told of a stream."""

    def __init__(self, name="imus", channels=2, text=False):
        self._name, self._channels, self.text = name, channels, text

    def name(self):
        return self._name

    type = source_id = name

    def channel_count(self):
        return self._channels

    def channel_format(self):
        return 3 if self.text else 1

    def nominal_srate(self):
        return 100.0

    def desc(self):
        return Nothing()


class Library:
    """In place of pylsl: what is found, what is pulled, what the correction is; all for a test to set."""

    cf_string = 3

    def __init__(self):
        self.found, self.pulls, self.correction_s, self.opens = [Info()], [], 0.0, True
        self.there, self.passed_s = [Info("elsewhere", 7)], 0.0

    def local_clock(self):
        return time.monotonic() + AHEAD_S

    def resolve_bypred(self, predicate, minimum, timeout):
        self.predicate = predicate
        self.passed_s += 0.0 if self.found else timeout
        return list(self.found)

    def resolve_streams(self, wait_s):
        self.passed_s += wait_s
        return list(self.there)

    def StreamInlet(self, info, **options):  # noqa: N802 (pylsl's name)
        def act():
            if not self.opens:
                raise RuntimeError("timeout")

        def pull(timeout):
            what = self.pulls.pop(0) if self.pulls else (None, None)
            if isinstance(what, Exception):
                raise what
            return what

        return SimpleNamespace(open_stream=lambda timeout: act(), info=lambda timeout: info,
                               time_correction=lambda timeout: self.correction_s, flush=lambda: 0,
                               pull_sample=pull)


@pytest.fixture
def library(monkeypatch):
    made = Library()
    monkeypatch.setattr(source_module, "open_library", lambda network: made)
    return made


def opened(library):
    wanted = Wanted(name="imus", type="IMU")
    return LslSource(wanted, find(wanted))


def test_the_clocks_are_brought_together():
    offset = monotonic_offset_ns(lambda: time.monotonic() + AHEAD_S)
    assert offset == pytest.approx(-AHEAD_S * 1e9, abs=100_000)


def test_a_stamp_is_brought_to_our_clock_with_the_senders_offset(library):
    library.correction_s = -100.0
    stream = opened(library)
    now = time.monotonic()
    library.pulls = [(np.array([1.0, 2.0], dtype=np.float32), now + AHEAD_S + 100.0)]
    values, stamp_ns = stream.pull(0.0)
    assert values.tolist() == [1.0, 2.0]
    assert values.dtype == np.float64
    assert stamp_ns == pytest.approx(now * 1e9, abs=200_000)
    assert stream.pull(0.0) is None
    assert library.predicate == "name='imus' and type='IMU'"


def test_the_offset_is_asked_for_anew_now_and_then(library, monkeypatch):
    stream = opened(library)
    library.correction_s = 7.0
    sample = (np.zeros(2), 50.0)
    library.pulls = [sample, sample, sample]
    before = stream.pull(0.0).stamp_ns
    monkeypatch.setattr(source_module, "_CLOCK_EVERY_NS", 0)
    after = stream.pull(0.0).stamp_ns
    assert after - before == pytest.approx(7e9, abs=200_000)


@pytest.mark.parametrize("stamp", [np.nan, np.inf, -np.inf, 1e300])
def test_a_stamp_that_is_no_time_lies_before_everything(library, stamp):
    stream = opened(library)
    library.pulls = [(np.zeros(2), stamp)]
    assert stream.pull(0.0).stamp_ns == -1


def test_a_loss_lasts_until_the_same_stream_is_open_again(library):
    stream = opened(library)
    library.pulls = [RuntimeError("lost")]
    for _ in range(2):
        with pytest.raises(StreamLost):
            stream.pull(0.0)
    library.found = []
    with pytest.raises(StreamLost, match=r"^$"):
        stream.reopen()
    library.found = [Info(channels=5)]
    for _ in range(2):
        with pytest.raises(StreamLost, match=r"5 channels.*not those of before"):
            stream.reopen()
    library.found = [Info(), Info()]
    with pytest.raises(StreamLost, match=r"'imus'.*, 'imus'"):
        stream.reopen()
    library.found, library.opens = [Info()], False
    with pytest.raises(StreamLost, match="'imus'"):
        stream.reopen()
    library.opens = True
    stream.reopen()
    assert stream.pull(0.0) is None


@pytest.mark.parametrize(("found", "opens", "named"), [
    ([], True, "does not answer within 5 s; allowed: 'elsewhere'"),
    ([Info(), Info()], True, "2 streams fit"), ([Info(text=True)], True, "holds text"),
    ([Info()], False, "is there and does not open")])
def test_what_cannot_be_opened_is_refused(library, found, opens, named):
    library.found, library.opens = found, opens
    with pytest.raises(InputError, match=named):
        opened(library)


def test_who_waits_is_told_what_for_and_what_there_is_instead(library, capsys):
    """Soon, in one line each time that there is something new, and no longer than was said."""
    library.found, library.there, said = [], [Info("imus")], []

    def say(text):
        said.append((library.passed_s, text))
        if len(said) == 1:
            library.there.append(Info("hands"))

    with pytest.raises(InputError, match=r"'imuz': does not answer within 20 s; allowed: 'imus'.*'hands'"):
        find(Wanted(name="imuz", timeout_s=20.0), say)
    assert library.passed_s == pytest.approx(20.0, abs=1.5)
    assert [passed_s for passed_s, _ in said] == [1.5, 3.0]
    assert "stream name 'imuz': does not answer yet; waiting for it 18 s more" in said[0][1]
    assert "did you mean 'imus'?" in said[0][1]
    assert "'hands'" in said[1][1]
    assert all("\n" not in text for _, text in said)

    library.there = []
    with pytest.raises(InputError, match="nor does any other"):
        find(Wanted(name="imuz"))
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("fesloop: stream name 'imuz': does not answer yet")
    assert printed.err.count("\n") == 1


def test_a_stream_that_comes_while_it_is_waited_for_is_found(library):
    late, library.found = library.found, []
    assert find(Wanted(name="imus"), lambda text: library.found.extend(late)) is late[0]


def test_nobody_is_told_of_a_stream_that_answers(library, capsys):
    find(Wanted(name="imus"))
    assert capsys.readouterr().err == ""
