"""What elements were given, and how the arrays are drawn: held against the recording and the block."""

from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from fesloop.experiment.recording.reading import Recording
from fesloop.hand.muscles import MUSCLES
from fesloop.report.parts import Drawing, Strips
from fesloop.report.run.fatigue import fatigue_section
from fesloop.report.run.known import known_of
from fesloop.report.run.stimulated import element_charge, final_stimulation
from fesloop.report.run.stimulation import stimulation_section

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
        assert any(title.startswith(f"element {element}: {1e6 * charge[element]:.3g} µC") for title in titles)
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
    assert [line.name for line in charts["Current"].lines] == [f"channel {channel}" for channel in used]
    assert charts["Pulse width"].y_label == "width, µs"
    first = charts["Pulse width"].lines[0]
    highest = first.y if first.high is None else first.high
    assert highest.max() == pytest.approx(1e6 * values[:, used[0], 1].max())


def test_fatigue_tells_the_least_that_is_left(known):
    values = known.recording.signal("muscles.fitness", 0).values
    paragraph = fatigue_section(known).parts[0].text
    assert f"{values[-1].min():.3f} ({MUSCLES[values[-1].argmin()]})" in paragraph or values.min() > 0.995
