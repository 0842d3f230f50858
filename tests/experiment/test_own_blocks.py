"""Classes of a script or a notebook as kinds: their source, their provenance, and what is refused."""

import math
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray

import fesloop
from controllers.point_search.block import PointSearch
from controllers.point_search.contract import Query
from controllers.point_search.exhaustive import Exhaustive
from controllers.reference import MinimumJerk
from fesloop import Experiment, InputError, Node, Recording, RunError, Score, Wire
from fesloop.compiled import compiled
from fesloop.experiment import own_blocks, registry
from fesloop.experiment.files.parse import from_document
from fesloop.loop.signals import Port
from plants.finger import Finger

WIDTH_S = 1e-4
SHARES = np.array([[0.5], [1.0]])
LOCK = threading.Lock()
INPUTS = 2


@dataclass
class Counter:
    count: int = 0


def pulses(channels):
    return np.tile([0.04, WIDTH_S], (channels, 1)) * SHARES[1, 0]


@dataclass(frozen=True, slots=True, kw_only=True)
class Steady:
    """Equal pulses."""

    gain: float = 1.0

    @property
    def inputs(self):
        return Port("reference", (3,), "rad"), Port("measured", (3,), "rad")

    @property
    def outputs(self):
        return (Port("stimulation", (4, 2), "A,s"),)

    def init(self, context):
        return Counter()

    def step(self, state, inputs, tick):
        state.count += 1
        return (self.gain * pulses(4),)


@dataclass(frozen=True, kw_only=True)
class Climb(Exhaustive):
    """From one element to its best neighbour."""

    first: int = 0

    def ask(self, state):
        if state.told:
            return None
        return Query(elements=(self.first,), current_ma=20.0, width_us=state.space.width_us)


@dataclass(frozen=True, kw_only=True)
class ClimbSearch(PointSearch):
    climb: Climb = field(default_factory=Climb)

    @property
    def chosen(self):
        return self.climb


@pytest.fixture(autouse=True)
def forgotten(monkeypatch):
    """Registers nothing beyond a test."""
    monkeypatch.setattr(registry, "_own", {})
    yield
    registry.find.cache_clear()


def loop_of(controller, name="one"):
    reference = MinimumJerk(times_s=(0.2, 0.8), angles_deg=((20, 25, 15), (34, 45, 22)))
    return Experiment(
        name=name, duration_s=1,
        nodes=(Node("reference", reference, "50"), Node("controller", controller, "50"),
               Node("finger", Finger())),
        wires=(Wire("reference.angles", "controller.reference"),
               Wire("finger.angles", "controller.measured", latency_ms=30),
               Wire("controller.stimulation", "finger.stimulation", latency_ms=5)),
        score=Score(truth="finger.angles", reference="reference.angles"))


def test_a_class_is_a_kind_under_its_name_or_another():
    assert fesloop.block(Steady) is Steady
    assert registry.kind_of(Steady) == "steady"
    fesloop.block("even")(Counted)
    assert registry.find("even") is Counted
    assert registry.summary("steady") == "Equal pulses."
    assert {"steady", "even", "pid"} <= set(registry.kinds())


def test_its_source_defines_it_by_itself():
    source = own_blocks.source_of(Steady)
    assert "WIDTH_S = 0.0001" in source
    assert source.index("def pulses") < source.index("class Steady")
    assert source.index("class Counter") < source.index("class Steady")
    assert "LOCK" not in source
    made = own_blocks._defined("steady", source)
    assert made is not Steady
    assert np.array_equal(made(gain=2.0).step(made().init(None), [], None)[0], 2.0 * pulses(4))


def test_a_recording_keeps_the_source_and_is_repeated_by_it(tmp_path):
    fesloop.block(Steady)
    experiment = loop_of(Steady(gain=2.0))
    result = fesloop.run(experiment, out=tmp_path)
    with Recording(result.recording) as recording:
        digest, code = recording.digest(), recording.experiment["code"]
    assert code == {"steady": own_blocks.source_of(Steady)}
    registry._own.clear()
    registry.find.cache_clear()
    with pytest.raises(InputError, match=r"'steady', a class of a notebook or a script, is not defined here"):
        fesloop.load(result.recording)
    own_blocks.define(code)
    again = fesloop.run(result.recording, out=tmp_path)
    with Recording(again.recording) as recording:
        assert recording.digest() == digest


def test_a_shipped_experiment_takes_it(tmp_path):
    fesloop.block(Steady)
    steady = {"kind": "steady", "rate": "50"}
    result = fesloop.run("finger_control", {
        "control": "pid", "blocks.controller": steady, "experiment.duration_s": 1.0}, out=tmp_path)
    assert result.status == "done"


