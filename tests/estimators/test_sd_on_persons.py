"""Sds of trackers against their errors on persons with wrong lengths, tilted joints and turned sensors."""

import numpy as np
import pytest
from sd_parts import KINDS, by_kind, person, random_errors, trackers

PERSONS = range(1, 11)
NAMES = tuple(trackers(person(1).measured_hand))


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_sds_are_those_of_the_errors(name):
    found = by_kind(name, PERSONS)
    for kind in KINDS:
        share, sd, rms = found[kind]
        print(f"{name}, {kind}: {100 * share:.1f} % within 2 sd, sd {sd:.1f}, rms {rms:.1f}")
        assert share >= 0.9, kind
        assert sd <= 2.0 * rms, kind
    shares = [found[kind][0] for kind in ("angles", "tips")]
    assert np.max(shares) <= 0.995


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_random_sds_are_those_of_what_changes(name):
    share, sd, rms = random_errors(name, PERSONS)
    print(f"{name}: {100 * share:.1f} % within 2 sd, sd {sd:.1f}, rms {rms:.1f}")
    assert share >= 0.9
    assert sd <= 2.0 * rms
