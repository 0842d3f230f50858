"""Charts, bars and heat maps: none is empty, all follow the trial, the play head and the width."""

import re
from dataclasses import replace

import numpy as np
import pytest
from made_up_pages import CHANNELS, channels, heat_map, page

from fesloop.show.report.parts import Bars, Chart, Line, Section, Strips


def drawn(shown, key):
    """The figure of a part, scrolled to and drawn."""
    figure = shown.locator(f"#part-{key}")
    figure.scroll_into_view_if_needed()
    figure.locator(".plot svg").wait_for()
    return figure


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize(("key", "shapes", "count"), [
    ("error", "[aria-label=line] path", 1), ("kinds", "[aria-label=dot] circle", 2),
    ("decades", "[aria-label=line] path", 1), ("index-3", "[aria-label=line] path", 3),
    ("channels", "[aria-label=line] path", CHANNELS), ("stacked", "[aria-label=bar] rect", 4),
    ("beside", "[aria-label=bar] rect", 4), ("heat", "[aria-label=rect] rect", 6)])
def test_no_figure_is_empty(opened, key, shapes, count, width):
    figure = drawn(opened(page(), width=width), key)
    marks = figure.locator(shapes)
    boxes = [marks.nth(i).bounding_box() for i in range(marks.count())]
    assert len(boxes) == count
    svg = figure.locator("svg").first.bounding_box()
    for box in boxes:
        assert box["width"] * box["height"] > 4
        assert svg["x"] <= box["x"]
        assert box["x"] + box["width"] <= min(svg["x"] + svg["width"], width) + 1


@pytest.mark.slow
def test_bars_have_three_digits_and_counts_none_after_the_point(opened):
    bars = Bars(key="told", title="told", x_label="error, deg", names=["a", "b", "c"],
                values={"error": [1.301, 0.0499, 12.0]}, roles={"error": "plain"}, stacked=False)
    figure = drawn(opened(page(sections=[Section(key="a", title="a", parts=[bars])])), "told")
    texts = figure.locator("[aria-label=text] text").all_text_contents()
    assert texts == ["1.30", "0.0499", "12"]


@pytest.mark.slow
def test_a_number_that_is_not_known_is_a_gap(opened):
    figure = drawn(opened(page()), "index-3")
    paths = figure.locator("[aria-label=line] path")
    assert [paths.nth(i).get_attribute("d").count("M") for i in range(3)] == [1, 2, 1]


def test_a_line_goes_where_its_numbers_say(opened):
    """A sine of an amplitude of 1 in limits of 2: its path spans half of the frame."""
    x = np.linspace(0.0, 1.0, 401)
    chart = Chart(key="sine", title="sine", x_label="x", y_label="y", limits=(-2.0, 2.0),
                  lines=[Line(name="sine", role="plain", x=x, y=np.sin(2 * np.pi * x))])
    shown = opened(page(sections=[Section(key="a", title="a", parts=[chart])]))
    figure = drawn(shown, "sine")
    path = figure.locator("[aria-label=line] path").get_attribute("d")
    points = np.array([pair.split(",") for pair in re.findall(r"[ML]([^ML]+)", path)], dtype=float)
    assert len(points) == 401
    ticks = figure.locator('[aria-label="y-axis tick"] path')
    ends = [float(re.search(r",([\d.]+)\)", ticks.nth(i).get_attribute("transform"))[1])
            for i in (0, ticks.count() - 1)]
    per_unit = (ends[0] - ends[1]) / 4.0
    zero = (ends[0] + ends[1]) / 2.0
    assert (zero - points[:, 1]) / per_unit == pytest.approx(np.sin(2 * np.pi * x), abs=0.01)
    across = points[:, 0] - points[0, 0]
    assert across / across[-1] == pytest.approx(x, abs=1e-3)


@pytest.mark.slow
def test_what_is_pointed_at_is_told(opened):
    shown = opened(page())
    figure = drawn(shown, "error")
    dots = figure.locator("[aria-label=dot] circle")
    dots.nth(1).hover()
    told = figure.locator(".told")
    assert told.is_visible()
    assert re.sub(r"\s+", " ", told.inner_text()).endswith("error 4")
    heat = drawn(shown, "heat")
    heat.locator("[aria-label=rect] rect").nth(4).hover(force=True)
    assert re.sub(r"\s+", " ", heat.locator(".told").inner_text()).strip() == "delay 20 ms, gain high 5 deg"


@pytest.mark.slow
def test_a_chart_of_time_moves_the_play_head_and_follows_it(opened):
    shown = opened(page())
    figure = drawn(shown, "index-3")
    frame = figure.locator("[aria-label=line] path").first.bounding_box()
    heads = "[...document.querySelectorAll('.play-head')].map((head) => head.getBoundingClientRect().x)"
    shown.mouse.click(frame["x"] + 0.75 * frame["width"], frame["y"] + 0.5 * frame["height"])
    assert shown.locator(".bar .time").inner_text().startswith("1.5")
    first, second = shown.evaluate(heads)[:2]
    assert first == pytest.approx(frame["x"] + 0.75 * frame["width"], abs=2)
    other = shown.locator("#part-middle-3 [aria-label=line] path").first.bounding_box()
    assert second == pytest.approx(other["x"] + 0.75 * other["width"], abs=2)


