"""Contrast of the page's colours, on light and on dark (WCAG 2.2, 1.4.3 and 1.4.11)."""

import re

import pytest

from fesloop.show.report.page import asset

COLOURS = {name: pair for name, *pair in
           re.findall(r"--([\w-]+): light-dark\((#[0-9a-f]{6}), (#[0-9a-f]{6})\)", asset("page.css"))}
ROLES = ["reference", "truth", "estimate", "controller", "tracker", "theory", "plain",
         *(f"channel-{i}" for i in range(8))]


def luminance(colour):
    parts = [int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize("role", ROLES)
def test_lines_stand_out(role, theme):
    assert contrast(COLOURS[role][theme], COLOURS["paper"][theme]) >= 3.0


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize(("text", "paper"), [
    ("ink", "paper"), ("ink", "raised"), ("quiet", "paper"), ("quiet", "stretch-other"), ("accent", "paper"),
    ("ink", "warn-paper"), ("on-good", "heat-good"), ("on-good", "heat-middling"),
    ("on-middling", "heat-middling"), ("on-bad", "heat-bad")])
def test_texts_can_be_read(text, paper, theme):
    assert contrast(COLOURS[text][theme], COLOURS[paper][theme]) >= 4.5
