"""The page as a whole: folds, colours, paper, small screens, no scripts."""

from dataclasses import replace

import pytest
from browser_parts import until
from made_up_pages import error, page

from fesloop.show.report.parts import Fold, Paragraph, Section, Table

WHITE = "rgb(255, 255, 255)"


def background(shown):
    return shown.evaluate("getComputedStyle(document.body).backgroundColor")


def lightness(colour):
    return sum(int(part) for part in colour.removeprefix("rgb(").removesuffix(")").split(","))


@pytest.mark.slow
def test_what_is_folded_is_drawn_once_it_is_opened(opened):
    shown = opened(page())
    summary = shown.get_by_text("Other joints")
    assert shown.locator("#part-wrist-3").is_hidden()
    summary.focus()
    shown.keyboard.press("Enter")
    shown.locator("#part-wrist-3 .plot svg").wait_for()
    shown.keyboard.press("Enter")
    assert shown.locator("#part-wrist-3").is_hidden()


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_colours_are_the_systems_until_others_are_chosen(opened, scheme):
    shown = opened(page(), scheme=scheme)
    system = background(shown)
    assert (system == WHITE) == (scheme == "light")
    shown.locator("#part-error .plot svg").wait_for()
    stroke = "getComputedStyle(document.querySelector('#part-error [aria-label=line] path')).stroke"
    before = shown.evaluate(stroke)
    other = "dark" if scheme == "light" else "light"
    shown.locator("#theme").select_option(other)
    assert (background(shown) == WHITE) == (other == "light")
    assert (lightness(shown.evaluate(stroke)) > lightness(before)) == (other == "dark")
    shown.locator("#theme").select_option("as the system")
    assert background(shown) == system
    assert shown.evaluate(stroke) == before


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 768, 400])
def test_nothing_is_wider_than_the_screen(opened, width):
    wide = Table(columns=[f"a long name of column {i}" for i in range(12)], rows=[["value"] * 12])
    long = Paragraph(text="x" * 300)
    whole = page()
    sections = [*whole.sections, Section(key="wide", title="Wide", parts=[wide, long])]
    shown = opened(page(title="y" * 120, sections=sections), width=width)
    shown.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
    for key in ("index-3", "heat", "stacked", "wrist-3"):
        shown.locator(f"#part-{key}").scroll_into_view_if_needed()
        shown.locator(f"#part-{key} .plot svg").wait_for()
    assert shown.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.slow
def test_figures_follow_the_width(opened):
    shown = opened(page())
    width = "document.querySelector('#part-error svg')?.clientWidth ?? 0"
    shown.locator("#part-error .plot svg").wait_for()
    wide = shown.evaluate(width)
    shown.set_viewport_size({"width": 400, "height": 800})
    until(shown, f"({width}) < 400")
    assert shown.evaluate(width) < wide


@pytest.mark.slow
def test_on_paper_it_is_light_and_every_figure_of_the_trial_is_there(opened):
    shown = opened(page(), scheme="dark")
    shown.emulate_media(media="print")
    shown.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert background(shown) == WHITE
    figures = shown.locator("[data-part]:visible .plot")
    assert figures.count() == 9
    assert all(figures.nth(i).locator("svg").count() == 1 for i in range(8))
    assert shown.get_by_text("Shown: trial 3.").is_visible()
    assert shown.locator(".transport").is_hidden()
    shown.evaluate("dispatchEvent(new Event('afterprint'))")
    shown.emulate_media(media="screen")
    assert background(shown) != WHITE
    assert len(shown.pdf()) > 20_000


def test_without_scripts_texts_tables_and_drawings_are_there(opened):
    shown = opened(page(), java_script_enabled=False)
    assert "Scripts are off" in shown.locator("header").inner_text()
    assert "(trial 3)" in shown.locator("header").inner_text()
    for seen in ("table", "#part-wiring svg", ".sentence", "h2 >> nth=4"):
        assert shown.locator(seen).is_visible()
    shown.locator("summary", has_text="Experiment").click()
    assert shown.get_by_text("[block.hand]").is_visible()
    assert shown.locator(".bar").is_hidden()


@pytest.mark.slow
def test_the_contents_lead_to_their_sections(opened):
    shown = opened(page())
    entry = shown.get_by_role("link", name="Shares")
    entry.click()
    until(shown, "document.querySelector('.contents [aria-current]')?.textContent === 'Shares'")
    top = shown.locator("#shares h2").bounding_box()["y"]
    assert 50 < top < 200


@pytest.mark.slow
def test_each_control_is_reached_by_the_tab_key_and_has_a_name(opened):
    shown = opened(page())
    reached = set()
    for _ in range(40):
        shown.keyboard.press("Tab")
        reached.add(shown.evaluate("""() => {
            const at = document.activeElement;
            return at.labels?.[0]?.textContent || at.getAttribute("aria-label") || at.textContent.trim();
        }"""))
        outline = shown.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline != "none" or shown.evaluate("document.activeElement === document.body")
    assert {"To the result", "Trial", "Trial before", "Play", "Colours", "Reset view", "Time in the trial",
            "Speed", "Other joints", "Experiment"} <= reached
    assert any("hand" in name for name in reached)


def test_a_page_without_trials_and_hand_has_neither_chooser_nor_play(opened):
    shown = opened(page(trials=(), shown=0, sections=[Section(key="a", title="a", parts=[
        error(), Fold(title="b", parts=[])])]))
    shown.locator("#part-error .plot svg").wait_for()
    assert shown.locator("#trial").count() == 0
    assert shown.get_by_role("button", name="Play").count() == 0
    assert shown.locator("#theme").is_visible()


def test_texts_that_would_like_to_be_markup_do_nothing(opened):
    name = "</script><script>document.title = 1</script><img src=x onerror=\"document.title = 1\">"
    chart = replace(error(), title=name, x_label=name, y_label=name, text=name,
                    lines=[replace(error().lines[0], name=name), replace(error().lines[0], name=name)])
    shown = opened(page(title=name, sections=[Section(key="a", title=name, parts=[chart])]))
    shown.locator("#part-error .plot svg").wait_for()
    shown.locator("#part-error [aria-label=dot] circle").first.hover(force=True)
    assert shown.locator("img").count() == 0
    assert shown.title() == name
