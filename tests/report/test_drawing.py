import pytest
from made_up_pages import drawing

from fesloop.show.report.page import checked_svg

_GOOD = '<svg viewBox="0 0 9 9"><defs><marker id="arrow"><path d="M0 0"/></marker></defs>{}</svg>'


@pytest.mark.parametrize("inside", [
    "", "<!-- said -->", '<line class="faint" x2="9" marker-end="url(#arrow)"/>', "<text>a &lt; b</text>",
    '<use href="#arrow"/>', '<g><title>tracker</title><circle r="2"/></g>'])
def test_shapes_and_texts_stay_as_they_are(inside):
    svg = _GOOD.format(inside)
    assert checked_svg(drawing(svg)) == svg


@pytest.mark.parametrize("inside", [
    "<script>alert(1)</script>", '<rect onclick="alert(1)"/>', '<rect ONCLICK="alert(1)"/>',
    '<a href="https://example.org"/>', '<use href="https://example.org/a.svg#b"/>', "<style>* {}</style>",
    '<use xmlns:xlink="http://www.w3.org/1999/xlink" xlink:href="other.svg#b"/>',
    '<rect fill="url(https://example.org/a)"/>', '<foreignObject><iframe/></foreignObject>',
    '<image href="#a"/>', '<rect style="fill: url( https://example.org )"/>',
    '<animate attributeName="href"/>'])
def test_what_could_run_or_ask_is_refused(inside):
    with pytest.raises(ValueError, match="which a page does not take"):
        checked_svg(drawing(_GOOD.format(inside)))


@pytest.mark.parametrize("svg", [
    "", "<svg viewBox='0 0 1 1'>", "<p/>", "<svg/>", "<svg viewBox='0 0 1 1'/><p/>"])
def test_what_is_not_one_svg_with_a_view_box_is_refused(svg):
    with pytest.raises(ValueError, match="drawing 'wiring' is not"):
        checked_svg(drawing(svg))
