"""The page of `fesloop view` in a browser: frames arrive and are drawn, and its controls are heard."""

import re
import threading
import time
from pathlib import Path

import pytest
from view_parts import serving

from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run
from fesloop.show.view.sources import open_recording

GRASP = str(Path(__file__).parents[2] / "picture" / "grasp.toml")
TRIAL_S = 2.0
_READBACK = "GPU stall due to ReadPixels"


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    settings = ["experiment.trials=2", f"experiment.duration_s={TRIAL_S}"]
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
        wait_for(page, lambda trial, at_s: True)
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
    """Until a frame of a trial and time that fulfil the condition is drawn.

    (Playwright's own waiting evaluates texts, which the page's policy forbids.)
    """
    until = time.monotonic() + 60.0
    while page.locator(".stage").get_attribute("data-time") is None or not condition(*shown(page)):
        assert time.monotonic() < until, page.locator("#note").inner_text()
        page.wait_for_timeout(30)


def play_slowly_from(page, share):
    """At a tenth of the speed, so that a slow machine sees it too; from a thousandth of the trial on."""
    button = page.locator(".transport").get_by_role("button", name=re.compile("^(Play|Pause)$"))
    while button.get_attribute("aria-label") == "Pause":  # at the end of the trial it is paused by itself
        button.click()
    page.get_by_label("Speed").select_option("0.1")
    page.get_by_label("Time in the trial").fill(str(share))
    wait_for(page, lambda trial, at_s: abs(at_s - share * TRIAL_S / 1000) < 0.02)
    button.click()


@pytest.mark.slow
def test_the_hand_moves_until_the_trial_ends(looked_at):
    play_slowly_from(looked_at, 0)
    wait_for(looked_at, lambda trial, at_s: at_s < 1.0)
    first, before = picture(looked_at), shown(looked_at)
    wait_for(looked_at, lambda trial, at_s: at_s > before[1] + 0.1)
    assert picture(looked_at) != first
    play_slowly_from(looked_at, 950)
    wait_for(looked_at, lambda trial, at_s: at_s > 1.98)
    looked_at.locator(".transport").get_by_role("button", name="Play").wait_for(timeout=60_000)


@pytest.mark.slow
def test_it_is_paused_scrubbed_and_played_on(looked_at):
    play_slowly_from(looked_at, 500)
    looked_at.locator(".transport").get_by_role("button", name="Pause").click()
    looked_at.wait_for_timeout(500)
    stood = shown(looked_at)
    looked_at.wait_for_timeout(500)
    assert shown(looked_at) == stood
    looked_at.get_by_label("Time in the trial").fill("100")
    wait_for(looked_at, lambda trial, at_s: abs(at_s - 0.2) < 0.02)
    assert re.search(r"0\.20", looked_at.locator(".transport .time").inner_text())
    looked_at.locator(".transport").get_by_role("button", name="Play").click()
    wait_for(looked_at, lambda trial, at_s: at_s > 0.25)


@pytest.mark.slow
def test_another_trial_is_chosen(looked_at, source):
    other = 1 - source.shown
    looked_at.get_by_label("Next trial" if other else "Trial before").click()
    wait_for(looked_at, lambda trial, at_s: trial == other and at_s > 0.1)


@pytest.mark.browser
def test_angles_and_stimulation_stand_below_the_hand(looked_at, source):
    play_slowly_from(looked_at, 100)
    wait_for(looked_at, lambda trial, at_s: at_s > 0.3)
    readout = looked_at.locator("#readout")
    assert re.fullmatch(rf"Trial {source.shown}, \d\.\d\d s", readout.locator("h2").inner_text())
    assert readout.locator("table").count() == len(source.readout.groups) + (source.readout.channels > 0)
    assert re.fullmatch(r"−?\d+\.\d", readout.locator("tbody td").first.inner_text())


@pytest.mark.slow
def test_it_can_be_used_on_a_narrow_screen(looked_at):
    looked_at.set_viewport_size({"width": 400, "height": 800})
    wide = looked_at.evaluate("document.documentElement.scrollWidth")
    assert wide <= 400
    assert looked_at.locator(".stage canvas").bounding_box()["height"] > 150


@pytest.mark.slow
def test_it_stands_still_for_who_wants_less_motion_until_it_is_played(chromium, source):
    with serving(source) as server:
        context = chromium.new_context(reduced_motion="reduce")
        page = context.new_page()
        page.goto(server.address)
        wait_for(page, lambda trial, at_s: True)
        page.wait_for_timeout(500)
        assert shown(page) == (source.shown, 0.0)
        page.locator(".transport").get_by_role("button", name="Play").click()
        wait_for(page, lambda trial, at_s: at_s > 0.1)
        context.close()


@pytest.mark.slow
def test_what_changes_all_the_time_is_not_read_aloud_and_a_fault_is(chromium, source):
    with serving(source) as server:
        context = chromium.new_context()
        page = context.new_page()
        page.goto(server.address)
        wait_for(page, lambda trial, at_s: True)
        for output in page.locator("output.time").all():
            assert output.get_attribute("aria-live") == "off"
        threading.Thread(target=server.shutdown, daemon=True).start()
        server.ending = True
        server.server_close()
        page.get_by_text("does not answer").wait_for(timeout=60_000)
        assert page.locator("#note").get_attribute("aria-live") == "polite"
        context.close()


@pytest.mark.slow
def test_a_viewer_that_ends_is_told_of(chromium, source):
    with serving(source) as server:
        context = chromium.new_context()
        page = context.new_page()
        page.goto(server.address)
        wait_for(page, lambda trial, at_s: True)
        threading.Thread(target=server.shutdown, daemon=True).start()
        server.ending = True
        server.server_close()
        page.get_by_text("does not answer").wait_for(timeout=60_000)
        context.close()