@pytest.mark.slow
def test_the_chosen_trial_is_shown_and_no_other(opened):
    shown = opened(page())
    for trial in (1, 2, 3):
        shown.locator("#trial").select_option(str(trial))
        drawn(shown, f"index-{trial}")
        for other in (1, 2, 3):
            assert shown.locator(f"#part-index-{other}").is_visible() == (other == trial)


@pytest.mark.slow
def test_trials_are_stepped_through_up_to_the_ends(opened):
    shown = opened(page())
    on, back = (shown.get_by_role("button", name=name) for name in ("Next trial", "Trial before"))
    assert on.is_disabled()
    back.click()
    back.click()
    assert shown.locator("#trial").input_value() == "1"
    assert back.is_disabled()
    on.press("Enter")
    assert shown.locator("#part-index-2").is_visible()


@pytest.mark.slow
def test_charts_of_one_kind_share_a_key(opened):
    shown = opened(page())
    drawn(shown, "index-3")
    names = shown.locator(".multiples:visible > .key li").all_inner_texts()
    assert names == ["reference", "truth", "estimate"]


@pytest.mark.slow
def test_names_stand_at_lines_ends_where_there_is_room(opened):
    x = np.arange(3.0)
    chart = Chart(key="two", title="two", x_label="x", y_label="y", lines=[
        Line(name=name, role="plain", x=x, y=x + by) for name, by in (("one", 0.0), ("other", 0.01))])
    sections = [Section(key="a", title="a", parts=[chart])]
    figure = drawn(opened(page(sections=sections)), "two")
    boxes = [figure.locator(".end").nth(i).bounding_box() for i in range(2)]
    assert figure.locator(".end").all_text_contents() == ["one", "other"]
    assert abs(boxes[0]["y"] - boxes[1]["y"]) >= 14
    narrow = drawn(opened(page(sections=sections), width=400), "two")
    assert narrow.locator(".end").count() == 0
    assert narrow.locator(".key li").all_inner_texts() == ["one", "other"]


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 400])
def test_strips_lie_below_each_other_each_under_its_name(opened, width):
    figure = drawn(opened(page(), width=width), "channels")
    paths = figure.locator("[aria-label=line] path")
    boxes = [paths.nth(i).bounding_box() for i in range(CHANNELS)]
    texts = figure.locator("svg text")
    names = {texts.nth(i).text_content(): texts.nth(i).bounding_box() for i in range(texts.count())}
    ends = [box["y"] + box["height"] for box in boxes]
    for number, box in enumerate(boxes):
        name = names[f"channel {number}"]
        assert name["y"] < box["y"]
        assert name["x"] + name["width"] <= width
        if number:
            assert ends[number - 1] < box["y"]
            assert ends[number - 1] <= name["y"] + 2
    heights = [box["height"] for box in boxes]
    assert max(heights) - min(heights) < 1.0
    assert min(heights) > 20
    assert {text for text in names if text[0].isdigit()} >= {"0", "20"}


@pytest.mark.parametrize("count", [1, 2, 20])
def test_strips_are_as_high_as_they_can_be_read(opened, count):
    shown = opened(page(sections=[Section(key="a", title="a", parts=[channels(count)])]), width=400)
    figure = drawn(shown, "channels")
    box = figure.locator("[aria-label=line] path").first.bounding_box()
    assert 20 < box["height"] < 80
    drawn_high = figure.locator(".plot").bounding_box()["height"]
    kept_high = shown.evaluate("""() => {
        const plot = document.querySelector('#part-channels .plot');
        plot.replaceChildren();
        return plot.getBoundingClientRect().height;
    }""")
    assert kept_high == pytest.approx(drawn_high, abs=3)


def test_the_play_head_goes_through_all_strips(opened):
    shown = opened(page())
    figure = drawn(shown, "channels")
    paths = figure.locator("[aria-label=line] path")
    boxes = [paths.nth(i).bounding_box() for i in (0, CHANNELS - 1)]
    shown.mouse.click(boxes[1]["x"] + 0.75 * boxes[1]["width"], boxes[1]["y"] + 10)
    assert shown.locator(".bar .time").inner_text().startswith("1.5")
    head = figure.locator(".play-head").bounding_box()
    assert head["y"] <= boxes[0]["y"]
    assert head["y"] + head["height"] >= boxes[1]["y"] + boxes[1]["height"] - 1
    told = re.sub(r"\s+", " ", figure.locator(".told").inner_text())
    assert re.match(r"time 1\.[45]\d* s ", told)
    assert all(f"channel {number} 20" in told for number in range(CHANNELS))


