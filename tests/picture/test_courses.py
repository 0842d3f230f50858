"""Time courses of objects and the heads of pictures, read from the figures themselves."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib import rcParams
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.show.picture.cast import Cast, Player
from fesloop.show.picture.courses import _digit, courses_figure, draw_height
from fesloop.show.picture.draw import title_of
from fesloop.show.picture.hand import head_lines


@pytest.mark.parametrize(("lowest_m", "cut"), [(-0.2, False), (-180.0, True)])
def test_a_fall_does_not_hide_how_the_object_was_held(lowest_m, cut):
    axes = Figure().add_subplot()
    seconds = np.linspace(0.0, 1.0, 11)
    values = np.zeros((11, 3))
    values[8:, 2] = lowest_m
    draw_height(axes, seconds, values)
    low, high = axes.get_ylim()
    assert high > 0.0
    assert (low > 1e3 * lowest_m) == cut
    assert low >= -301.0
    assert axes.get_title(loc="left").endswith("until it fell") == cut


@pytest.mark.parametrize(("patient", "named"), [
    (None, "open_close, seed 7"), ({"file": "sci_c6"}, "open_close, seed 7, sci_c6"),
    ({"file": "people/mine.toml", "cohort": 2, "member": 3, "day": 1},
     "open_close, seed 7, mine, member 3 of cohort 2, day 1")])
def test_the_title_names_the_patient(patient, named):
    experiment = {} if patient is None else {"patient": patient}
    recording = SimpleNamespace(name="open_close", trials=1, seed=7, status="done", experiment=experiment)
    assert title_of(recording, SimpleNamespace(hand=None), 0) == named


TITLE = "open_close, seed 1, stroke_severe_spastic, member 12 of cohort 3, day 14, right hand of 190 mm"


@pytest.mark.parametrize(("width_in", "lines"), [(10.0, 1), (2.5, 4)])
def test_the_head_of_a_hand_fits_over_it(width_in, lines):
    told = head_lines(TITLE, "estimate of tracker", width_in)
    assert [is_title for _, is_title in told] == [True] * lines + [False]
    assert " ".join(line for line, is_title in told if is_title) == TITLE
    figure = Figure(figsize=(width_in, 1.0), dpi=200)
    renderer = FigureCanvasAgg(figure).get_renderer()
    for line, _ in told:
        assert figure.text(0.0, 0.5, line, fontsize=10).get_window_extent(renderer).width <= 200 * width_in


def test_lines_of_the_key_are_long_enough_for_their_dashes():
    """A whole period of dash and dot fits: without the dot, it looks like a solid line."""
    axes = Figure().add_subplot()
    courses = np.linspace(0.0, 1.0, 5), np.zeros((5, 23))
    freedoms = hand_tree(HandSize()).freedoms
    _digit("F1", "thumb", freedoms, courses, None, axes)
    legend = axes.get_legend()
    pronation = next(line for line in axes.lines if line.get_label() == "CMC pronation")
    period_points = sum(rcParams["lines.dashdot_pattern"]) * pronation.get_linewidth()
    assert legend.handlelength * legend._fontsize >= period_points


def test_of_the_trackers_one_that_has_all_angles_lies_beside_the_truth():
    times_ns, rng = np.arange(0, 500_000_000, 100_000_000), np.random.default_rng(1)
    columns = {"hand.angles": rng.random((5, 23)), "few.angles": rng.random((5, 2)),
               "whole.angles": rng.random((5, 23))}
    recording = SimpleNamespace(signals=tuple(columns),
                                column=lambda name, trial=0: (times_ns, columns[name]))
    few, whole = (Player(name, SimpleNamespace(hand=HandSize())) for name in ("few", "whole"))

    def wrist(*trackers):
        cast = Cast(hand=Player("hand", SimpleNamespace(hand=HandSize())), trackers=trackers, electrodes=None,
                    stimulator=None, muscles="", stimulation="", multiplexing="", rotation="")
        figure, notes = courses_figure(recording, cast, 0, np.array([0]), 400_000_000, "a run")
        assert not notes
        axes = figure.axes[0]
        return axes.get_title(loc="left"), [line for line in axes.get_lines() if line.get_linewidth() == 0.7]

    assert wrist(few) == ("wrist", [])
    title, thin = wrist(few, whole)
    assert title == "wrist; thin lines: whole"
    np.testing.assert_allclose(thin[0].get_ydata(), np.degrees(columns["whole.angles"][:, 0]))