def test_the_source_follows_what_the_class_uses(monkeypatch):
    fesloop.block(Steady)
    experiment = loop_of(Steady())
    before = experiment.document()["code"]["steady"]
    assert "WIDTH_S = 0.0001" in before
    monkeypatch.setitem(globals(), "WIDTH_S", 2e-4)
    changed = experiment.document()
    assert "WIDTH_S = 0.0002" in changed["code"]["steady"]
    SHARES[1, 0] = 0.25
    try:
        with pytest.raises(InputError, match=r"'steady', a class .* is now another class than in this"):
            from_document(changed)
    finally:
        SHARES[1, 0] = 1.0
    monkeypatch.setitem(globals(), "WIDTH_S", 1e-4)
    assert experiment.document()["code"]["steady"] == before


def test_documents_of_shipped_kinds_have_no_code():
    assert "code" not in fesloop.load("finger_control").document()


def test_a_strategy_of_a_search_is_a_class_of_ones_own(tmp_path):
    fesloop.block(ClimbSearch)
    own_blocks._defined("climb_search", own_blocks.source_of(ClimbSearch))
    search = {"kind": "climb_search", "rate": "40", "movement": "finger_opening"}
    result = fesloop.run("array_search_gp", {"blocks.search": search, "duration_s": 6}, out=tmp_path)
    assert result.metrics["found_elements"] == [[0]]


def counted(width_s):
    @dataclass(frozen=True)
    class Within:
        inputs = (Port("reference", (3,), "rad"), Port("measured", (3,), "rad"))
        outputs = (Port("stimulation", (4, 2), "A,s"),)

        def init(self, context):
            return None

        def step(self, state, inputs, tick):
            return (np.tile([0.04, width_s], (4, 1)),)

    return Within


Counted = counted(2e-4)


LIMIT = math.inf
TURN = np.radians(3.0)


@compiled
def half(x):
    return 0.5 * x


@dataclass(frozen=True)
class Aliased(Steady):
    """Uses an alias of a type, a compiled function, and constants of other kinds."""

    way: Literal["a", "b"] = "a"
    weights: NDArray[np.float64] | None = None

    def init(self, context):
        return half(min(LIMIT, TURN))


def test_aliases_compiled_functions_and_any_number_are_kept():
    source = own_blocks.source_of(Aliased)
    assert "from numpy.typing import NDArray" in source
    assert own_blocks._defined("aliased", source)().init(None) == half(TURN)


def test_values_of_the_function_around_a_class_are_kept():
    assert "width_s = 0.0002" in own_blocks.source_of(Counted)


def test_an_object_of_a_former_definition_is_refused():
    before = loop_of(fesloop.block(Counted)())
    documented = loop_of(Counted())
    document = documented.document()
    fesloop.block(counted(3e-4))
    with pytest.raises(InputError, match="Within: has been defined again since this object of it was made"):
        before.document()
    with pytest.raises(InputError, match=r"'within', a class .* is now another class than in this"):
        from_document(document)


@dataclass(frozen=True)
class Locked(Steady):
    def init(self, context):
        with LOCK:
            return Counter()


@dataclass(frozen=True)
class Lawful(Steady):
    law: Callable = abs


class Bare:
    inputs = outputs = ()

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return ()


@dataclass(frozen=True)
class Stepless:
    inputs = outputs = ()

    def init(self, context):
        return None


@pytest.mark.parametrize(("given", "message"), [
    (lambda state: state, "is no class; allowed: a frozen dataclass"),
    (Steady(), "is no class; allowed: a frozen dataclass"),
    (Bare, "Bare: is no dataclass; allowed: @fesloop.block above @dataclass"),
    (Stepless, r"`step\(state, inputs, tick\)` is missing"),
    (Locked, "Locked: uses 'LOCK', a lock, which cannot be kept with it; allowed: .*; make LOCK a parameter"),
])
def test_what_is_no_block_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        fesloop.block(given)


@pytest.mark.parametrize(("kind", "message"), [
    ("pid", "block kind 'pid' exists already"), ("Own PID", "'Own PID' is no name of a kind")])
def test_a_name_of_a_kind_that_cannot_be_is_refused(kind, message):
    with pytest.raises(InputError, match=message):
        fesloop.block(kind)(Steady)