@pytest.mark.parametrize("values", [np.nan, 5.0])
def test_a_map_whose_colours_have_no_ends_is_drawn_empty_and_says_so(opened, values):
    empty = replace(heat_map(), values=np.full((2, 3), values), low=np.nan, high=np.nan)
    shown = opened(page(sections=[Section(key="a", title="a", parts=[empty])]))
    figure = drawn(shown, "heat")
    cells = figure.locator("[aria-label=rect] rect")
    assert {cells.nth(i).get_attribute("fill") for i in range(cells.count())} == {"var(--no-value)"}
    assert figure.locator(".ramp").count() == 0
    assert figure.locator(".notice").inner_text() == empty.lack != ""
    assert shown.locator("svg text", has_text="NaN").count() == 0


@pytest.mark.slow
@pytest.mark.parametrize("y", [
    [], [np.nan] * 3, [1.0], [2.0, 2.0], [np.inf, 1.0, -np.inf], [1e308, -1e308, 0.0]])
def test_numbers_that_make_no_line_make_no_trouble(opened, y):
    line = Line(name="odd", role="plain", x=np.arange(float(len(y))), y=np.array(y))
    charts = [Chart(key=f"odd-{log}", title="odd", x_label="x", y_label="y", lines=[line], x_log=log)
              for log in (False, True)]
    strips = Strips(key="odd-strips", title="odd", x_label="x", y_label="y", lines=[line, line])
    shown = opened(page(sections=[Section(key="a", title="a", parts=[*charts, strips])]))
    for which in (False, True, "strips"):
        assert "NaN" not in drawn(shown, f"odd-{which}").locator(".plot").inner_html()


def told_at(shown, key, share):
    """What is told where so much of a chart's frame is left of the pointer, by line; and its head."""
    figure = drawn(shown, key)
    paths = figure.locator("[aria-label=line] path, [aria-label=dot] circle")
    boxes = [paths.nth(i).bounding_box() for i in range(paths.count())]
    left = min(box["x"] for box in boxes)
    right = max(box["x"] + box["width"] for box in boxes)
    box = figure.locator(".plot svg").bounding_box()
    shown.mouse.move(left + share * (right - left), box["y"] + 0.5 * box["height"])
    rows, found = figure.locator(".told .row"), {}
    for i in range(rows.count()):
        value = rows.nth(i).locator(".value").text_content()
        found[rows.nth(i).text_content().removesuffix(value)] = value
    return figure.locator(".told b").text_content(), found


def test_what_is_told_is_what_is_drawn_there(opened):
    """Between points of a line, in a gap, held, beyond the end, of points, and of an upright line."""
    x = np.arange(11.0)
    lines = [Line(name="fine", role="plain", x=x, y=x),
             Line(name="coarse", role="truth", x=np.array([0.0, 10.0]), y=np.array([0.0, 100.0])),
             Line(name="gap", role="estimate", x=x, y=np.where(x == 5.0, np.nan, 7.0)),
             Line(name="held", role="tracker", style="steps", x=np.array([0.0, 4.0, 10.0]),
                  y=np.array([1.0, 2.0, 3.0])),
             Line(name="short", role="controller", x=np.array([0.0, 3.0]), y=np.array([1.0, 1.0])),
             Line(name="point", role="series-3", style="points", x=np.array([0.0, 10.0]),
                  y=np.array([8.0, 9.0])),
             Line(name="bound", role="theory", style="dashed", x=np.repeat(2.0, 3),
                  y=np.array([0.0, 100.0, np.nan]))]
    chart = Chart(key="told", title="told", x_label="latency, ms", y_label="y", lines=lines)
    shown = opened(page(sections=[Section(key="a", title="a", parts=[chart])]))
    head, told = told_at(shown, "told", 0.51)
    assert head == "latency 5 ms"
    assert told == {"fine": "5", "coarse": "50", "gap": "none", "held": "2", "short": "none", "point": "none"}
    head, told = told_at(shown, "told", 0.999)
    assert head == "latency 10 ms"
    assert (told["point"], told["held"], told["gap"]) == ("9", "3", "7")


def test_of_a_level_without_a_value_none_is_told(opened):
    lines = [Line(name="one", role="plain", style="points", x=np.array([-0.06, 0.94, 1.94]),
                  y=np.array([1.0, np.nan, 3.0])),
             Line(name="other", role="truth", style="points", x=np.array([0.06, 2.06]),
                  y=np.array([4.0, 6.0]))]
    chart = Chart(key="told", title="told", x_label="law", y_label="y", lines=lines,
                  x_levels=["pid", "ilc", "mpc"])
    shown = opened(page(sections=[Section(key="a", title="a", parts=[chart])]))
    assert told_at(shown, "told", 0.5) == ("ilc", {"one": "none", "other": "none"})
    assert told_at(shown, "told", 0.99) == ("mpc", {"one": "3", "other": "6"})
