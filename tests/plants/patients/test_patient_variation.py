"""Members of a cohort and days: possible, independent of each other, distributed as is stated."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kstest, truncnorm

from fesloop.errors import InputError, InputErrors
from fesloop.hand.movements import MUSCLES
from plants.electrodes import Electrodes
from plants.muscles import Muscles
from plants.patients.files import from_table, load, names
from plants.patients.patient import GREATEST_NUMBER, MOST_SD, Draws, Patient
from plants.patients.sections import (
    LIMITS,
    OF_SINGLE_MUSCLES,
    Anthropometry,
    CohortSpread,
    DaySpread,
    Fatigue,
    Recruitment,
    Spasticity,
    Strength,
    Tremor,
    Voluntary,
    spread_limits,
)

NUMBERS = st.integers(0, GREATEST_NUMBER)
PRESETS = st.sampled_from([load(name) for name in names()])


def spreads(cls):
    """Any standard deviations that are accepted."""
    limits = spread_limits(tuple(each.name for each in fields(cls)))
    return st.builds(cls, **{key: st.dictionaries(st.sampled_from(MUSCLES), st.floats(low, high), max_size=3)
                             if key in OF_SINGLE_MUSCLES else st.floats(low, high)
                             for key, (low, high) in limits.items()})


@st.composite
def sections(draw, cls, name, keys):
    """Any section with these numbers."""
    return cls(**{key: draw(st.floats(*LIMITS[name][key])) for key in keys})


ANYBODY = st.builds(
    Patient, name=st.just("anybody"), cohort=spreads(CohortSpread), day=spreads(DaySpread),
    anthropometry=sections(Anthropometry, "anthropometry", ("hand_mm", "forearm_radius_mm")),
    strength=sections(Strength, "strength", ("overall",)),
    recruitment=sections(Recruitment, "recruitment", ("threshold", "spread")),
    fatigue=sections(Fatigue, "fatigue", ("endurance",)),
    voluntary=sections(Voluntary, "voluntary", ("limit",)),
    spasticity=st.builds(Spasticity, gain_s=st.floats(0.01, 20.0)),
    tremor=sections(Tremor, "tremor", ("frequency_hz",)))


@given(ANYBODY, NUMBERS, NUMBERS, NUMBERS)
@settings(deadline=None)
def test_whoever_is_drawn_is_possible(patient, cohort, number, day):
    """Being made, each section checks its numbers; the blocks check theirs."""
    drawn = patient.member(cohort=cohort, number=number).on_day(day)
    assert from_table(drawn.table()) == drawn
    assert Electrodes(**drawn.electrodes()).elements == 59
    Muscles(**drawn.muscles())


@given(PRESETS, NUMBERS, NUMBERS, NUMBERS)
def test_the_same_choice_is_the_same_patient(preset, cohort, number, day):
    one, other = (preset.member(cohort=cohort, number=number).on_day(day) for _ in range(2))
    assert one == other
    assert one.electrodes() == other.electrodes()


@given(PRESETS, NUMBERS, NUMBERS, NUMBERS)
def test_members_cohorts_and_days_differ(patient, cohort, number, day):
    member = patient.member(cohort=cohort, number=number)
    others = [patient.member(cohort=cohort, number=(number + 1) % GREATEST_NUMBER),
              patient.member(cohort=(cohort + 1) % GREATEST_NUMBER, number=number)]
    for other in others:
        assert other.anthropometry != member.anthropometry
        assert other.recruitment.axon_seed != member.recruitment.axon_seed
        assert other.on_day(day).placement != member.on_day(day).placement
    assert member.on_day(day).placement != member.on_day((day + 1) % GREATEST_NUMBER).placement


def test_a_day_leaves_the_person_as_they_are():
    member = load("sci_c6").member(cohort=1, number=1)
    for day in range(5):
        today = member.on_day(day)
        assert today.anthropometry == member.anthropometry
        assert today.recruitment.axon_seed == member.recruitment.axon_seed
        assert today.passive == member.passive
        assert today.voluntary == member.voluntary


def test_one_spread_changes_nothing_that_another_draws():
    """A quantity draws from a stream of its own."""
    patient = load("able_bodied")
    wider = replace(patient, cohort=replace(patient.cohort, strength=0.0, muscle_strength=0.5))
    one, other = (each.member(cohort=3, number=4) for each in (patient, wider))
    assert one.strength != other.strength
    assert one.anthropometry == other.anthropometry
    assert one.recruitment == other.recruitment


def test_no_spread_draws_the_preset_itself():
    patient = Patient(name="anna", cohort=CohortSpread(), day=DaySpread())
    member = patient.member(cohort=1, number=2)
    assert replace(member, name="anna", cohort=CohortSpread(), recruitment=patient.recruitment) == patient
    today = patient.on_day(3)
    assert replace(today, name="anna", cohort=CohortSpread(), day=DaySpread(),
                   placement=patient.placement) == patient


def test_members_are_distributed_as_the_preset_states():
    """A truncated normal hand, a truncated lognormal strength, of 400 members (Kolmogorov-Smirnov)."""
    preset = load("able_bodied")
    members = [preset.member(cohort=5, number=number) for number in range(400)]
    sizes = [(each.anthropometry.hand_mm - 190.0) / preset.cohort.hand_mm for each in members]
    strengths = [math.log(each.strength.overall) / preset.cohort.strength for each in members]
    expected = truncnorm(-MOST_SD, MOST_SD).cdf
    for drawn in (sizes, strengths):
        assert kstest(drawn, expected).pvalue > 0.01
    assert abs(np.corrcoef(sizes, strengths)[0, 1]) < 0.15


def test_muscles_of_members_are_as_late_and_as_quick_as_the_preset_states():
    """Each muscle of its own around a person of its own (Kolmogorov-Smirnov), as its block takes it."""
    preset = load("able_bodied")
    members = [preset.member(cohort=5, number=number).muscles() for number in range(400)]
    expected = truncnorm(-MOST_SD, MOST_SD).cdf
    late = [(each["delays_ms"]["FPL"] - each["delay_ms"]) / preset.cohort.muscle_delay_ms for each in members]
    quick = [math.log(each["hammerstein"].activations_rad_s["EDC3"] / each["natural_rad_s"])
             / preset.cohort.muscle_natural for each in members]
    assert kstest(late, expected).pvalue > 0.01
    assert kstest(quick, expected).pvalue > 0.01
    assert abs(np.corrcoef(late, [each["delays_ms"]["FCR"] for each in members])[0, 1]) < 0.15
    assert all(each["naturals_rad_s"] == each["hammerstein"].activations_rad_s for each in members)
    assert min(Muscles(**from_table({"name": "anna", "muscle": {
        "delay_ms": 10.0, "delays_ms": {"FPL": -20.0}}}).muscles()).delays_ms.values()) == 5.0


def test_muscles_of_members_have_the_chronaxies_that_the_preset_states():
    preset = load("able_bodied")
    blocks = [preset.member(cohort=1, number=number).electrodes() for number in range(100)]
    logs = np.log([block["chronaxie"] for block in blocks])
    assert logs.std() == pytest.approx(preset.cohort.muscle_chronaxie, rel=0.05)
    assert {block["chronaxie_us"] for block in blocks} == {122.0}
    assert set(preset.electrodes()["chronaxie"]) == {1.0}


def test_single_muscles_vary_by_spreads_of_their_own():
    """Where one muscle's spread is stated, it varies by that, and all others as before."""
    preset = load("able_bodied")
    own = replace(preset, cohort=replace(
        preset.cohort, strengths={"FCR": 0.05}, thresholds={"FCR": 0.0}, delays_ms={"FCR": 2.0},
        naturals={"FCR": 0.1}))
    members = [[each.member(cohort=5, number=number) for each in (preset, own)] for number in range(20)]
    for usual, mine in members:
        assert mine.strength.overall == usual.strength.overall
        for before, after, sds in (
                (usual.strength.muscles, mine.strength.muscles, (preset.cohort.muscle_strength, 0.05)),
                (usual.recruitment.thresholds, mine.recruitment.thresholds, (1.0, 0.0)),
                (usual.muscle.naturals, mine.muscle.naturals, (preset.cohort.muscle_natural, 0.1))):
            assert {k: v for k, v in before.items() if k != "FCR"} == {
                k: v for k, v in after.items() if k != "FCR"}
            assert math.log(after["FCR"]) == pytest.approx(math.log(before["FCR"]) * sds[1] / sds[0])
        assert mine.muscle.delays_ms["FCR"] == pytest.approx(
            usual.muscle.delays_ms["FCR"] * 2.0 / preset.cohort.muscle_delay_ms)
        assert mine.muscle.delays_ms["PL"] == usual.muscle.delays_ms["PL"]
    with pytest.raises(InputErrors, match=r"cohort.strengths: no muscle is named 'FRC'|cohort.strengths.FRC"):
        CohortSpread(strengths={"FRC": 0.1})


