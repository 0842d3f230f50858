"""The moving hand: it plays, is scrubbed, turned, and chosen by trial."""

import re
from dataclasses import replace

import numpy as np
import pytest
from browser_parts import until
from made_up_pages import FRAMES, STEP_S, hand, page

from fesloop.show.report.parts import Section

LAST_S = (FRAMES - 1) * STEP_S
_WINDOWS, _WINDOW_MS = 6, 1500
"""How often the frame rate is measured at most (other tests share the machine), and how long."""


@pytest.fixture
def shown(opened):
    """The made-up page with its hand in view."""
    found = opened(page())
    found.locator(".stage").scroll_into_view_if_needed()
    still(found)
    return found


def still(shown):
    """Wait until the scene stands, and what was drawn coarsely (on a slow machine) is drawn finely again."""
    before = None
    while before != (before := frames(shown)):
        shown.wait_for_timeout(500)
    until(shown, "(([canvas]) => canvas.width === canvas.clientWidth)(document.querySelectorAll('canvas'))")


def pixels(shown):
    """The canvas as it is."""
    still(shown)
    return shown.evaluate("document.querySelector('.stage canvas').toDataURL()")


def comes(shown, picture):
    """Whether the canvas becomes a picture: a busy browser draws it late."""
    for _ in range(50):
        if pixels(shown) == picture:
            return True
        shown.wait_for_timeout(100)
    return False


def time_s(shown):
    """Time at the play head."""
    return float(re.match(r"[\d.]+", shown.locator(".transport .time").inner_text())[0])


def frames(shown):
    return int(shown.locator(".stage").get_attribute("data-frames"))


@pytest.mark.slow
def test_the_hand_is_drawn(shown):
    colours = shown.evaluate("""() => {
        const canvas = document.querySelector('.stage canvas');
        const {width, height} = canvas;
        const flat = Object.assign(document.createElement('canvas'), {width, height});
        const context = flat.getContext('2d');
        context.drawImage(canvas, 0, 0);
        const seen = new Set();
        const {data} = context.getImageData(0, 0, flat.width, flat.height);
        let filled = 0;
        for (let i = 0; i < data.length; i += 4) {
            if (data[i + 3] > 0) filled += 1;
            seen.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
        }
        return {colours: seen.size, share: filled / (flat.width * flat.height)};
    }""")
    assert colours["colours"] > 100
    assert colours["share"] > 0.03


@pytest.mark.slow
def test_it_plays_at_ten_frames_a_second_or_more_and_stops_at_the_end(shown):
    shown.locator(".transport select").select_option("0.1")
    shown.locator(".transport .play").click()
    rates = []
    while len(rates) < _WINDOWS and max(rates, default=0.0) < 10.0:
        before = frames(shown)
        shown.wait_for_timeout(_WINDOW_MS)
        rates.append((frames(shown) - before) / _WINDOW_MS * 1000)
    assert max(rates) >= 10.0, rates
    assert 0.1 * len(rates) * _WINDOW_MS / 1000 * 0.8 < time_s(shown) < LAST_S
    shown.locator(".transport select").select_option("2")
    shown.get_by_role("button", name="Play").first.wait_for(timeout=10_000)
    assert time_s(shown) == LAST_S


@pytest.mark.slow
def test_it_pauses_and_both_buttons_tell(shown):
    shown.locator(".transport .play").click()
    assert shown.get_by_role("button", name="Pause").count() == 2
    shown.locator(".bar .play").click()
    assert shown.get_by_role("button", name="Play", exact=True).count() == 2
    before = time_s(shown)
    shown.wait_for_timeout(300)
    assert time_s(shown) == before


@pytest.mark.slow
def test_space_plays_and_pauses_where_the_hand_has_the_focus(shown):
    shown.locator(".stage").focus()
    shown.keyboard.press("Space")
    assert shown.get_by_role("button", name="Pause").count() == 2
    shown.keyboard.press("Space")
    assert shown.get_by_role("button", name="Pause").count() == 0


@pytest.mark.slow
def test_it_is_scrubbed_by_the_keyboard(shown):
    first = pixels(shown)
    slider = shown.get_by_role("slider", name="Time in the trial")
    slider.press("End")
    assert time_s(shown) == LAST_S
    assert slider.get_attribute("aria-valuetext") == "2.00 s of 2.00 s"
    last = pixels(shown)
    assert last != first
    slider.press("Home")
    assert time_s(shown) == 0.0
    assert pixels(shown) == first


@pytest.mark.slow
def test_it_is_turned_by_the_mouse_and_the_keyboard_and_set_back(shown):
    first = pixels(shown)
    box = shown.locator(".stage").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    shown.mouse.move(*middle)
    shown.mouse.down()
    shown.mouse.move(middle[0] + 80, middle[1] + 30, steps=3)
    shown.mouse.up()
    turned = pixels(shown)
    assert turned != first
    shown.mouse.move(middle[0], middle[1])
    assert pixels(shown) == turned
    shown.get_by_role("button", name="Reset view").click()
    assert pixels(shown) == first
    shown.locator(".stage").press("ArrowLeft")
    assert pixels(shown) not in (first, turned)
    shown.locator(".stage").press("Home")
    assert pixels(shown) == first
    shown.locator(".stage").press("+")
    assert pixels(shown) != first


@pytest.mark.slow
def test_each_hand_can_be_left_out(shown):
    both = pixels(shown)
    boxes = shown.locator(".tools input")
    boxes.nth(1).uncheck()
    truth = pixels(shown)
    boxes.nth(0).uncheck()
    neither = pixels(shown)
    assert len({both, truth, neither}) == 3
    boxes.nth(0).check()
    assert pixels(shown) == truth


