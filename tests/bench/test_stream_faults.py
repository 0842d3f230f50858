"""Faults of a stream in a session with a device, a few of them (some 25 s)."""

import math
import random
from importlib.util import find_spec
from itertools import pairwise

import numpy as np
import pytest

from fesloop.apps.bench.stream_faults import FAULTS, Given, _planned, _posture, run, zero_within_ms
from fesloop.streams.live.sender import FAULTS as KINDS

pytestmark = pytest.mark.realtime

MS = 1_000_000


def log(*stamps_and_states):
    return [Given(stamp * MS, on) for stamp, on in stamps_and_states]


@pytest.mark.parametrize(("rows", "zero_ms"), [
    (log((0, True), (90, True), (110, True), (130, False)), 30.0),
    (log((0, True), (110, False), (120, True), (150, False), (900, False)), 50.0),
    (log((0, True), (110, True), (120, True)), math.inf),
    (log((0, True), (99, False)), None),
    (log((300, True)), None),
    (log((0, True), (105, False), (2000, True)), 5.0),
])
def test_the_last_current_within_a_fault_counts(rows, zero_ms):
    assert zero_within_ms(rows, 100 * MS, 1000 * MS) == zero_ms


def test_faults_do_not_overlap_and_are_of_the_sender():
    faults = _planned(list(FAULTS) * 3, random.Random(1))
    assert set(FAULTS) == set(KINDS)
    for before, after in pairwise(faults):
        assert after.start_s >= before.start_s + before.length_s + 3.0


@pytest.mark.skipif(find_spec("pylsl") is None, reason="pylsl is not installed")
def test_each_jump_of_the_posture_is_one():
    played = _posture()
    faults = _planned(["jump"] * 200, random.Random(1))
    for fault in faults:
        before = played.rows[int(fault.start_s * played.rate_hz) % len(played.rows)]
        after = played.rows[int((fault.start_s + fault.value) * played.rate_hz) % len(played.rows)]
        assert np.degrees(np.abs(after - before).max()) > 30.0


@pytest.mark.slow
def test_current_ends_and_the_cause_is_named():
    result = run(kinds=("stop", "nan", "rate"), moments=1)
    assert list(result) == ["bench", "rows", "not_stimulated"]
    assert result["rows"]
    for row in result["rows"]:
        assert math.isfinite(row["us_worst"])
        assert row["cause_named"] == f"{row['count']} of {row['count']}"
