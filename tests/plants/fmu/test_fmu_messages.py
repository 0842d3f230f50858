"""What an FMU says while it goes on, and values that are not finite whenever they come."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import RunError
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.block import Context
from plants.fmu import Fmu
from plants.fmu.library import LONGEST, MOST_KINDS, FmuLog


def experiment(fmu, isolate=True, outputs=("y", "w")):
    """A reference that moves the FMU, which an open loop reads at 10 Hz."""
    return from_document({
        "experiment": {"name": "moved", "duration_s": 0.4},
        "record": {"plant_rate": "10"},
        "blocks": {
            "reference": {"kind": "minimum_jerk", "rate": "50", "times_s": [0.0, 0.1],
                          "angles_deg": [[0], [30]]},
            "plant": {"kind": "fmu", "path": str(fmu), "isolate": isolate,
                      "output_ports": [{"name": name, "variables": [name]} for name in outputs],
                      "input_ports": [{"name": "u", "unit": "rad", "shape": [1], "variables": ["u"]}]}},
        "wires": [{"from": "reference.angles", "to": "plant.u"}]})


@pytest.mark.parametrize("isolate", [True, False])
@pytest.mark.parametrize(("definitions", "words"), [
    (('SAYS="hot at %.3f s"',), "the FMU says: hot at 0.000 s"),
    (("WARNS",), "fmi2DoStep returned fmi2Warning"),
    (("WARNS", 'SAYS="hot at %.3f s"'), "the FMU says: hot at 0.000 s"), ((), "")])
def test_what_is_said_over_and_over_is_one_event(small2, tmp_path, isolate, definitions, words):
    result = experiment(small2("MOVES", *definitions), isolate).run(tmp_path)
    with Recording(result.recording) as recording:
        events = [event for event in recording.events if event.status == "fmu_warning"]
    assert [(event.where, event.time_ns) for event in events] == [("plant", 1_000_000)] * bool(words)
    assert all(words in event.detail for event in events)


@given(texts=st.lists(st.text(st.characters(codec="utf-8"), max_size=2 * LONGEST), max_size=40),
       taken=st.sets(st.integers(0, 40)))
def test_messages_are_few_short_and_single_lines(texts, taken):
    log, told = FmuLog(), []
    for number, text in enumerate(texts):
        log.hear(text)
        if number in taken:
            told += log.fresh
            log.fresh = []
    told += log.fresh
    assert len(told) <= MOST_KINDS + 1
    assert len(set(told)) == len(told) or LONGEST in map(len, told)
    assert all(len(text) <= LONGEST and "\n" not in text for text in told)
    assert bool(told) == bool(texts)


@given(numbers=st.lists(st.floats(), min_size=1, max_size=20))
def test_messages_that_differ_in_numbers_are_of_one_kind(numbers):
    log = FmuLog()
    for number in numbers:
        log.hear(f"pressure {abs(number) if abs(number) < 1e300 else 0.0} Pa")
    assert len(log.fresh) == 1


@pytest.mark.parametrize("isolate", [True, False])
@pytest.mark.parametrize("value", ["NAN", "-INFINITY"])
def test_what_is_not_finite_between_two_readings_ends_the_run_there(small2, tmp_path, isolate, value):
    fmu = small2("MOVES", "AT_S=0.1234", f"MISDEED=if (t < 0.1244) m->w = {value}")
    words = r"plant\.w is not finite at 125\.000000 ms: the FMU puts out -?(nan|inf)"
    with pytest.raises(RunError, match=words):
        experiment(fmu, isolate).run(tmp_path)
    experiment(fmu, isolate, ("y",)).run(tmp_path)


def test_messages_of_initialisation_are_kept_for_the_first_step(small2):
    plant = Fmu(path=str(small2()), isolate=False)
    state = plant.init(Context("plant"))
    state.running.library._log.hear("made up")
    plant.advance(state, [1.0], 0, 0)
    assert plant.reports(state) == [("fmu_warning", "the FMU says: made up")]
    assert plant.reports(state) == []
    plant.close(state)