@pytest.mark.slow
def test_another_trial_moves_as_it_did(shown):
    shown.get_by_role("slider", name="Time in the trial").press("End")
    third = pixels(shown)
    shown.locator("#trial").select_option("1")
    assert time_s(shown) == 0.0
    shown.get_by_role("slider", name="Time in the trial").press("End")
    assert pixels(shown) != third


@pytest.mark.slow
def test_scrolled_past_it_stands_small_at_the_side(shown):
    wide = shown.locator(".stage").bounding_box()["width"]
    shown.locator("#what").scroll_into_view_if_needed()
    until(shown, "document.querySelector('.stage').classList.contains('docked')")
    box = shown.locator(".stage").bounding_box()
    assert box["width"] < wide / 3
    assert 0 <= box["y"] < 900


@pytest.mark.slow
def test_a_trial_whose_motion_is_not_there_is_said_so(opened):



    whole = hand()
    found = opened(page(sections=[Section(key="motion", title="The hand", parts=[
        replace(whole, trials={trial: whole.trials[trial] for trial in (2, 3)})])]))
    assert found.locator(".gone").is_hidden()
    found.locator("#trial").select_option("1")
    assert found.locator(".gone").is_visible()
    found.locator("#trial").select_option("2")
    assert found.locator(".gone").is_hidden()


@pytest.mark.slow
@pytest.mark.parametrize("moves", [True, False])
@pytest.mark.parametrize("width", [1280, 400])
def test_the_camera_holds_what_is_far_from_the_hand(opened, width, moves):
    """A cup half a metre beside the hand, which comes to it in the third trial's last frames alone."""
    whole = hand()
    cup = np.tile([1.0, 0.0, 0.0, 0.0, 0.5, -0.1, 0.0], (FRAMES, 1, 1))
    cup[-3:, 0, 4:] = 0.1
    (solid,) = whole.objects
    frames = replace(whole.trials[3], objects=cup if moves else cup[:, :0])
    figure = replace(whole, trials={3: frames},
                     objects=[solid if moves else replace(solid, moves=False, pose=tuple(cup[0, 0]))])
    shown = opened(page(sections=[Section(key="motion", title="The hand", parts=[figure])], trials=(),
                        shown=3), width=width)
    shown.locator(".stage").scroll_into_view_if_needed()
    assert inside(shown)
    boxes = shown.locator(".tools input")
    for i in (0, 1):
        boxes.nth(i).uncheck()
    assert inside(shown)
    shown.get_by_role("slider", name="Time in the trial").press("End")
    assert inside(shown)


def inside(shown):
    """Whether something is drawn, and nothing of it at the picture's edge."""
    still(shown)
    return shown.evaluate("""() => {
        const canvas = document.querySelector('.stage canvas');
        const {width, height} = canvas;
        const flat = Object.assign(document.createElement('canvas'), {width, height});
        const context = flat.getContext('2d');
        context.drawImage(canvas, 0, 0);
        const {data} = context.getImageData(0, 0, width, height);
        let seen = 0, edge = 0;
        for (let i = 0; i < width * height; i += 1) {
            if (data[4 * i + 3] === 0) continue;
            seen += 1;
            const [x, y] = [i % width, Math.floor(i / width)];
            if (x < 2 || y < 2 || x >= width - 2 || y >= height - 2) edge += 1;
        }
        return seen > 100 && edge === 0;
    }""")


@pytest.mark.slow
def test_a_cup_that_falls_far_does_not_make_the_hand_small(opened):
    whole = hand()
    (solid,) = whole.objects
    fallen = np.tile([1.0, 0.0, 0.0, 0.0, 0.1, 0.1, 0.0], (FRAMES, 1, 1))
    fallen[:, 0, 6] = -np.linspace(0.0, 20.0, FRAMES)
    figure = replace(whole, objects=[solid], trials={3: replace(whole.trials[3], objects=fallen)})
    shown = opened(page(sections=[Section(key="motion", title="The hand", parts=[figure])], trials=(),
                        shown=3))
    shown.locator(".stage").scroll_into_view_if_needed()
    still(shown)
    share = shown.evaluate("""() => {
        const canvas = document.querySelector('.stage canvas');
        const {width, height} = canvas;
        const flat = Object.assign(document.createElement('canvas'), {width, height});
        const context = flat.getContext('2d');
        context.drawImage(canvas, 0, 0);
        const {data} = context.getImageData(0, 0, width, height);
        const filled = data.filter((_, i) => i % 4 === 3).reduce((sum, alpha) => sum + (alpha > 0), 0);
        return filled / (width * height);
    }""")
    assert share > 0.005


@pytest.mark.slow
def test_one_finger_turns_and_two_zoom(opened):
    shown = opened(page(), width=400, has_touch=True)
    shown.locator(".stage").scroll_into_view_if_needed()
    first = pixels(shown)
    box = shown.locator(".stage").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch = shown.context.new_cdp_session(shown)

    def put(kind, *points):
        places = [{"x": a, "y": b} for a, b in points]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})

    def moved(*ways):
        put("touchStart", *(way[0] for way in ways))
        for step in (0.25, 0.5, 0.75, 1.0):
            put("touchMove", *((a + step * (c - a), b + step * (d - b)) for (a, b), (c, d) in ways))
        put("touchEnd")
        return pixels(shown)

    turned = moved(((x - 60, y), (x + 60, y)))
    assert turned != first
    shown.get_by_role("button", name="Reset view").tap()
    assert comes(shown, first)
    assert moved(((x - 20, y), (x - 90, y)), ((x + 20, y), (x + 90, y))) not in (first, turned)
