"""How an FMU's variables become ports."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.loop.nodes import Node
from fesloop.loop.wiring import Wiring
from plants.fmu.description import FmuDescription, FmuVariable
from plants.fmu.ports import FmuPort, bind_ports


def described(*variables):
    return FmuDescription(
        version=2, interface="co_simulation", identifier="m", token="t",
        variables={v.name: v for v in variables}, states=0, indicators=0, completes_steps=False, saves=False,
        once=False, needs_tool=False, internal_step_s=0.0, has_sources=False)


def variable(name, unit="1", start=math.nan, shape=(), kind="Real"):
    return FmuVariable(name, 0, kind, "input", "continuous", shape, unit, start)


shapes = st.lists(st.integers(1, 4), min_size=1, max_size=3).map(tuple)


@given(shape=shapes, base=st.integers(0, 1), order=st.randoms(use_true_random=False))
def test_a_full_set_of_indices_makes_one_port(shape, base, order):
    indices = list(np.ndindex(shape))
    names = ["u[" + ",".join(str(i + base) for i in index) + "]" for index in indices]
    shuffled = names.copy()
    order.shuffle(shuffled)
    (port,) = bind_ports(described(*map(variable, shuffled)), "input", (), "input_ports")
    assert port.port.shape == shape
    assert [v.name for v in port.variables] == names


@pytest.mark.parametrize("names", [
    ("u[1]", "u[3]"), ("u[2]", "u[3]"), ("u[1,1]", "u[2,2]"), ("u[1]", "u[1,2]"), ("u[0]", "u[2]")])
def test_a_gap_in_the_indices_leaves_scalars(names):
    ports = bind_ports(described(*map(variable, names)), "input", (), "input_ports")
    assert [port.port.shape for port in ports] == [(), ()]
    assert [port.variables[0].name for port in ports] == list(names)


def test_units_by_column_and_start_values():
    variables = [variable(f"stimulation[{m},{c}]", unit, start) for m in (1, 2)
                 for c, unit, start in ((1, "A", 0.01), (2, "s", 2e-4))]
    (bound,) = bind_ports(described(*variables), "input", (), "input_ports")
    assert bound.port.unit == "A,s"
    np.testing.assert_array_equal(bound.port.initial_value(), [[0.01, 2e-4], [0.01, 2e-4]])


def test_names_become_identifiers_and_text_is_left_out():
    ports = bind_ports(
        described(variable("body.joint[1].phi"), variable("1st"), variable("label", kind="String")),
        "input", (), "input_ports")
    assert [port.port.name for port in ports] == ["body_joint_1_phi", "v_1st"]


def test_columns_have_scales_of_their_own():
    variables = [variable(f"{name}.{what}", start=start) for name in "ef"
                 for what, start in (("ma", 10.0), ("us", 200.0))]
    wanted = FmuPort(name="u", variables=tuple(v.name for v in variables), shape=(2, 2), unit="A,s",
                     scale=(1e3, 1e6))
    (bound,) = bind_ports(described(*variables), "input", (wanted,), "input_ports")
    assert bound.scales == (1e3, 1e6, 1e3, 1e6)
    np.testing.assert_allclose(bound.port.initial_value(), [[0.01, 2e-4], [0.01, 2e-4]])


@pytest.mark.parametrize(("port", "words"), [
    (FmuPort(name="a", variables=("x",), scale=(1.0, 2.0)), "2 scales; allowed: one, or 1"),
    (FmuPort(name="a", variables=("x",), scale=()), "0 scales"),
    (FmuPort(name="a b", variables=("x",)), "name"), (FmuPort(name="a", variables=()), "shape"),
    (FmuPort(name="a", variables=("z",)), "no numeric input"),
    (FmuPort(name="a", variables=("x",), scale=0.0), "scale")])
def test_declarations_that_do_not_fit(port, words):
    with pytest.raises(InputError, match=words):
        bind_ports(described(variable("x")), "input", (port,), "input_ports")


def test_a_table_is_no_port_in_python():
    with pytest.raises(InputError, match=r"input_ports\[0\]: is a dict; allowed: an FmuPort of plants\.fmu"):
        bind_ports(described(variable("x")), "input", ({"name": "a", "variables": ["x"]},), "input_ports")


def test_an_input_without_a_wire_may_be_left_out(small2):
    from plants.fmu import Fmu
    from plants.fmu import FmuPort as FromPackage

    assert FromPackage is FmuPort
    with pytest.raises(InputError, match=r"no wire; .*or omit it from input_ports"):
        Wiring([Node("tank", Fmu(path=str(small2())))], [])
