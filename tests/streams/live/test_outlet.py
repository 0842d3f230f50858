"""What an outlet takes and calls its channels; nothing here opens one."""

import numpy as np
import pytest
from streams_live_parts import tick_at

from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.signals import Sample
from fesloop.streams.live.events import LslEvents
from fesloop.streams.live.outlet import LslOutlet


def test_channels_are_named_by_row_and_column_with_units():
    pulses = LslOutlet(stream="s", unit="A,s", columns=2, column_labels=("current", "width"))
    assert pulses.resolve({"values": (2, 2)}).channels() == (
        ("0 current", "A"), ("0 width", "s"), ("1 current", "A"), ("1 width", "s"))
    points = LslOutlet(stream="s", unit="m", columns=3, rows=1, labels=("F1",), column_labels=("x", "y", "z"))
    assert points.channels() == (("F1 x", "m"), ("F1 y", "m"), ("F1 z", "m"))
    angles = LslOutlet(stream="s", unit="rad", rows=2, labels=("mcp", "pip"))
    assert angles.channels() == (("mcp", "rad"), ("pip", "rad"))


@pytest.mark.parametrize(("outlet", "shape"), [
    (LslOutlet(stream="s"), (2, 2)), (LslOutlet(stream="s", columns=2), (3,)),
    (LslOutlet(stream="s", columns=2), (3, 4)), (LslOutlet(stream="s"), ())])
def test_another_shape_is_refused(outlet, shape):
    with pytest.raises(InputError, match="values: a signal of shape"):
        outlet.resolve({"values": shape})


@pytest.mark.parametrize(("parameters", "named"), [
    ({"stream": ""}, "stream"), ({"stream": "s", "rows": -1}, "rows"),
    ({"stream": "s", "columns": -1}, "columns"),
    ({"stream": "s", "rows": 2, "labels": ("a",)}, "labels"),
    ({"stream": "s", "columns": 2, "column_labels": ("a",)}, "column_labels"),
    ({"stream": "s", "labels": ("a", "b", "a")}, "labels: a name is listed twice"),
    ({"stream": "s", "columns": 2, "column_labels": ("a", "a")}, "column_labels: a name is listed twice")])
def test_what_cannot_be_is_refused(parameters, named):
    with pytest.raises(InputError, match=named):
        LslOutlet(**parameters)


def test_labels_must_be_as_many_as_what_is_wired_in():
    with pytest.raises(InputError, match="labels"):
        LslOutlet(stream="s", labels=("a",)).resolve({"values": (2,)})


@pytest.mark.parametrize("block", [LslOutlet(stream="s", rows=2), LslEvents(stream="s")])
def test_stand_ins_take_the_same_and_send_nothing(block):
    stand_in = block.stand_in()
    assert (stand_in.inputs, stand_in.outputs) == (block.inputs, ())
    state = stand_in.init(Context("outlet"))
    assert stand_in.step(state, (Sample(np.zeros(2), 0, 0, 0),), tick_at(0)) == ()


def test_events_need_a_name():
    with pytest.raises(InputError, match="stream"):
        LslEvents(stream="")
