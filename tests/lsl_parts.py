"""In place of pylsl: streams that a test makes up."""

import time
from types import SimpleNamespace

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
