"""Each output of a silent FMU is looked at: one that moves hides none that is stale."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.loop.block import Context
from plants.fmu import Fmu
from plants.fmu.description import FmuDescription, FmuVariable
from plants.fmu.ports import FmuPort, bind_ports
from plants.fmu.running import FmuSetup
from plants.fmu.trial import InternalStep, find_internal_step, misfit

PERIOD_S = 1e-3
PORT = {"name": "w", "variables": ("w",)}
COURSES = {
    "decays": lambda t, u: math.exp(-t / 0.3), "rises": lambda t, u: 3.0 + t, "rests": lambda t, u: 1.0,
    "turns": lambda t, u: math.sin(t), "drifts": lambda t, u: 300.0 * (1.0 + 1e-16 * round(400.0 * t)),
    "is a square wave": lambda t, u: float(int(t / 0.02) % 2), "is not a number": lambda t, u: math.nan,
    "follows the input": lambda t, u: u * (2.0 + t) + u}


class MadeUp:
    """An FMU whose outputs each follow a course, at every communication point or on a grid of its own."""

    def __init__(self, courses, told_s=None):
        variables = {f"y{i}": FmuVariable(f"y{i}", i, "Real", "output", "continuous", (), "1", 0.0)
                     for i in range(len(courses))}
        variables["u"] = FmuVariable("u", len(courses), "Real", "input", "continuous", (), "1", 0.0)
        description = FmuDescription(
            version=2, interface="co_simulation", identifier="m", token="t", variables=variables, states=0,
            indicators=0, completes_steps=False, saves=False, once=False, needs_tool=False,
            internal_step_s=0.0, has_sources=False)
        self.setup = FmuSetup(description, bind_ports(description, "input", (), "input_ports"),
                              bind_ports(description, "output", (), "output_ports"), (),
                              1_000_000, 1, 5)
        self.courses, self.told_s, self.tick, self.moved_s = courses, told_s, 0, math.inf
        self.inputs = SimpleNamespace(values=np.zeros(1))
        self.outputs = SimpleNamespace(values=np.zeros(len(courses)))
        self.step(False)

    def step(self, inputs_changed):
        self.tick += 1
        time_s = self.tick * PERIOD_S
        if self.inputs.values[0] and self.moved_s == math.inf:
            self.moved_s = time_s
        for i, (name, own_s) in enumerate(self.courses):
            shown_s = own_s * math.floor(time_s / own_s + 1e-9) if own_s else time_s
            self.outputs.values[i] = COURSES[name](shown_s, 1.0 if shown_s >= self.moved_s else 0.0)

    def reached_s(self):
        return None if self.told_s is None else self.told_s * self.tick


MOVING = st.tuples(st.sampled_from(sorted(COURSES)), st.just(0.0))
STALE = st.tuples(st.sampled_from(["decays", "rises", "turns", "follows the input"]), st.floats(0.0023, 0.1))


@settings(max_examples=60, deadline=None)
@given(courses=st.lists(MOVING, max_size=4).flatmap(
    lambda moving: st.lists(STALE, max_size=2).flatmap(lambda stale: st.permutations([*moving, *stale]))),
       told_s=st.sampled_from([None, PERIOD_S]))
def test_what_is_stale_is_found_among_whatever_moves(courses, told_s):
    found = find_internal_step(MadeUp(courses, told_s).setup, MadeUp(courses, told_s))
    by_itself, by_input = ({f"y{i}": own_s for i, (name, own_s) in enumerate(courses)
                            if own_s and (name == "follows the input") == asked} for asked in (False, True))
    stale = by_itself or by_input  # inputs are moved only where nothing has shown without
    assert set(found.outputs) == set(stale)
    if stale:
        assert found.length_s == pytest.approx(max(stale.values()), rel=0.06)
        assert all(repr(name) in str(misfit(PERIOD_S, found)) for name in stale)
    else:
        assert found.length_s == pytest.approx(told_s or 0.0)


def test_a_port_that_is_declared_as_sampled_may_hold():
    made = MadeUp([("rises", 0.01), ("decays", 0.0)])
    (held, moving) = made.setup.outputs
    made.setup = replace(made.setup, outputs=(replace(held, sampled=True), moving))
    assert find_internal_step(made.setup, made) == InternalStep()


def test_an_fmu_with_one_stale_output_is_refused_unless_it_is_declared(small2):
    fmu = str(small2("INTERNAL_STEP_S=0.005", "MOVES"))
    with pytest.raises(InputError, match=r"about 5 ms: 'y' would be stale; allowed: at most about 200 Hz"):
        Fmu(path=fmu)
    Fmu(path=fmu, step_rate="200")
    assert Fmu(path=fmu, output_ports=(FmuPort(**PORT),)).outputs[0].name == "w"
    plant = Fmu(path=fmu, output_ports=(FmuPort(name="y", variables=("y",), sampled=True), FmuPort(**PORT)))
    state = plant.init(Context("plant"))
    plant.advance(state, [1.0], 0, 1_000_000)
    assert plant.read(state, []) == (0.0, 0.001)
    plant.close(state)
