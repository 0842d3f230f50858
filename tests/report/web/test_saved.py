"""Figures of a report are saved as CSV and SVG, without a network and without a mouse."""

import csv
from xml.etree import ElementTree

import numpy as np
import pytest
from made_up_pages import page

from fesloop.show.report.parts import Bars, Drawing, HeatMap, Line, Section, Strips

SVG = "{http://www.w3.org/2000/svg}"
PULSES = Line(name="channel 0", role="channel-0", x=np.array([0.0, 0.5]), y=np.array([1.0, np.nan]),
              low=np.array([0.5, 0.0]), high=np.array([1.5, 2.0]), style="steps")
PARTS = [
    Strips(key="pulses", title="Pulses", x_label="time, s", y_label="charge, µC", lines=[PULSES]),
    Bars(key="shares", title="Shares", x_label="error, deg", names=["wrist", 'F2 "index", MCP'],
         values={"tracker": [1.25, 2.0], "controller": [0.5, float("nan")]},
         roles={"tracker": "tracker", "controller": "controller"}),
    HeatMap(key="map", title="Map", x_label="latency, ms", y_label="error, deg", x_levels=["0", "40"],
            y_levels=["1"], values=np.array([[3.0, np.nan]]), cells=[["3", ""]], told=[["3", "none"]],
            value_label="error, deg", low=0.0, high=3.0),
    Drawing(key="arrays", title="Arrays", text="An element.",
            svg='<svg viewBox="0 0 9 9"><circle class="fill-series-0" cx="4" cy="4" r="3"/></svg>'),
]


@pytest.fixture
def saved(opened, tmp_path):
    shown = opened(page(sections=[Section(key="all", title="All", parts=PARTS)]), accept_downloads=True)

    def save(key, kind):
        button = shown.locator(f"#part-{key} .save").get_by_role("button", name=f"as {kind}")
        button.scroll_into_view_if_needed()
        if key != "arrays":
            shown.locator(f"#part-{key} .plot svg").wait_for()
        button.focus()
        with shown.expect_download() as download:
            shown.keyboard.press("Enter")
        assert download.value.suggested_filename == f"page_{key}.{kind.lower()}"
        path = tmp_path / download.value.suggested_filename
        download.value.save_as(path)
        return path

    return save


@pytest.mark.browser
@pytest.mark.parametrize(("key", "rows"), [
    ("pulses", [["series", "time, s", "charge, µC", "lowest", "highest"],
                ["channel 0", "0", "1", "0.5", "1.5"], ["channel 0", "0.5", "", "0", "2"]]),
    ("shares", [["name", "series", "error, deg"], ["wrist", "tracker", "1.25"],
                ['F2 "index", MCP', "tracker", "2"], ["wrist", "controller", "0.5"],
                ['F2 "index", MCP', "controller", ""]]),
    ("map", [["latency, ms", "error, deg", "error, deg"], ["0", "1", "3"], ["40", "1", ""]]),
])
def test_the_numbers_of_a_figure_are_a_table(saved, key, rows):
    with saved(key, "CSV").open(encoding="utf-8", newline="") as file:
        assert list(csv.reader(file)) == rows


@pytest.mark.browser
@pytest.mark.parametrize("key", ["pulses", "shares", "map", "arrays"])
def test_a_saved_figure_has_its_title_and_needs_no_style_sheet(saved, key):
    root = ElementTree.fromstring(saved(key, "SVG").read_text(encoding="utf-8"))
    title = next(part.title for part in PARTS if part.key == key)
    assert title in [text.text for text in root.iter(f"{SVG}text")]
    assert "var(--" not in ElementTree.tostring(root, encoding="unicode")
    drawn = [each for each in root.iter() if each.tag in (f"{SVG}path", f"{SVG}rect", f"{SVG}circle")]
    assert any("fill: rgb" in each.get("style", "") for each in drawn)
