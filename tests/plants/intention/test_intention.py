"""The person who tries to move: onsets, efforts and EMG against their equations."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.signal import welch

from fesloop.errors import InputError
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.signals import NEVER, Sample
from plants.intention.block import Intention
from plants.intention.emg import EmgElectrode
from plants.intention.script import ACTIONS, Attempt

ECRL = (EmgElectrode(muscle="ECRL"),)
ABLE = Attempt(at_s=0.1, duration_s=0.4, muscles=("ECRL",))
NOISELESS = {"jitter_s": 0.0, "noise": 0.0, "reaction_s": 0.2, "rise_s": 0.1}


def run(person, seconds, rate="1000", seed=1, trial=0, pulses=None):
    """Instants, s, and outputs by port of a person; `pulses` gives (elements, 3) by tick, or None."""
    clock, tick = RateClock.from_rate(rate), Tick()
    state = person.init(Context("person", seed, trial, clock))
    names, rows, times = [port.name for port in person.outputs], [], []
    heard = Sample(np.zeros((2, 3)), NEVER, NEVER, NEVER)
    while clock.tick(len(rows)) < seconds * 1e9:
        tick.index, tick.time_ns = len(rows), clock.tick(len(rows))
        if pulses is not None and (pulse := pulses(tick.index)) is not None:
            heard = Sample(pulse, tick.time_ns, tick.time_ns, tick.time_ns)
        rows.append(person.step(state, (heard,) if person.inputs else (), tick))
        times.append(tick.time_ns / 1e9)
    return np.array(times), {name: np.array([row[k] for row in rows]) for k, name in enumerate(names)}


@given(at_s=st.floats(0.0, 0.5), duration_s=st.floats(0.05, 0.5), strength=st.floats(0.05, 1.0),
       limit=st.floats(0.0, 1.0), rise_s=st.floats(0.02, 0.3))
@settings(max_examples=25, deadline=None)
def test_effort_without_noise_is_a_trapezoid_below_what_the_person_can_do(at_s, duration_s, strength, limit,
                                                                         rise_s):
    person = Intention(attempts=(Attempt(at_s=at_s, duration_s=duration_s, strength=strength,
                                         action="extend_wrist"),),
                       voluntary_limits={"ECRL": limit}, **NOISELESS | {"rise_s": rise_s})
    times, out = run(person, 1.5, "200")
    onset = round(at_s, 9) + 0.2
    share = np.interp(times, [onset, onset + rise_s, onset + duration_s, onset + duration_s + rise_s],
                      [0.0, 1.0, 1.0, 0.0]) if duration_s >= rise_s else None
    found = out["voluntary"][:, muscle("ECRL")]
    assert (found <= strength * limit + 1e-12).all()
    if share is not None:
        np.testing.assert_allclose(found, strength * limit * share, atol=1e-6)
    idle = [muscle(name) for name in MUSCLES if name not in ACTIONS["extend_wrist"]]
    assert not out["voluntary"][:, idle].any()


def test_an_attempt_is_under_way_from_the_tick_of_its_onset_on():
    times, out = run(Intention(attempts=(ABLE,), **NOISELESS), 1.0)
    under_way = times[out["attempt"] > 0.0]
    assert (under_way[0], under_way[-1]) == (0.3, 0.799)


def test_trials_and_seeds_differ_and_repeat():
    person = Intention(attempts=(ABLE,), emg=ECRL)
    runs = {key: run(person, 0.6, seed=key[0], trial=key[1])[1] for key in ((1, 0), (1, 1), (2, 0))}
    again = run(person, 0.6)[1]
    for name, values in again.items():
        assert values.tobytes() == runs[1, 0][name].tobytes()
        assert values.tobytes() != runs[1, 1][name].tobytes()
        assert values.tobytes() != runs[2, 0][name].tobytes()


def test_reaction_times_have_the_stated_mean_and_scatter():
    person = Intention(attempts=(ABLE,), reaction_s=0.2, jitter_s=0.03)
    onsets = [person.init(Context("person", 1, trial, RateClock.from_rate("1000"))).course.onsets_ns[0] / 1e9
              for trial in range(1000)]
    assert np.mean(onsets) == pytest.approx(0.3, abs=4 * 0.03 / math.sqrt(1000))
    assert np.std(onsets) == pytest.approx(0.03, rel=0.1)
    early = Intention(attempts=(ABLE,), reaction_s=0.0, jitter_s=0.5)
    assert min(early.init(Context("person", 1, trial, RateClock.from_rate("1000"))).course.onsets_ns[0]
               for trial in range(50)) == 100 * NS_PER_MS


def test_noise_of_effort_is_in_proportion_to_it():
    sds = []
    for strength in (0.2, 0.8):
        attempt = Attempt(at_s=0.0, duration_s=400.0, strength=strength, action="open_hand")
        person = Intention(attempts=(attempt,), noise=0.05)
        times, out = run(person, 60.0, "50")
        sds.append(out["voluntary"][times > 1.0][:, muscle("EDC3")].std())
        assert sds[-1] == pytest.approx(0.05 * strength, rel=0.2)
    assert sds[1] / sds[0] == pytest.approx(4.0, rel=1e-9)


@pytest.mark.parametrize(("limit", "strength"), [(0.7, 1.0), (0.7, 0.4), (1.0, 0.5), (0.0, 1.0)])
def test_emg_has_the_amplitude_of_the_effort_that_the_muscle_can_make(limit, strength):
    person = Intention(attempts=(Attempt(at_s=0.0, duration_s=100.0, strength=strength, muscles=("ECRL",)),),
                       emg=ECRL, voluntary_limits={"ECRL": limit}, **NOISELESS)
    times, out = run(person, 20.0)
    rms = out["emg"][times > 0.5].std()
    assert rms == pytest.approx(math.hypot(0.3e-3 * limit * strength, 5e-6), rel=0.05)


def test_emg_of_a_muscle_that_does_not_obey_is_that_of_rest():
    tried = (Attempt(at_s=0.0, duration_s=5.0, action="close_hand"),)
    limits = {"voluntary_limit": 0.0, "voluntary_limits": {"ECRL": 0.7}}
    person, idle = (Intention(attempts=attempts, emg=(EmgElectrode(muscle="FDP3"),), **limits)
                    for attempts in (tried, ()))
    assert run(person, 2.0)[1]["emg"].tobytes() == run(idle, 2.0)[1]["emg"].tobytes()
    assert not run(person, 2.0)[1]["voluntary"].any()
    (status, detail), = person.cautions(Context("person"))
    assert status == "attempt_in_vain"
    assert "FDP3" in detail


@pytest.mark.parametrize("rate", ["1000", "4000"])
def test_the_spectrum_is_that_of_the_model(rate):
    person = Intention(attempts=(Attempt(at_s=0.0, duration_s=100.0, muscles=("ECRL",)),),
                       emg=(EmgElectrode(muscle="ECRL", rest_uv=1e-3),), **NOISELESS)
    hertz = float(rate)
    times, out = run(person, 40.0 if rate == "1000" else 10.0, rate)
    at_hz, found = welch(out["emg"][times > 0.5, 0], hertz, nperseg=256)

    def density(f):
        return f**2 / ((f**2 + 60.0**2) * (f**2 + 120.0**2) ** 2)

    # A sampled signal has the power beyond half the rate folded back.
    folded = sum(density(np.abs(at_hz + k * hertz)) for k in range(-20, 21))
    expected = 0.3e-3**2 * folded / (2.0 * quad(density, 0.0, np.inf)[0]) * 2.0
    inner = (at_hz > 0.02 * hertz) & (at_hz < 0.45 * hertz)
    shares = found[inner] / expected[inner]
    assert np.median(shares) == pytest.approx(1.0, abs=0.06)
    assert np.log(shares).std() < 0.25


def test_an_artefact_decays_from_its_charge_and_blanking_hides_it():
    electrodes = (EmgElectrode(muscle="ECRL", rest_uv=1e-6, artefact_mv_per_uc=0.5),
                  EmgElectrode(muscle="FCR", rest_uv=1e-6))
    pulse = np.array([[0.010, 200e-6, 40.0], [0.005, 200e-6, 40.0]])

    def pulses(tick):
        return pulse if tick == 50 else np.zeros((2, 3)) if tick == 53 else None

    person = Intention(attempts=(), emg=electrodes, artefact_ms=2.0)
    assert [port.name for port in person.inputs] == ["stimulation"]
    times, out = run(person, 0.1, pulses=pulses)
    expected = np.where(times >= 0.05, 0.5e-3 * 3.0 * np.exp(-(times - 0.05) / 2e-3), 0.0)
    np.testing.assert_allclose(out["emg"][:, 0], expected, atol=1e-10)
    assert np.abs(out["emg"][:, 1]).max() < 1e-10
    blanked = Intention(attempts=(), emg=electrodes, artefact_ms=2.0, blanking_ms=7.5)
    lost = np.isnan(run(blanked, 0.1, pulses=pulses)[1]["emg"])
    assert np.flatnonzero(lost[:, 0]).tolist() == list(range(50, 58))
    assert not lost[:, 1].any()


@pytest.mark.parametrize(("parameters", "says"), [
    ({"attempts": (Attempt(at_s=1.0, muscles=("ECRX",)),)},
     r"attempts\[0\]\.muscles: 'ECRX'; .*did you mean 'ECR"),
    ({"attempts": (Attempt(at_s=1.0, action="open_hand"), Attempt(at_s=0.5, action="open_hand"))},
     r"attempts\[1\]\.at_s: 0\.5; .*2\.15 or more.*order of time"),
    ({"attempts": (), "emg": (EmgElectrode(muscle="deltoid"),)}, r"emg\[0\]\.muscle: 'deltoid'.*elsewhere"),
    ({"attempts": (), "elsewhere": {"FCR": 1.0}}, r"elsewhere\.FCR.*voluntary_limits"),
    ({"attempts": (), "elsewhere": {"deltoid": 1.5}}, r"elsewhere\.deltoid: 1\.5"),
    ({"attempts": (), "voluntary_limits": {"FCR": 2.0}}, "voluntary_limits"),
    ({"attempts": (), "band_hz": (200.0, 100.0)}, "band_hz"),
    ({"attempts": (), "rise_s": 0.0}, "rise_s"), ({"attempts": (), "noise": -0.1}, "noise")])
def test_wrong_parameters_are_refused_in_one_line(parameters, says):
    with pytest.raises(InputError, match=says) as refused:
        Intention(**parameters)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("parameters", "says"), [
    ({"action": "wave"}, "action: 'wave'"), ({}, "either an action or muscles"),
    ({"action": "open_hand", "muscles": ("FCR",)}, "either an action or muscles"),
    ({"action": "open_hand", "strength": 1.2}, "strength"),
    ({"action": "open_hand", "duration_s": 0.0}, "duration_s")])
def test_wrong_attempts_are_refused(parameters, says):
    with pytest.raises(InputError, match=says):
        Attempt(at_s=1.0, **parameters)
