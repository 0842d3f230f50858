"""What elements were given, and how the arrays are drawn: held against the recording and the block."""

import re
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from fesloop.experiment.recording.reading import Recording
from fesloop.hand.movements import MUSCLES
from fesloop.show.report.parts import Drawing, Strips
from fesloop.show.report.run import stimulation
from fesloop.show.report.run.fatigue import fatigue_section
from fesloop.show.report.run.known import known_of
from fesloop.show.report.run.stimulation import (
    arrays_svg,
    element_charge,
    final_stimulation,
    stimulation_section,
)
from fesloop.show.report.run.thinning import Course

SVG = "{http://www.w3.org/2000/svg}"
GRASP = str(Path(__file__).parents[2] / "picture" / "grasp.toml")


@pytest.fixture(scope="module")
def known(recorded):
    with Recording(recorded(GRASP)) as recording:
        yield known_of(recording)


def test_every_element_has_its_share_of_every_pulse_once(known):
    part = known.cast.stimulator.part
    rows = known.recording.signal(f"{known.cast.stimulator.name}.charge", 0)
    values, slots = rows.values, part.clock.rate / Fraction(part.frequency_hz)
    fired = np.arange(len(values)) % int(slots)
    pulses = [values[fired == channel, channel] for channel in range(values.shape[1])]
    charge, by_channel = element_charge(known, 0)
    for given, told in zip(pulses, by_channel.sum(axis=1), strict=True):
        assert told == pytest.approx(given.sum(), abs=1.01 * given.max())
    assert charge == pytest.approx(by_channel.sum(axis=0))
    used = {element for number, channel in enumerate(part.electrodes) if values[:, number].any()
            for element in channel.elements}
    assert set(np.flatnonzero(charge)) == used


def test_the_arrays_show_each_element_and_what_it_was_given(known):
    section = stimulation_section(known)
    drawing = next(part for part in section.parts if isinstance(part, Drawing))
    root = ElementTree.fromstring(drawing.svg)
    electrodes = known.cast.electrodes.part
    titles = [each.text for each in root.iter(f"{SVG}title")]
    charge, _ = element_charge(known, 0)
    for element in range(len(electrodes.places)):
        told = [float(re.match(rf"element {element}: ([\d.]+) µC", title)[1]) for title in titles
                if title.startswith(f"element {element}: ")]
        assert told
        assert told == pytest.approx([1e6 * charge[element]] * len(told), rel=5e-3)
    filled = [each for each in root.iter(f"{SVG}circle") if each.get("class").startswith("fill-channel")]
    assert len(filled) == np.count_nonzero(charge)
    wide, high = (float(each) for each in root.get("viewBox").split()[2:])
    assert all(0.0 <= float(each.get("cx")) <= wide and 0.0 <= float(each.get("cy")) <= high
               for each in root.iter(f"{SVG}circle"))


def test_channels_are_drawn_as_they_were_told(known):
    name = final_stimulation(known)
    values = known.recording.signal(name, 0).values
    charts = {part.title: part for part in stimulation_section(known).parts if isinstance(part, Strips)}
    used = np.flatnonzero((values[..., 0] * values[..., 1]).any(axis=0))
    names = [line.name for line in charts["Current, commanded"].lines]
    assert names == [f"channel {channel}" for channel in used]
    assert charts["Pulse width, commanded"].y_label == "width, µs"
    first = charts["Pulse width, commanded"].lines[0]
    highest = first.y if first.high is None else first.high
    assert highest.max() == pytest.approx(1e6 * values[:, used[0], 1].max())


def test_fatigue_tells_the_least_that_is_left(known):
    values = known.recording.signal("muscles.fitness", 0).values
    paragraph = fatigue_section(known).parts[0].text
    assert f"{values[-1].min():.3f} ({MUSCLES[values[-1].argmin()]})" in paragraph or values.min() > 0.995


def test_strips_share_one_scale_from_0_and_their_text_tells_the_greatest(known):
    values = known.recording.signal(final_stimulation(known), 0).values
    for port, (title, factor) in enumerate((("Current", 1e3), ("Pulse width", 1e6))):
        (strips,) = [part for part in stimulation_section(known).parts
                     if isinstance(part, Strips) and part.title == f"{title}, commanded"]
        used = np.flatnonzero((values[..., 0] * values[..., 1]).any(axis=0))
        greatest = factor * values[:, used, port].max(axis=0)
        assert strips.limits[0] == 0.0
        assert strips.limits[1] == pytest.approx(1.05 * greatest.max())
        told = dict(re.findall(r"(channel \d+) up to (\d+\.?\d*)", strips.text))
        assert {name: float(text) for name, text in told.items()} == pytest.approx(
            {f"channel {channel}": most for channel, most in zip(used, greatest, strict=True)}, rel=5e-3)


@pytest.mark.parametrize("width_us", [300, 15])
def test_what_the_device_did_not_give_is_not_shown_as_given(recorded, width_us):
    """Under its least pulse width a stimulator gives nothing, whatever it is commanded."""
    with Recording(recorded(
            GRASP, "blocks.stimulator.width_min_us=20",
            f"blocks.programme.width_us=[[300, 300, 300, {width_us}]]")) as recording:
        known = known_of(recording)
        strips = {part.title: part for part in stimulation_section(known).parts if isinstance(part, Strips)}
        commanded = recording.signal(final_stimulation(known), 0).values
        charges = recording.signal(f"{known.cast.stimulator.name}.charge", 0).values
    used, gave = (commanded[..., 0] * commanded[..., 1]).any(axis=0), charges.any(axis=0)
    assert (used & ~gave).any() == (width_us < 20)
    for title in ("Charge of a pulse, delivered", "Current, commanded", "Pulse width, commanded"):
        assert [line.name for line in strips[title].lines] == [
            f"channel {channel}" + ("" if gave[channel] else ", no pulse delivered")
            for channel in np.flatnonzero(used)]
    for line, channel in zip(strips["Charge of a pulse, delivered"].lines, np.flatnonzero(used), strict=True):
        highest = line.y if line.high is None else line.high
        assert highest.max() == pytest.approx(1e6 * charges[:, channel].max())


def test_a_trial_without_a_pulse_has_no_strips_and_is_named(known, monkeypatch):
    silent = Course(np.arange(3.0), np.zeros((3, 4, 2)), None, None)
    monkeypatch.setattr(stimulation, "course", lambda *_: silent)
    parts = stimulation_section(known).parts
    assert not [part for part in parts if isinstance(part, Strips)]
    assert "No channel delivered a pulse in trial 0." in [getattr(part, "text", "") for part in parts]


def test_great_charges_are_told_without_exponents(known):
    electrodes = known.cast.electrodes.part
    drawn = arrays_svg(electrodes, np.full(len(electrodes.places), 12.34e-3), 1.0, None, None)
    assert "element 0: 12340 µC" in drawn
