"""Charges of elements, pulse by pulse, whatever pieces a file is read in."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.models.electrode_arrays import VirtualElectrode
from fesloop.show.picture.cast import Cast, Player
from fesloop.show.report.run.stimulation import element_charge

HZ, SLOTS, CHANNELS, ELEMENTS = 20, 8, 3, 5
SLOT_NS = 10**9 // (HZ * SLOTS)
ELECTRODES = (VirtualElectrode(elements=(0,)), VirtualElectrode(elements=(1, 2), shares=(0.25, 0.75)),
              VirtualElectrode(elements=(2, 4), shares=(0.5, 0.5)))
SHARES = np.array([[1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.25, 0.75, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0, 0.5]])
"""Of each channel, written down by hand."""


class Stimulator:
    """Three channels, each in a slot of its own of eight."""

    frequency_hz = str(HZ)

    @property
    def shares(self):
        return SHARES


class Told:
    """A recording of some signals, each read in pieces of so many rows."""

    def __init__(self, rows, **signals):
        self.rows = rows
        self.signals = {name.replace("_", ".", 1): values for name, values in signals.items()}

    def tables(self, names, trial):
        (name,) = names
        times, values = self.signals[name]
        pieces = [SimpleNamespace(times_ns=times[first:first + self.rows],
                                  values=(values[first:first + self.rows],))
                  for first in range(0, len(times), self.rows)]
        return [SimpleNamespace(pieces=lambda: iter(pieces))]

    def column(self, name, trial):
        return self.signals[name]


def known(recording, part=None, multiplexing=""):
    """As much of what is known of a run as charges need."""
    part = Stimulator() if part is None else part
    cast = Cast(None, (), None, Player("stimulator", part), "", "", multiplexing, "")
    return SimpleNamespace(cast=cast, recording=recording, signals=frozenset(recording.signals))


def pulsed(charges):
    """Rows of slots, (n,), ns, and what stands in them, C: of each channel that of its newest pulse.

    charges: (periods, channels), C a phase of every pulse; channel c has slot c.
    """
    values, newest = [], np.zeros(CHANNELS)
    for period in charges:
        for slot in range(SLOTS):
            if slot < CHANNELS:
                newest[slot] = period[slot]
            values.append(newest.copy())
    # The last pulses stand until those that would follow them.
    return SLOT_NS * np.arange(len(values)), np.array(values)


def silent_around(charges):
    """With a period without a pulse before and after them, so that every pulse stands its whole period."""
    return np.vstack([np.zeros(CHANNELS), charges, np.zeros(CHANNELS)])


PULSES = st.lists(st.tuples(*CHANNELS * [st.floats(0.0, 20e-6)]), min_size=1, max_size=6)


@settings(deadline=None)
@given(PULSES, st.integers(1, 60))
def test_every_pulse_counts_once_for_each_of_its_elements(pulses, rows):
    charges = silent_around(pulses)
    recording = Told(rows if rows > 1 else 2, stimulator_charge=pulsed(charges))
    total, shares = element_charge(known(recording), 0)
    expected = np.zeros((CHANNELS, ELEMENTS))
    for period in charges:
        for channel, electrode in enumerate(ELECTRODES):
            even = [1.0 / len(electrode.elements)] * len(electrode.elements)
            for element, share in zip(electrode.elements, electrode.shares or even, strict=True):
                expected[channel, element] += share * period[channel]
    np.testing.assert_allclose(shares, expected, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(total, expected.sum(axis=0), rtol=1e-9, atol=1e-18)


@settings(deadline=None)
@given(PULSES, st.integers(2, 60), st.integers(0, 5))
def test_a_pulse_goes_to_what_its_channel_is_switched_onto(pulses, rows, when):
    """Channel c goes to element c, from a period on to element 4 - c; before the first word to nothing."""
    charges = silent_around(pulses)
    turn_ns = when * SLOTS * SLOT_NS
    one, other = np.zeros((2, CHANNELS, ELEMENTS))
    one[range(CHANNELS), range(CHANNELS)] = 1.0
    other[range(CHANNELS), [4, 3, 2]] = 1.0
    switched = np.array([SLOTS * SLOT_NS, turn_ns + SLOTS * SLOT_NS]), np.stack([one, other])
    recording = Told(rows, stimulator_charge=pulsed(charges), mux_shares=switched)
    total, shares = element_charge(known(recording, multiplexing="mux.shares"), 0)
    expected = np.zeros((CHANNELS, ELEMENTS))
    times, values = pulsed(charges)
    for time_ns, row in zip(times, values, strict=True):
        if time_ns >= switched[0][0]:
            where = other if time_ns >= switched[0][1] else one
            expected += row[:, np.newaxis] * where / SLOTS
    np.testing.assert_allclose(shares, expected, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(total, expected.sum(axis=0), rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("rows", [2, 7, 1000])
def test_charges_of_elements_stand_for_themselves(rows):
    times, values = pulsed(silent_around([[1e-6, 2e-6, 4e-6], [3e-6, 0.0, 1e-6]]))
    recording = Told(rows, stimulator_element_charge=(times, values))
    total, shares = element_charge(known(recording), 0)
    np.testing.assert_allclose(total, [4e-6, 2e-6, 5e-6])
    assert shares is None


def test_what_is_not_known_is_not_guessed():
    times, values = pulsed(silent_around([[1e-6, 2e-6, 4e-6]]))
    nothing = Told(9, other_signal=(times, values))
    assert element_charge(known(nothing), 0) is None
    charges = Told(9, stimulator_charge=(times, values))
    assert element_charge(known(charges, part=SimpleNamespace(shares=SHARES)), 0) is None
    assert element_charge(known(charges, multiplexing="mux.shares"), 0) is None
    single = Told(9, stimulator_charge=(times[:1], values[:1]))
    assert element_charge(known(single), 0) is None
    assert element_charge(SimpleNamespace(cast=None), 0) is None
