"""The page of `fesloop view` in a browser: frames arrive and are drawn, and its controls are heard."""

import re
import threading
from pathlib import Path

import pytest
from view_parts import serving

from fesloop.experiment.files.parse import load
from fesloop.experiment.running.trial import run
from fesloop.view.sources import open_recording

GRASP = str(Path(__file__).parents[2] / "picture" / "grasp.toml")
_READBACK = "GPU stall due to ReadPixels"


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    settings = ["experiment.trials=2", "experiment.duration_s=2"]
    found = open_recording(Path(run(load(GRASP, settings), tmp_path_factory.mktemp("runs")).recording))
    yield found
    found.close()


@pytest.fixture
def looked_at(chromium, source):
    """The page; afterwards nothing went wrong in it, and nothing was asked of anybody else."""
    said, asked = [], []
    with serving(source) as server:
        context = chromium.new_context(viewport={"width": 1280, "height": 900})
        page = context.new_page()
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(server.address)
        page.wait_for_function("document.querySelector('.stage').dataset.time !== undefined", timeout=60_000)
        yield page
        context.close()
        address = server.address
    assert [text for text in said if _READBACK not in text] == []
    assert all(url.startswith((address, "data:")) for url in asked)


def shown(page):
    """Trial and time of the frame that is drawn."""
    stage = page.locator(".stage")
    return int(stage.get_attribute("data-trial")), float(stage.get_attribute("data-time"))


def picture(page):
    return page.evaluate("document.querySelector('.stage canvas').toDataURL()")


def wait_for(page, condition):
    page.wait_for_function(f"(() => {{ const {{trial, time}} = document.querySelector('.stage').dataset; "
                           f"return {condition}; }})()", timeout=60_000)


def test_the_hand_moves_until_the_trial_ends(looked_at):
    first, before = picture(looked_at), shown(looked_at)
    wait_for(looked_at, f"time > {before[1]} + 0.3")
    assert picture(looked_at) != first
    wait_for(looked_at, "time > 1.9")
    looked_at.get_by_role("button", name="Play").first.wait_for(timeout=60_000)


def test_it_is_paused_scrubbed_and_played_on(looked_at):
    looked_at.get_by_role("button", name="Pause").first.click()
    looked_at.wait_for_timeout(500)
    stood = shown(looked_at)
    looked_at.wait_for_timeout(500)
    assert shown(looked_at) == stood
    slider = looked_at.get_by_label("Time in the trial")
    slider.fill("100")
    wait_for(looked_at, "Math.abs(time - 0.2) < 0.02")
    assert re.search(r"0\.20", looked_at.locator(".transport .time").inner_text())
    looked_at.get_by_role("button", name="Play").first.click()
    wait_for(looked_at, "time > 0.5")


def test_another_trial_is_chosen(looked_at):
    looked_at.get_by_label("Next trial").click()
    wait_for(looked_at, "trial == '1' && time > 0.1")


def test_it_can_be_used_on_a_narrow_screen(looked_at):
    looked_at.set_viewport_size({"width": 400, "height": 800})
    wide = looked_at.evaluate("document.documentElement.scrollWidth")
    assert wide <= 400
    assert looked_at.locator(".stage canvas").bounding_box()["height"] > 150


def test_a_viewer_that_ends_is_told_of(chromium, source):
    with serving(source) as server:
        context = chromium.new_context()
        page = context.new_page()
        page.goto(server.address)
        page.wait_for_function("document.querySelector('.stage').dataset.time !== undefined", timeout=60_000)
        threading.Thread(target=server.shutdown, daemon=True).start()
        server.ending = True
        server.server_close()
        page.get_by_text("does not answer").wait_for(timeout=60_000)
        context.close()
