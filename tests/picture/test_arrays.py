"""The picture of the arrays shows every element and motor point where the block has them."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Wedge

from fesloop.hand.movements import EXTRINSIC, MUSCLES, muscle
from fesloop.models.electrode_arrays import ElectrodeArray
from fesloop.show.picture.arrays import arrays_figure, draw_elements, placed_labels, unrolled
from fesloop.show.picture.palette import channel_colour
from plants.electrodes import Electrodes

NOTHING = {"recruitment": None, "activation": None, "fitness": None}


def texts(figure):
    """Text and place by the mark of each marked text."""
    return {text.get_gid(): (text.get_text(), text.get_position()) for axes in figure.axes
            for text in axes.texts if text.get_gid()}


@pytest.mark.parametrize("electrodes", [
    Electrodes(), Electrodes(shift_mm=15.0, shift_deg=-20.0, radius_mm=35.0),
    Electrodes(arrays=(ElectrodeArray(positions=((350.0, 80.0), (-200.0, 100.0))),))])
def test_every_element_has_a_pad_and_its_number_at_its_place(electrodes):
    figure = arrays_figure(electrodes, None, 0.0, None, None, NOTHING, "")
    skin = figure.axes[0]
    found, pads = texts(figure), [patch for patch in skin.patches if type(patch) is Circle]
    left, right = skin.get_xlim()
    low, high = sorted(skin.get_ylim())
    for element, (around, along, size) in enumerate(electrodes.places):
        text, (x, y) = found[f"element {element}"]
        assert text == str(element)
        # The same place but for whole turns.
        turns = (x - around) / (2.0 * np.pi * electrodes.radius_mm)
        assert turns == pytest.approx(round(turns), abs=1e-9)
        assert abs(y - along) < size
        assert left <= x <= right
        assert low < along - size < along + size < high
        assert any(np.allclose((*pad.center, pad.radius), (x, along, size)) for pad in pads)


def test_motor_points_are_labelled_with_their_recruited_share():
    recruitment = np.zeros(len(MUSCLES))
    recruitment[muscle("FDS3")] = 0.43
    figure = arrays_figure(Electrodes(), None, 0.0, None, None, {**NOTHING, "recruitment": recruitment}, "")
    labels = {mark: text for mark, (text, _) in texts(figure).items() if mark.startswith("motor point")}
    assert labels == {f"motor point {name}": name + (" 43 %" if name == "FDS3" else "") for name in EXTRINSIC}
    wedge, = (patch for patch in figure.axes[0].patches if isinstance(patch, Wedge))
    assert wedge.theta2 - wedge.theta1 == pytest.approx(0.43 * 360.0)


def test_no_marker_covers_the_number_of_an_element():
    """Discs of motor points and their labels, as they are drawn, against the numbers, in pixels."""
    figure = arrays_figure(Electrodes(), None, 0.0, None, None, NOTHING, "")
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    skin = figure.axes[0]
    boxes = {text.get_gid(): text.get_window_extent(renderer) for text in skin.texts if text.get_gid()}
    numbers = {mark: box for mark, box in boxes.items() if mark.startswith("element")}
    labels = {mark: box for mark, box in boxes.items() if mark.startswith("motor point")}
    discs = {patch.center: patch.get_window_extent(renderer) for patch in skin.patches
             if type(patch) is Circle and patch.radius == 2.4}
    assert (len(numbers), len(labels), len(discs)) == (59, 24, 24)
    covered = [(number, mark) for number, box in numbers.items() for mark, other in (labels | discs).items()
               if min(box.x1, other.x1) - max(box.x0, other.x0) > 3
               and min(box.y1, other.y1) - max(box.y0, other.y0) > 3]
    assert covered == []
    top = max(patch.get_zorder() for patch in skin.patches)
    assert all(text.get_zorder() > top for text in skin.texts if (text.get_gid() or "").startswith("element"))


def test_dorsal_and_volar_are_named_over_their_own_elements():
    figure = arrays_figure(Electrodes(), None, 0.0, None, None, NOTHING, "")
    names = {text.get_text(): text.get_position()[0] for text in figure.axes[0].texts}
    quarter = 0.5 * np.pi * Electrodes().radius_mm
    around = unrolled(Electrodes().places, Electrodes().radius_mm)[:, 0]
    assert names["DORSAL"] < around[:35].min()
    assert around[:35].max() < quarter < names["VOLAR"] < around[35:].min()


def test_more_charge_is_darker_and_none_is_blank():
    axes = Figure().subplots()
    places = np.array([[20.0 * i, 0.0, 7.0] for i in range(5)])
    draw_elements(axes, places, 1e-6 * np.arange(5.0), 4e-6, places[:, :2])
    light = [sum(patch.get_facecolor()[:3]) for patch in axes.patches]
    assert light == sorted(light, reverse=True)
    assert len(set(light)) == 5
    assert axes.patches[0].get_facecolor() == to_rgba("#fffdfa")


def test_each_channel_rings_its_elements_in_its_colour():
    shares = np.zeros((2, 59))
    shares[0, [3, 4]] = 0.5
    shares[1, [4, 50, 51]] = 1 / 3
    figure = arrays_figure(Electrodes(), None, 0.0, shares, np.array([[0.02, 3e-4], [0.0, 0.0]]), NOTHING, "")
    places = unrolled(Electrodes().places, 40.0)
    for channel, row in enumerate(shares):
        rings = {patch.center for patch in figure.axes[0].patches
                 if type(patch) is Circle and patch.get_edgecolor() == to_rgba(channel_colour(channel))}
        assert rings == {tuple(places[element, :2]) for element in np.flatnonzero(row)}
    said = [text.get_text() for text in figure.texts]
    assert "● channel 0: 20.0 mA, 300 µs" in said
    assert "● channel 1: off" in said


def test_bars_are_as_long_as_what_they_stand_for():
    values = {key: np.random.default_rng(i).uniform(size=29)
              for i, key in enumerate(("recruitment", "activation", "fitness"))}
    bars = arrays_figure(Electrodes(), None, 0.0, None, None, values, "").axes[-1]
    for container, key in zip(bars.containers, ("recruitment", "activation"), strict=True):
        np.testing.assert_allclose([bar.get_width() for bar in container], values[key])
    assert [label.get_text() for label in bars.get_yticklabels()] == list(MUSCLES)


def test_labels_keep_clear_of_each_other_where_there_is_room():
    points = {"A": np.array([0.0, 0.0]), "B": np.array([6.0, 0.0]), "C": np.array([0.0, 6.0])}
    spots = placed_labels(points, dict.fromkeys(points, "ABC 10 %"), 2.4)
    places = np.array(list(spots.values()))
    for i in range(3):
        for j in range(i):
            apart = np.abs(places[i] - places[j])
            assert apart[0] > 12.9 or apart[1] > 3.3
