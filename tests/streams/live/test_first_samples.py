"""What a stream's first samples give away."""

import time

import numpy as np
import pytest
from streams_live_parts import PlannedSource, pulled

from fesloop.errors import InputError
from fesloop.loop.clock import RateClock
from fesloop.streams.live.description import Picked
from fesloop.streams.live.inlet import check_first_samples, check_rate
from fesloop.streams.live.source import StreamLost

PICKED = {kind: Picked(np.arange(3 * k, 3 * k + 3).reshape(1, 3), np.ones((1, 3)))
          for k, kind in enumerate(("gyr", "acc", "mag"))}
SOUND = (0.1, 0.0, 0.2, 0.0, 0.0, 9.8, 2e-5, 0.0, -4e-5)


def sent(*values, late_ns=0):
    return PlannedSource([pulled(time.monotonic_ns() - late_ns, *values)] * 10)


def test_sound_samples_pass():
    check_first_samples(sent(*SOUND), PICKED, "stream", by_sender=True)
    check_first_samples(sent(*SOUND[:6], *(np.nan,) * 3), PICKED, "stream", by_sender=True)


@pytest.mark.parametrize(("values", "named"), [
    ((100.0, *SOUND[1:]), "gyr: reaches 100"),
    ((*SOUND[:5], 1.0, *SOUND[6:]), "acc: has a median length of 1;"),
    ((*SOUND[:6], 20.0, 0.0, -40.0), "mag: has a median length"),
])
def test_numbers_that_cannot_be_in_their_unit_are_refused(values, named):
    with pytest.raises(InputError, match=named):
        check_first_samples(sent(*values), PICKED, "stream", by_sender=True)


@pytest.mark.parametrize(("late_s", "told"), [(3.0, "3 s old"), (-3.0, "3 s ahead of this machine")])
def test_another_clock_is_refused_where_the_senders_counts(late_s, told):
    late_ns = round(late_s * 1e9)
    with pytest.raises(InputError, match=told):
        check_first_samples(sent(*SOUND, late_ns=late_ns), PICKED, "stream", by_sender=True)
    check_first_samples(sent(*SOUND, late_ns=late_ns), PICKED, "stream", by_sender=False)


def test_a_lost_stream_is_refused():
    with pytest.raises(InputError, match="was lost as it was opened"):
        check_first_samples(PlannedSource([StreamLost()]), PICKED, "stream", by_sender=True)


@pytest.mark.parametrize("stated", [0.0, 100.0, 100.9])
def test_a_rate_that_agrees_or_is_not_stated_passes(stated):
    check_rate(stated, RateClock.from_rate(100), "stream")


def test_another_rate_is_refused():
    with pytest.raises(InputError, match='states a rate of 60 Hz; allowed: nominal_rate = 100; say nominal'):
        check_rate(60.0, RateClock.from_rate(100), "stream")
