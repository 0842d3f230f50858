"""The wiring drawn: every block and every latency is there, inside, and readable."""

from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.experiment.files.parse import load
from fesloop.experiment.specification import with_transport
from fesloop.loop.duration import Duration
from fesloop.show.report.run.experiment import _wire_row, wiring_svg

SVG = "{http://www.w3.org/2000/svg}"
NAMES = st.lists(st.sampled_from("abcdefgh"), min_size=1, unique=True)


def drawn(name):
    document = load(name).document()
    rates = {"tracker": "100 Hz"}
    document["wires"] = [with_transport(wire, document) for wire in document["wires"]]
    return document, ElementTree.fromstring(wiring_svg(document["blocks"], document["wires"], rates))


def boxes(root):
    return [tuple(float(each.get(key)) for key in ("x", "y", "width", "height"))
            for each in root.iter(f"{SVG}rect") if "stroke-plain" in each.get("class")]


@pytest.mark.parametrize("name", ["grasp_ilc", "finger_ilc", "tracker_hour"])
def test_all_of_it_is_there(name):
    document, root = drawn(name)
    texts = [each.text for each in root.iter(f"{SVG}text")]
    assert set(document["blocks"]) <= set(texts)
    assert any("100 Hz" in text for text in texts) == ("tracker" in document["blocks"])
    late = {f"{wire['latency_ms']:g} ms" for wire in document["wires"] if wire["latency_ms"]}
    assert late <= set(texts)
    pairs = {(wire["from"].split(".")[0], wire["to"].split(".")[0]) for wire in document["wires"]}
    assert len(list(root.iter(f"{SVG}polygon"))) == len(pairs)


@pytest.mark.parametrize(("jitter", "told"), [
    ({"kind": "zero"}, False), ({"kind": "uniform", "low_ms": 0.0, "high_ms": 0.0}, False),
    ({"kind": "uniform", "low_ms": -2.0, "high_ms": 0.0}, True),
    ({"kind": "exponential", "mean_ms": 3.0, "high_ms": 9.0}, True)])
def test_a_jitter_is_told_where_there_is_some(jitter, told):
    wires = [{"from": "a.out", "to": "b.in", "latency_ms": 10.0, "jitter": jitter}]
    root = ElementTree.fromstring(wiring_svg({"a": {"kind": "pid"}, "b": {"kind": "safety"}}, wires, {}))
    assert ("+ jitter" in [each.text for each in root.iter(f"{SVG}text")]) == told
    latency = _wire_row(wires[0])[2]
    assert latency == (f"10 ms + {jitter['kind']} jitter of {Duration(**jitter)}" if told else "10 ms")


@pytest.mark.parametrize("name", ["grasp_ilc", "finger_ilc"])
def test_blocks_stand_apart_and_inside(name):
    _, root = drawn(name)
    wide, high = (float(each) for each in root.get("viewBox").split()[2:])
    found = boxes(root)
    for i, (x, y, width, height) in enumerate(found):
        assert x >= 0.0
        assert x + width <= wide
        assert y >= 0.0
        assert y + height <= high
        for other in found[i + 1:]:
            apart = x + width <= other[0] or other[0] + other[2] <= x
            assert apart or y + height <= other[1] or other[1] + other[3] <= y


def test_it_is_readable_on_a_telephone():
    _, root = drawn("grasp_ilc")
    wide = float(root.get("viewBox").split()[2])
    sizes = [float(each.get("font-size")) for each in root.iter(f"{SVG}text")]
    assert min(sizes) * min(1.0, 360.0 / wide) >= 8.0  # pixels: below that letters run together


@given(NAMES, st.data())
def test_any_wiring_is_drawn(names, data):
    ends = st.tuples(st.sampled_from(names), st.sampled_from(["stimulation", "angles"])).map(".".join)
    latency, loss = st.sampled_from([0.0, 10.0]), st.sampled_from([0.0, 0.1])
    wires = data.draw(st.lists(st.fixed_dictionaries(
        {"from": ends, "to": ends, "latency_ms": latency, "loss": loss}), max_size=12))
    blocks = {name: {"kind": "<&>", "execution": {}} for name in names}
    root = ElementTree.fromstring(wiring_svg(blocks, wires, {}))
    assert set(names) <= {each.text for each in root.iter(f"{SVG}text")}
