"""A system of FMUs runs as an experiment: against FMPy's master, and an analytic recursion."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ssp_parts import archived, binding, component, connection, connectors, described, system

import fesloop
from plants.ssp.experiment import import_ssp

BOTH = {"u": "input", "y": "output"}
LAG_S, RATE, STEP_S = 0.1, "100", 0.01
KEPT = math.exp(-STEP_S / LAG_S)


@pytest.fixture(scope="module")
def lag(small2):
    """x' = (u - x) / 0.1 s, y = x, exact between communication points."""
    return small2()


def outputs(ssp, folder, rate=RATE):
    """Outputs of each node at each communication point."""
    imported = import_ssp(ssp, folder / "system", rate)
    began = time.perf_counter()
    result = fesloop.run(imported.experiment, out=folder / "runs")
    taken = time.perf_counter() - began
    with fesloop.Recording(result.recording) as recording:
        return {name: np.ravel(recording.signal(name).values) for name in recording.signals
                if name.endswith(".y")}, taken, imported


def chain(count):
    """Lags in a row; the first has a constant input of 1."""
    parts = [component("lag1", {"y": "output"}, inside=binding({"u": 1.0}))]
    parts += [component(f"lag{i}", BOTH) for i in range(2, count + 1)]
    return described(
        system("chain", parts, [connection(f"lag{i}.y", f"lag{i + 1}.u") for i in range(1, count)]), 2.0
    )


def recursion(count, steps, feedback=0.0):
    """Outputs (steps + 1, count) of lags in a row with held inputs; the first has 1 + feedback x the last."""
    x = np.zeros((steps + 1, count))
    for k in range(steps):
        given = np.concatenate([[1.0 + feedback * x[k, -1]], x[k, :-1]])
        x[k + 1] = KEPT * x[k] + (1.0 - KEPT) * given
    return x


def test_a_chain_is_that_of_fmpy_and_of_the_recursion(lag, tmp_path):
    ssp = archived(tmp_path / "chain.ssp", chain(3), {"resources/lag.fmu": lag})
    ours, taken, imported = outputs(ssp, tmp_path)
    began = time.perf_counter()
    theirs = simulate_ssp(str(ssp), stop_time=2.0, step_size=STEP_S, parameter_set=_set({"lag1.u": 1.0}))
    fmpy_s = time.perf_counter() - began
    exact = recursion(3, 200)
    assert (imported.components, imported.connections) == (3, 2)
    assert "the time inside lag2:" in fesloop.load(imported.experiment).latency_report().not_counted
    for i in range(3):
        got = ours[f"lag{i + 1}.y"]
        assert np.abs(got - exact[:len(got), i]).max() < 1e-12
        # FMPy's row k holds the outputs at the end of step k
        row = theirs[f"lag{i + 1}.y"][:len(got) - 1]
        assert np.abs(got[1:len(row) + 1] - row).max() < 1e-12
        print(f"lag{i + 1}: {np.abs(got - exact[:len(got), i]).max():.1e} from the recursion, "
              f"{np.abs(got[1:len(row) + 1] - row).max():.1e} from FMPy")
    print(f"{taken:.2f} s, FMPy {fmpy_s:.2f} s")


def _set(values):
    from fmpy.ssp.ssd import Parameter, ParameterSet

    return ParameterSet(
        name="p", parameters=[Parameter(name=name, value=value) for name, value in values.items()]
    )


@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(count=st.integers(2, 4), factor=st.floats(-3.0, 0.5).filter(lambda f: abs(f) > 0.01))
def test_a_loop_with_a_linear_transformation_is_the_recursion(lag, tmp_path_factory, count, factor):
    change = f'<ssc:LinearTransformation factor="{factor!r}" offset="1.0"/>'
    parts = [component(f"lag{i}", BOTH) for i in range(1, count + 1)]
    wires = [connection(f"lag{i}.y", f"lag{i + 1}.u") for i in range(1, count)]
    text = described(system("loop", parts, [*wires, connection(f"lag{count}.y", "lag1.u", change)]), 1.5)
    folder = tmp_path_factory.mktemp("loop")
    ours, _, _ = outputs(archived(folder / "loop.ssp", text, {"resources/lag.fmu": lag}), folder)
    exact = recursion(count, 150, factor)
    for i in range(count):
        got = ours[f"lag{i + 1}.y"]
        assert np.abs(got - exact[:len(got), i]).max() < 1e-12


def test_systems_within_systems_parameters_and_mappings_are_resolved(lag, tmp_path):
    mapping = (
        '<ssd:ParameterMapping><ssm:ParameterMapping version="1.0"><ssm:MappingEntry source="level" '
        'target="first.u"><ssc:LinearTransformation factor="0.5"/></ssm:MappingEntry></ssm:ParameterMapping>'
        "</ssd:ParameterMapping>"
    )
    inner = system("inner", [component("first", {"y": "output"}), component("second", BOTH)],
                   [connection("first.y", "second.u"), connection("second.y", "out")],
                   connectors({"out": "output"}) + binding({"level": 2.0}, mapping=mapping))
    outer = system("outer", [component("last", BOTH), inner],
                   [connection("inner.out", "last.u", '<ssc:LinearTransformation factor="2.0"/>'),
                    connection("last.y", "result")], connectors({"result": "output"}))
    ssp = archived(tmp_path / "nested.ssp", described(outer, 1.0, "2.0"), {"resources/lag.fmu": lag})
    ours, _, _ = outputs(ssp, tmp_path)
    assert set(ours) == {"inner_first.y", "inner_second.y", "last.y"}
    inner_y = recursion(2, 100)
    last = np.zeros(101)
    for k in range(100):
        last[k + 1] = KEPT * last[k] + (1.0 - KEPT) * 2.0 * inner_y[k, 1]
    assert np.abs(ours["inner_second.y"] - inner_y[:len(ours["inner_second.y"]), 1]).max() < 1e-12
    assert np.abs(ours["last.y"] - last[:len(ours["last.y"])]).max() < 1e-12
