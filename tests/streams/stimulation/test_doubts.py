"""Doubts about recordings of stimulated muscle: what is wrong is named, and what is usual is not."""

from dataclasses import replace

import numpy as np
import pytest

from fesloop.streams.stimulation import open_stimulation
from fesloop.streams.stimulation.summary import doubts_about


@pytest.fixture
def person(recordings):
    """A person without doubts."""
    return open_stimulation(recordings / "fes_exo" / "S9006.npz")


def changed(person, **changes):
    """The person with other values of their trials."""
    return replace(person, steady=replace(person.steady, **changes))


def test_a_published_person_is_not_doubted(person):
    assert doubts_about(person) == {}


def test_a_muscle_that_identification_refuses_is_named_with_those_that_it_takes(person):
    told = doubts_about(replace(person, muscles=("BIC", *person.muscles[1:])))
    assert list(told) == ["unknown_muscles"]
    assert "refuses: BIC; it knows biceps, triceps, " in told["unknown_muscles"]


def test_a_torque_far_from_its_repeats_is_named(person):
    torque = person.steady.device_torque_nm.copy()
    row = int(np.flatnonzero(person.steady.muscle == 0)[5])
    torque[row, 0] = 30.0
    told = doubts_about(changed(person, device_torque_nm=torque))
    assert "1 trials whose torque is far" in told["outliers"]
    assert "elbow_flexion for biceps" in told["outliers"]


def test_torque_within_friction_is_named(person):
    told = doubts_about(replace(person, friction_nm=np.array([0.3, 0.01, 5.0, 0.02])))
    assert list(told) == ["within_friction"]
    assert "wrist_flexion" in told["within_friction"]


def test_pulses_that_differ_are_named(person):
    current, width = person.steady.current_a.copy(), person.steady.pulse_width_s.copy()
    row = int(np.flatnonzero(person.steady.muscle == 0)[5])
    current[row] *= 0.1
    assert "biceps" in doubts_about(changed(person, current_a=current))["various_pulses"]
    told = doubts_about(changed(person, pulse_width_s=10.0 * width))
    assert list(told) == ["other_widths"]
    assert "biceps" in told["other_widths"]
