"""Units of declared ports against those of the FMU: converted as it defines them, or refused."""

import math
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import constants

from fesloop.errors import InputError
from fesloop.loop.block import Context
from plants.fmu import Fmu
from plants.fmu.description import POWERS, BaseUnit, FmuDescription, FmuVariable
from plants.fmu.ports import FmuPort, bind_ports

# Truth: SI value of 1 and of 0 of a port's unit, and its powers (SI brochure, SciPy).
PORT_UNITS = {
    "rad": (1.0, 0.0, {"rad": 1}), "deg": (constants.degree, 0.0, {"rad": 1}),
    "deg/s": (constants.degree, 0.0, {"rad": 1, "s": -1}), "rad/s^2": (1.0, 0.0, {"rad": 1, "s": -2}),
    "m/s^2": (1.0, 0.0, {"m": 1, "s": -2}), "mm": (constants.milli, 0.0, {"m": 1}),
    "N": (1.0, 0.0, {"kg": 1, "m": 1, "s": -2}), "N m": (1.0, 0.0, {"kg": 1, "m": 2, "s": -2}),
    "N*m/rad": (1.0, 0.0, {"kg": 1, "m": 2, "s": -2, "rad": -1}), "mA": (constants.milli, 0.0, {"A": 1}),
    "us": (constants.micro, 0.0, {"s": 1}), "%": (0.01, 0.0, {}), "1": (1.0, 0.0, {}),
    "K": (1.0, 0.0, {"K": 1}),
    "degC": (1.0 + constants.zero_Celsius, constants.zero_Celsius, {"K": 1}), "Hz": (1.0, 0.0, {"s": -1})}
UNITS = st.sampled_from(sorted(PORT_UNITS))


def powers_of(unit):
    return tuple(PORT_UNITS[unit][2].get(name, 0) for name in POWERS)


def in_si(unit, value):
    one, zero, _ = PORT_UNITS[unit]
    return zero + (one - zero) * value


def described(base, named="own", start=0.0, count=1):
    variables = {f"x{i}": FmuVariable(f"x{i}", i, "Real", "input", "continuous", (), named, start, base)
                 for i in range(count)}
    return FmuDescription(
        version=2, interface="co_simulation", identifier="m", token="t", variables=variables, states=0,
        indicators=0, completes_steps=False, saves=False, once=False, needs_tool=False, internal_step_s=0.0,
        has_sources=False)


@given(unit=UNITS, factor=st.floats(1e-9, 1e9), offset=st.floats(-1e3, 1e3), value=st.floats(-1e3, 1e3))
def test_a_value_means_the_same_on_both_sides(unit, factor, offset, value):
    description = described(BaseUnit(powers_of(unit), factor, offset), start=value)
    port = FmuPort(name="u", variables=("x0",), unit=unit)
    (bound,) = bind_ports(description, "input", (port,), "input_ports")
    given_to_fmu = value * bound.scales[0] + bound.offsets[0]
    size = abs(offset) + abs(in_si(unit, value)) + factor
    assert factor * given_to_fmu + offset == pytest.approx(in_si(unit, value), abs=1e-9 * size)
    assert in_si(unit, bound.port.initial_value()) == pytest.approx(factor * value + offset,
                                                                    abs=1e-9 * (size + factor * abs(value)))


@given(unit=UNITS, other=UNITS, factor=st.floats(1e-9, 1e9))
def test_another_quantity_is_refused(unit, other, factor):
    port = FmuPort(name="u", variables=("x0",), unit=unit)
    description = described(BaseUnit(powers_of(other), factor))
    if powers_of(unit) == powers_of(other):
        assert bind_ports(description, "input", (port,), "input_ports")
        return
    with pytest.raises(InputError, match="different quantities") as refused:
        bind_ports(description, "input", (port,), "input_ports")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("base", "named", "port", "words"), [
    (None, "deg", {"unit": "rad"}, "'rad', but 'x0' is in 'deg'"), (None, "1", {"unit": "rad"}, "is in '1'"),
    (BaseUnit((0,) * 8, math.nan), "own", {"unit": "1"}, "is in 'own'"),
    (BaseUnit((0,) * 8, 0.0), "own", {"unit": "1"}, "is in 'own'"),
    (None, "deg", {"unit": "angle"}, "is in 'deg'"), (None, "deg", {"scale": 57.3}, "unit: is not given"),
    (None, "deg", {"unit": "rad", "scale": 57.3}, ""), (None, "Nm", {"unit": "N m", "scale": 1.0}, ""),
    (None, "deg", {"unit": "deg"}, ""), (None, "deg", {}, ""), (None, "", {"unit": "rad"}, ""),
    (None, "", {"scale": 57.3}, "")])
def test_what_cannot_be_converted_needs_a_scale(base, named, port, words):
    declared = (FmuPort(name="u", variables=("x0",), **port),)
    if not words:
        assert bind_ports(described(base, named), "input", declared, "input_ports")
        return
    with pytest.raises(InputError, match=words):
        bind_ports(described(base, named), "input", declared, "input_ports")


