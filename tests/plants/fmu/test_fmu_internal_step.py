"""Communication steps must be whole multiples of an FMU's internal step, at any rate."""

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError, RunError
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from plants.fmu import Fmu
from plants.fmu.running import RunningFmu
from plants.fmu.trial import (
    InternalStep,
    find_by_finer_steps,
    find_internal_step,
    fits,
    misfit,
    stepped_alike,
)

RATES = st.fractions(min_value=5, max_value=5000, max_denominator=1000)
KINDS = ("fmi2, silent", "fmi2, telling", "fmi3, telling", "fmi3, declared")
ROUNDED_S = 1e-9


@pytest.fixture(scope="module")
def fmus(small2, small3):
    """A plant of each kind whose internal step is the parameter h."""
    made = [Fmu(path=str(fmu)) for fmu in (small2(), small2("TELLS"), small3())]
    return dict(zip(KINDS, (*made, made[-1]), strict=True))


def tried(plant, rate, internal_s, declared_s=0.0):
    """The setup that an FMU of this internal step gets, and the step that is found."""
    clock = RateClock.from_rate(rate)
    description = replace(plant._setup.description, internal_step_s=declared_s)
    setup = replace(plant._setup, description=description, starts=(("h", internal_s),), reports_time=False,
                    period_num=clock.period_num, period_den=clock.period_den)
    if fits(setup.period_s, declared_s):
        setup = stepped_alike(setup, declared_s)
    running = RunningFmu(setup, plant._extracted.folder, "probe")
    try:
        running.step(False)
        found = find_internal_step(setup, running)
        found = found if found.length_s else find_by_finer_steps(setup, plant._extracted.folder)
    finally:
        running.end()
    return setup, found


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(kind=st.sampled_from(KINDS), rate=RATES, part=st.sampled_from([1, 2, 3]), rounded=st.booleans())
def test_a_whole_multiple_of_the_internal_step_fits_at_any_rate(fmus, kind, rate, part, rounded):
    internal_s = float(1 / (rate * part))
    rounded = rounded and kind != KINDS[0]
    if rounded:
        internal_s = round(internal_s, 9)
    assume(kind == KINDS[3] or abs(part * internal_s - float(1 / rate)) < ROUNDED_S)
    setup, (step_s, *_) = tried(fmus[kind], rate, internal_s, internal_s if kind == KINDS[3] else 0.0)
    assert fits(setup.period_s, step_s)
    setup = stepped_alike(setup, step_s)
    assert setup.period_s == pytest.approx(float(1 / rate), abs=part * ROUNDED_S)
    if kind != KINDS[0]:
        running = RunningFmu(setup, fmus[kind]._extracted.folder, "run")
        for tick in range(1, 200):
            running.step(False)
            assert running.reached_s() == pytest.approx(tick * part * internal_s, rel=1e-12)
        running.end()


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(kind=st.sampled_from(KINDS), rate=RATES, longer=st.floats(1e-6, 5.0))
def test_an_internal_step_that_is_longer_is_refused(fmus, kind, rate, longer):
    longer = max(longer, 0.01) if kind == KINDS[0] else longer
    period_s = float(1 / rate)
    internal_s = period_s * (1 + longer)
    assume(internal_s < 0.25 and internal_s - period_s > ROUNDED_S)
    setup, (step_s, *_) = tried(fmus[kind], rate, internal_s, internal_s if kind == KINDS[3] else 0.0)
    assert not fits(setup.period_s, step_s)
    assert step_s == pytest.approx(internal_s, rel=1e-9 if kind != KINDS[0] else 0.05)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(kind=st.sampled_from(KINDS[1:3]), rate=RATES, ratio=st.fractions(1, 6, max_denominator=5))
def test_an_fmu_that_says_what_it_reached_may_not_fall_short(fmus, kind, rate, ratio):
    period_s = float(1 / rate)
    internal_s = float(1 / (rate * ratio))
    setup, found = tried(fmus[kind], rate, internal_s)
    assert fits(setup.period_s, found[0]) == (ratio.denominator == 1)
    if ratio.denominator > 1:
        assert found[0] == pytest.approx(internal_s, rel=1e-6)
        assert "no whole multiple" in str(misfit(period_s, found))


@settings(max_examples=200, deadline=None)
@given(rate=st.fractions(min_value=Fraction(1, 100), max_value=100_000, max_denominator=10**6),
       ratio=st.floats(0.01, 100.0))
def test_a_refusal_shows_two_numbers_and_a_rate_that_fits(rate, ratio):
    period_s = float(1 / rate)
    internal_s = period_s * ratio
    assume(not fits(period_s, internal_s))
    fault = misfit(period_s, InternalStep(internal_s))
    numbers = re.findall(r"([0-9.e+-]+) ms", str(fault))
    assert numbers[0] != numbers[1]
    allowed = re.search(r"([0-9.e+-]+) Hz", str(fault))[1]
    assert fits(RateClock.from_rate(allowed).period_s, internal_s)


