"""A snapshot goes into a loop of the same parameters only, whatever the parameters are."""

from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_parts import Memory, Pass, Source
from numba import njit

from fesloop.errors import SnapshotError
from fesloop.experiment.recording.writing import timed
from fesloop.loop.nodes import Node
from fesloop.loop.run import Loop, changed, parameter_digests
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring


@dataclass(frozen=True, kw_only=True, eq=False)
class Part:
    """Parameters of every kind, and one that follows from them."""

    number: float = 1.0
    numbers: tuple[float, ...] = (1.0, 2.0)
    array: Any = field(default_factory=lambda: np.arange(6.0).reshape(2, 3))
    table: Any = field(default_factory=lambda: {"a": 1.0, "b": (2.0,)})
    inner: Any = field(default_factory=Pass)
    words: frozenset[str] = frozenset({"x", "y"})
    derived: Any = field(init=False, default=None)

    inputs = ()
    outputs = ()

    def init(self, context):
        return Memory()

    def step(self, state, inputs, tick):
        return ()


OTHERS = {"number": 0.5, "numbers": (1.0, 2.5), "array": np.arange(6.0), "table": {"a": 1.0, "b": (2.5,)},
          "inner": Pass(gain=2.0), "words": frozenset({"x", "z"})}


def loop_of(part):
    return Loop(Wiring([Node("other", Pass(names=()), rate="10"), Node("part", part, rate="10")], []))


@given(st.sets(st.sampled_from(sorted(OTHERS))))
@settings(max_examples=20, deadline=None)
def test_a_snapshot_of_other_parameters_is_refused_by_their_names(names):
    snapshot = loop_of(Part()).snapshot()
    other = loop_of(replace(Part(), **{name: OTHERS[name] for name in names}))
    told = ", ".join(each.name for each in fields(Part) if each.name in names)
    if names:
        with pytest.raises(SnapshotError) as caught:
            other.restore(snapshot)
        assert str(caught.value).startswith(f"part: the snapshot was made with other parameters ({told})")
    else:
        other.restore(snapshot)
    other.run_until(200_000_000)


def test_every_kind_of_value_is_known_by_what_it_holds():
    assert not changed(parameter_digests(Part()), parameter_digests(Part()))
    for name, value in OTHERS.items():
        made = [parameter_digests(replace(Part(), **{name: value})) for _ in range(2)]
        assert not changed(*made)
        assert changed(made[0], parameter_digests(Part())) == [name]


@pytest.mark.slow
@given(st.recursive(st.floats() | st.integers() | st.text() | st.fractions(),
                    lambda inner: st.lists(inner).map(tuple) | st.dictionaries(st.text(), inner)))
@settings(max_examples=50, deadline=None)
def test_equal_numbers_are_the_same_whatever_their_type(value):
    one, same = parameter_digests(Part(number=value)), parameter_digests(Part(number=value))
    assert not changed(one, same)
    assert changed(one, parameter_digests(Part(number=(value, 1.0)))) == ["number"]


def scaled(factor, power=1):
    return lambda value, offset=power: factor * value + offset


def counted(start):
    def count(value):
        return count(value - 1) + start if value else 0
    return count


SAME_NAME = {  # by what kind of value: functions that differ in one thing, and have one name
    "closure": lambda number: scaled(number), "default": lambda number: scaled(2.0, number),
    "recursive": lambda number: counted(number), "partial": lambda number: partial(scaled, number),
    "method": lambda number: Pass(gain=number).step, "nested": lambda number: partial(map, scaled(number)),
    "body": lambda number: eval(f"lambda value: value + {number!r}"),
    "called": lambda number: eval(f"lambda value: value.f{abs(hash(number))}()"),
    "compiled": lambda number: njit(scaled(number)), "in C": lambda number: np.full(3, number).dot}


@pytest.mark.parametrize("form", SAME_NAME)
@given(one=st.floats(-1e3, 1e3), other=st.floats(-1e3, 1e3))
@settings(max_examples=15, deadline=None)
def test_functions_of_one_name_are_told_apart_by_what_they_do(form, one, other):
    before, again, now = (parameter_digests(Part(number=SAME_NAME[form](number)))
                          for number in (one, one, other))
    assert not changed(before, again)
    assert bool(changed(before, now)) == (one != other)


def test_a_snapshot_is_refused_where_a_function_is_another():
    snapshot = loop_of(Part(number=scaled(1.0))).snapshot()
    loop_of(Part(number=scaled(1.0))).restore(snapshot)
    with pytest.raises(SnapshotError, match=r"part: .* \(number\)"):
        loop_of(Part(number=scaled(2.0))).restore(snapshot)


def test_one_is_one():
    for one in (1, 1.0, np.float64(1.0), Fraction(1)):
        assert not changed(parameter_digests(Part(number=one)), parameter_digests(Part(number=1.0)))


def test_what_follows_from_parameters_is_none():
    part = Part()
    object.__setattr__(part, "derived", np.ones(3))
    assert not changed(parameter_digests(part), parameter_digests(Part()))


def test_a_timed_block_has_the_parameters_of_its_block():
    def wiring(gain):
        nodes = [Node("source", Source(), rate="10"), Node("gain", Pass(gain=gain), rate="10")]
        return timed(Wiring(nodes, [Wire("source.y", "gain.u")]), ["gain"])[0]

    loop = Loop(wiring(1.0))
    loop.run_until(500_000_000)
    Loop(wiring(1.0)).restore(loop.snapshot())
    with pytest.raises(SnapshotError, match=r"gain: .* \(gain\)"):
        Loop(wiring(2.0)).restore(loop.snapshot())