def test_a_class_without_source_is_refused_as_a_kind():
    names = {"dataclass": dataclass, "__name__": "typed"}
    exec("@dataclass\nclass Typed:\n    inputs = outputs = ()\n    def init(self, context): pass\n"
         "    def step(self, state, inputs, tick): pass", names)
    with pytest.raises(InputError, match="Typed: has no source that could be kept"):
        fesloop.block(names["Typed"])


def test_a_parameter_that_no_document_holds_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"blocks\.controller\.law: a builtin_function_or_method cannot be"):
        loop_of(fesloop.block(Lawful)()).run(tmp_path)


@pytest.mark.parametrize(("part", "message"), [
    (lambda state: state, "controller.part: .* is no block; allowed: an object of a block's"),
    (Steady, r"controller.part: .* is a class: give an object of it, Steady\(...\)"), (3, "3 is no block")])
def test_a_node_of_something_else_is_refused(part, message):
    with pytest.raises(InputError, match=message):
        loop_of(part)


def test_a_class_that_is_no_kind_runs_and_leaves_its_source(tmp_path):
    result = loop_of(Steady()).run(tmp_path)
    with Recording(result.recording) as recording:
        (kind, source), = recording.experiment["code"].items()
    assert kind == f"{Steady.__module__}:Steady"
    assert source == own_blocks.source_of(Steady)
    with pytest.raises(InputError, match="is no kind, but a class that was given as an object"):
        fesloop.load(result.recording)


def test_where_its_source_cannot_be_kept_the_recording_says_so(tmp_path):
    result = loop_of(Locked()).run(tmp_path)
    with Recording(result.recording) as recording:
        (source,) = recording.experiment["code"].values()
    assert source.startswith("# This run cannot be repeated from its recording: Locked: uses 'LOCK'")


def test_a_study_of_two_experiments_of_one_name_is_refused():
    fesloop.block(Steady)
    with pytest.raises(InputError, match="two experiments have the name 'one'"):
        fesloop.study({"study": {"name": "s", "experiment": loop_of(Steady()), "metrics": {"e": "x"}},
                       "axes": {"c": {"options": {"b": {"experiment": loop_of(Steady(gain=2.0))}}}}})


@pytest.mark.parametrize("given", [None, 3, loop_of])
def test_a_study_or_a_run_of_something_else_is_refused(given):
    with pytest.raises(InputError, match=r"study: is of type \w+; allowed: a name, a path, or tables"):
        fesloop.study(given)
    with pytest.raises(InputError, match=r"experiment: is of type \w+; allowed: a name"):
        fesloop.run(given)


_SCRIPT = '''
from dataclasses import dataclass
import numpy as np
import fesloop
from fesloop.loop.signals import Port
WIDTH = {width}

@fesloop.block
@dataclass(frozen=True)
class Own:
    gain: float = 1.0
    inputs = (Port("reference", (3,), "rad"), Port("measured", (3,), "rad"))
    outputs = (Port("stimulation", (4, 2), "A,s"),)

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        return (np.tile([0.04, WIDTH * self.gain], (4, 1)),)

if __name__ == "__main__":
    experiment = fesloop.load("finger_control", {{"control": "pid", "experiment.duration_s": 1.0,
        "blocks.controller": {{"kind": "own", "rate": "50"}}}})
    try:
        metrics = {{"error_deg": "joint_rmse_deg"}}
        print(fesloop.study({{
            "study": {{"name": "own", "experiment": experiment, "metrics": metrics}},
            "axes": {{"gain": {{"key": "blocks.controller.gain", "values": [1.0, 2.0]}}}}}}, workers=2))
    except fesloop.FesloopError as fault:
        print("refused:", fault)
'''


@pytest.mark.slow
def test_a_study_runs_a_class_of_a_script_in_other_processes_and_refuses_a_changed_one(tmp_path):
    def printed(width):
        script = tmp_path / "own.py"
        script.write_text(_SCRIPT.format(width=width))
        environment = {"PYTHONPATH": str(Path(fesloop.__file__).parents[1]), "PATH": "/usr/bin:/bin",
                       "HOME": str(tmp_path)}
        return subprocess.run([sys.executable, script], cwd=tmp_path, env=environment, check=True, text=True,
                              capture_output=True).stdout

    table = printed(1e-4)
    assert "own: 2 of 2 runs done" in table
    assert printed(1e-4) == table
    assert "what has changed is the class of the kind 'own'" in printed(2e-4)


def test_a_failing_step_is_the_classes_own_fault(tmp_path):
    @dataclass(frozen=True)
    class Failing(Steady):
        def step(self, state, inputs, tick):
            raise RunError("by itself")

    with pytest.raises(RunError, match="by itself"):
        loop_of(Failing()).run(tmp_path)