@pytest.mark.slow
@pytest.mark.parametrize("declared", ["0.016666667", "0.0166666667", "0.0083333334"])
def test_an_fmu_for_60_hz_runs_at_60_hz(small3, declared):
    fmu = small3(f"INTERNAL_STEP_S={declared}", extra=f'fixedInternalStepSize="{declared}"')
    plant = Fmu(path=str(fmu), step_rate="60")
    state = plant.init(Context("plant"))
    seen = {0.0}
    for _ in range(100):
        plant.advance(state, [np.ones(3)], 0, 0)
        seen.add(plant.read(state, [])[0][0])
    assert len(seen) == 101
    plant.close(state)


def test_one_and_a_half_steps_are_stale(small2):
    with pytest.raises(InputError, match=r"communication step, 16\.6667 ms, is shorter .* step, about 25 ms"):
        Fmu(path=str(small2("INTERNAL_STEP_S=0.025")), step_rate="60")


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(rate=st.sampled_from(["1000", "200", "60", "2000/7"]), longer=st.floats(1.02, 8.0), neat=st.booleans())
def test_a_silent_fmu_at_the_rate_that_its_refusal_names_is_not_stale(fmus, rate, longer, neat):
    internal_s = longer / float(Fraction(rate))
    internal_s = float(f"{internal_s:.2g}") if neat else internal_s
    plant = fmus[KINDS[0]]
    setup, (step_s, outputs, *_) = tried(plant, Fraction(rate), internal_s)
    assume(not fits(setup.period_s, step_s))
    allowed = re.search(r"about ([0-9.]+) Hz", str(misfit(setup.period_s, InternalStep(step_s, outputs))))[1]
    clock = RateClock.from_rate(allowed)
    assert internal_s - 1e-9 <= clock.period_s < 1.01 * internal_s
    obeying = replace(setup, period_num=clock.period_num, period_den=clock.period_den, own_step_s=0.0)
    running = RunningFmu(obeying, plant._extracted.folder, "obeying")
    running.inputs.values[:] = 1.0
    try:
        before = 0.0
        for _ in range(int(min(200, 2.0 / internal_s))):
            running.step(True)
            assert running.outputs.values[0] > before
            before = running.outputs.values[0]
    finally:
        running.end()


@pytest.mark.slow
@pytest.mark.parametrize("internal", ["0.005", "0.02", "0.0017", "0.0125"])
def test_the_rate_for_a_silent_fmu_of_a_neat_internal_step_is_its_own(small2, internal):
    fmu = str(small2(f"INTERNAL_STEP_S={internal}"))
    with pytest.raises(InputError, match=r"about [0-9.]+ ms") as caught:
        Fmu(path=fmu)
    allowed = re.search(r"at most about ([0-9.]+) Hz", str(caught.value))[1]
    assert float(allowed) == pytest.approx(1.0 / float(internal), rel=1e-9)
    Fmu(path=fmu, step_rate=allowed)


@settings(max_examples=40, deadline=None)
@given(rate=RATES, ratio=st.fractions(Fraction(1, 7), 6, max_denominator=7))
def test_a_declared_step_fits_a_whole_number_of_times_or_is_refused(fmus, rate, ratio):
    """The FMU itself is exact at any step: what it declares is believed."""
    internal_s = float(1 / (rate * ratio))
    setup, found = tried(fmus[KINDS[3]], rate, 0.0, internal_s)
    assert fits(setup.period_s, found.length_s) == (ratio.denominator == 1)
    if ratio.denominator > 1:
        assert found.length_s == pytest.approx(internal_s, rel=1e-12)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(("when", "part"), [("0.05", 0.5), ("0.05", 0.0), ("-1", 0.5)])
def test_an_ok_from_before_the_end_of_a_step_ends_the_run(small2, small3, version, when, part):
    fall_short = f"LAG=(t>{when}?{1 - part}*h:0)"
    fmu = small2(fall_short, "TELLS") if version == 2 else small3(fall_short)
    plant = Fmu(path=str(fmu), step_rate="100")
    state = plant.init(Context("plant"))
    steps = 0
    words = r"plant: the FMU returned OK at [0-9.]+ s, .* from the step to"
    with pytest.raises(RunError, match=words) as caught:  # noqa: PT012 - which step it is counts
        for _ in range(20):
            plant.advance(state, [np.ones(3) if version == 3 else 1.0], 0, 0)
            steps += 1
    plant.close(state)
    assert steps in ((0,) if when == "-1" else (5, 6))
    said = [float(number) for number in re.findall(r"([0-9.]+) s\b", str(caught.value))]
    assert said == pytest.approx([0.01 * (steps + part), 0.01 * (steps + 1)])


def test_an_fmu_that_leaves_its_last_successful_time_alone_runs(small2):
    plant = Fmu(path=str(small2("LAG=t+h", "TELLS")))
    state = plant.init(Context("plant"))
    for _ in range(5):
        plant.advance(state, [1.0], 0, 0)
    assert plant.read(state, [])[0] == pytest.approx(1.0 - np.exp(-0.05))
    plant.close(state)
