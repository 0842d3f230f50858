"""min and max of an FMU's variables: kept by start values and the check, reported of inputs."""

import math
import pickle
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.signals import Port
from plants.fmu import Fmu
from plants.fmu.description import FmuVariable
from plants.fmu.ports import BoundPort, FmuPort
from plants.fmu.trial import excite


@pytest.fixture(scope="module", params=["its own", "its type's"])
def limited(request, small2, tmp_path_factory):
    """The small FMU, its input limited to -2 to 3."""
    path = tmp_path_factory.mktemp("limited") / "limited.fmu"
    attributes = b'min="-2" max="3" '
    own, of_type = (attributes, b"") if request.param == "its own" else (b"", attributes)
    with zipfile.ZipFile(small2()) as given_, zipfile.ZipFile(path, "w") as made:
        for name in given_.namelist():
            content = given_.read(name)
            if name == "modelDescription.xml":
                content = content.replace(
                    b'<Real start="0"/>', b"<Real " + own + b'declaredType="L" start="0"/>', 1)
                content = content.replace(
                    b"<ModelVariables>", b'<TypeDefinitions><SimpleType name="L"><Real ' + of_type
                    + b"/></SimpleType></TypeDefinitions><ModelVariables>", 1)
            made.writestr(name, content)
    return str(path)


def test_start_values_keep_them(limited):
    for start in (-2.1, 3.1):
        with pytest.raises(InputError, match=r"starts\.u: .*-2 to 3, the FMU's min and max"):
            Fmu(path=limited, starts={"u": start})
    assert Fmu(path=limited, starts={"u": 3.0}).inputs[0].initial_value() == 3.0


@pytest.mark.parametrize("isolate", [True, False])
def test_an_input_beyond_them_is_reported_when_it_begins(limited, isolate):
    plant = Fmu(path=limited, isolate=isolate, input_ports=(FmuPort(name="u", variables=("u",), scale=10.0),))
    state = plant.init(Context("plant"))
    told = []
    for value in (0.3, 0.31, 0.32, 0.1, -0.21, -0.2, 0.4):
        plant.advance(state, [value], 0, 0)
        told.append([status for status, _ in plant.reports(state)])
        if value == 0.31:
            again = pickle.loads(pickle.dumps(state))
            plant.advance(again, [0.32], 0, 0)
            assert plant.reports(again) == []
            plant.close(again)
    assert told == [[], ["out_of_range"], [], [], ["out_of_range"], [], ["out_of_range"]]
    plant.close(state)


@given(st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(0, 1e6), st.floats(0, 1e6), st.booleans()),
                min_size=1))
def test_what_is_tried_moves_every_input_that_can_move_within_them(elements):
    variables = tuple(
        FmuVariable(f"u{i}", i, "Real", "input", "continuous", (), "", at, None,
                    -math.inf if free else at - below, math.inf if free else at + above)
        for i, (at, below, above, free) in enumerate(elements))
    starts = np.array([variable.start for variable in variables])
    running = SimpleNamespace(inputs=SimpleNamespace(values=starts.copy()))
    bound = BoundPort(Port("u", starts.shape), variables, (1.0,) * starts.size, (0.0,) * starts.size)
    excite(SimpleNamespace(inputs=(bound,)), running)
    for variable, start, value in zip(variables, starts, running.inputs.values, strict=True):
        assert variable.low <= value <= variable.high
        assert value != start or variable.low == variable.high == start


def test_the_report_says_when_the_value_was_latched(limited):
    plant = Fmu(path=limited, step_rate="100", isolate=False)
    state = plant.init(Context("plant"))
    for value in (0.0, 0.0, 4.0):
        plant.advance(state, [value], 0, 0)
    (report,) = plant.reports(state)
    assert report == ("out_of_range", "'u', latched at 20.000000 ms, is 4 in the FMU's unit, outside its "
                      "min and max, -2 to 3")
    plant.close(state)