def test_each_column_has_a_unit_of_its_own():
    milliampere, microsecond = BaseUnit(powers_of("mA"), 1e-3), BaseUnit(powers_of("us"), 1e-6)
    description = described(None, count=4)
    for i, variable in enumerate(description.variables.values()):
        description.variables[variable.name] = FmuVariable(
            variable.name, i, "Real", "input", "continuous", (), ("mA", "us")[i % 2], 0.0,
            (milliampere, microsecond)[i % 2])
    port = FmuPort(name="u", variables=("x0", "x1", "x2", "x3"), shape=(2, 2), unit="A,s")
    (bound,) = bind_ports(description, "input", (port,), "input_ports")
    np.testing.assert_allclose(bound.scales, (1e3, 1e6, 1e3, 1e6))


@pytest.mark.parametrize("ports", [[("a", ("x0", "x1", "x0"))], [("a", ("x0",)), ("b", ("x1", "x0"))]])
def test_a_variable_is_set_by_one_element(ports):
    with pytest.raises(InputError, match="'x0' is "):
        bind_ports(described(None, "", count=2), "input",
                   [FmuPort(name=name, variables=variables) for name, variables in ports], "input_ports")


@pytest.mark.parametrize("relative", ["", "its type", "itself"])
def test_an_fmu_in_degrees_celsius_is_given_kelvin(small2, tmp_path, relative):
    path = tmp_path / "warm.fmu"
    with zipfile.ZipFile(small2()) as given_, zipfile.ZipFile(path, "w") as made:
        for name in given_.namelist():
            content = given_.read(name)
            if name == "modelDescription.xml":
                flag = b'relativeQuantity="true" '
                own, of_type = flag * (relative == "itself"), flag * (relative == "its type")
                content = content.replace(
                    b'<Real start="0"/>', b"<Real " + own + b'declaredType="Warmth" start="5"/>', 1)
                content = content.replace(
                    b"<ModelVariables>", b'<UnitDefinitions><Unit name="degC">'
                    b'<BaseUnit K="1" offset="273.15"/></Unit></UnitDefinitions><TypeDefinitions><SimpleType '
                    b'name="Warmth"><Real ' + of_type + b'unit="degC"/></SimpleType></TypeDefinitions>'
                    b"<ModelVariables>", 1)
            made.writestr(name, content)
    plant = Fmu(path=str(path), input_ports=(FmuPort(name="u", variables=("u",), unit="K"),))
    zero = 0.0 if relative else 273.15
    assert plant.inputs[0].initial_value() == pytest.approx(5.0 + zero)
    state = plant.init(Context("plant"))
    for _ in range(3000):
        plant.advance(state, [zero + 20.0], 0, 0)
    assert plant.read(state, [])[0] == pytest.approx(20.0)
    plant.close(state)


@pytest.mark.parametrize("automatic", [True, False])
@given(unit=UNITS, factor=st.floats(1e-6, 1e6), value=st.floats(-1e3, 1e3), rad=st.booleans())
def test_a_name_means_what_the_fmu_defines_it_as(automatic, unit, factor, value, rad):
    powers = powers_of(unit) if rad else (*powers_of(unit)[:-1], 0)
    one, zero, _ = PORT_UNITS[unit]
    description = described(BaseUnit(powers, factor * (one - zero), zero), unit, start=value)
    declared = () if automatic else (FmuPort(name="x0", variables=("x0",), unit=unit),)
    (bound,) = bind_ports(description, "input", declared, "input_ports")
    assert bound.port.unit == unit
    assert in_si(unit, bound.port.initial_value()) == pytest.approx(
        zero + factor * (one - zero) * value, rel=2e-6, abs=1e-9 * (1.0 + abs(zero)))


@pytest.mark.parametrize("declared", [(), (FmuPort(name="u", variables=("x0",), unit="N"),)])
def test_a_name_that_the_fmu_defines_as_another_quantity_is_refused(declared):
    description = described(BaseUnit(powers_of("mA"), 1.0), "N")
    with pytest.raises(InputError, match="defines that as another quantity than 'N'") as refused:
        bind_ports(description, "input", declared, "input_ports")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("names", [("y", "y[1]", "y[2]"), ("y[1]", "y[2]", "y"), ("y[1]", "y[01]"),
                                   ("y[1,2]", "y[1, 2]", "y[1,1]")])
def test_names_that_would_be_one_port_are_refused(names):
    description = described(None, "")
    description.variables.clear()
    for i, name in enumerate(names):
        description.variables[name] = FmuVariable(name, i, "Real", "input", "continuous", (), "", 0.0)
    words = r"which would be one port; .* declare input_ports"
    with pytest.raises(InputError, match=words) as refused:
        bind_ports(description, "input", (), "input_ports")
    assert "\n" not in str(refused.value)
    declared = [FmuPort(name=f"p{i}", variables=(name,)) for i, name in enumerate(names)]
    assert len(bind_ports(description, "input", declared, "input_ports")) == len(names)