def test_days_shift_the_arrays_as_the_preset_states():
    member = load("stroke_mild").member(cohort=5, number=0)
    days = [member.on_day(day).placement for day in range(400)]
    expected = truncnorm(-MOST_SD, MOST_SD).cdf
    assert kstest([each.along_mm / member.day.along_mm for each in days], expected).pvalue > 0.01
    assert kstest([each.around_deg / member.day.around_deg for each in days], expected).pvalue > 0.01


@given(st.floats(-5.0, 5.0), st.floats(0.0, 100.0), NUMBERS)
def test_draws_stay_within_limits(middle, sd, number):
    draws = Draws(0, "draws", number)
    assert -5.0 <= draws.near("near", middle, sd, (-5.0, 5.0)) <= 5.0
    positive = 5.0 + middle + 0.1
    assert 0.1 <= draws.scaled("scaled", positive, sd, (0.1, 10.1)) <= 10.1 + 1e-9


def test_who_is_drawn_is_not_drawn_again():
    member = load("sci_c6").member(cohort=1, number=2)
    with pytest.raises(InputError, match="no \\[cohort\\]"):
        member.member(cohort=1, number=2)
    with pytest.raises(InputError, match="no \\[day\\]"):
        member.on_day(1).on_day(1)


@pytest.mark.parametrize(("call", "where"), [
    (lambda p: p.member(cohort=-1, number=0), "cohort"), (lambda p: p.member(cohort=0, number=-1), "member"),
    (lambda p: p.on_day(2**31), "day")])
def test_numbers_beyond_what_is_counted_are_refused(call, where):
    with pytest.raises(InputError, match=f"^{where}: "):
        call(load("sci_c6"))
