"""Metrics of a sweep: truth is the hand that the recording is made of."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop import Recording, load
from fesloop.experiment.metrics.sweep import sweep_metrics
from fesloop.show.report.run.known import known_of
from fesloop.show.report.run.sentence import sentence_of

TICK_NS, STAIR, REST = 25_000_000, 12, 16
"""Period, and ticks of a current and of a rest."""
NAMES = ("wrist", "finger")


def swept(gains_deg, currents, begin):
    """A recording, and the angles of a hand that follows at once: gain times the number of the current."""
    element, stair, moved = [-1] * begin, [-1] * begin, [np.zeros(2)] * begin
    for number, gain in gains_deg.items():
        for current in (*range(currents), -1):
            ticks = REST if current < 0 else STAIR
            element += [number] * ticks
            stair += [current] * ticks
            moved += [np.radians(gain) * (current + 1) / currents] * ticks
    times_ns = np.arange(len(element)) * TICK_NS
    signals = {"sweep.element": element, "sweep.stair": stair}
    recording = SimpleNamespace(
        experiment={"blocks": {"sweep": {"current_ma": [5.0] * currents}}},
        signal=lambda name, trial: SimpleNamespace(times_ns=times_ns, values=np.array(signals[name], float)))
    return recording, (times_ns, 0.7 + np.array(moved))


GAINS = st.floats(-50.0, 50.0).map(lambda gain: round(gain, 1)).filter(lambda gain: abs(gain) != 6.0)


@given(st.dictionaries(st.integers(0, 58), st.tuples(GAINS, GAINS), max_size=8), st.integers(1, 6),
       st.integers(0, 40))
def test_the_strongest_elements_are_those_of_the_hand(gains, currents, begin):
    """The first element counts if it has a rest of .15 s (6 ticks) before it."""
    recording, trace = swept(gains, currents, begin)
    found = sweep_metrics(recording, "sweep", [trace], NAMES)
    gains = dict(list(gains.items())[begin < 6:])
    assert found["swept_elements"] == [len(gains)]
    assert found["responding_elements"] == [sum(max(map(abs, each)) >= 6.0 for each in gains.values())]
    for row, name in enumerate(NAMES):
        for word, sense in (("raised", 1.0), ("lowered", -1.0)):
            most = max((sense * each[row] for each in gains.values()), default=0.0)
            deg, by = found["joints"][name][f"{word}_deg"][0], found["joints"][name][f"{word}_by"][0]
            if most > 0.0:
                assert deg == pytest.approx(most, abs=1e-9)
                assert sense * gains[by][row] == pytest.approx(most)
            elif most < 0.0 or not gains:
                assert math.isnan(deg)
                assert by is None


def test_the_summary_of_a_sweep_says_what_it_found(tmp_path):
    """Element 16 is over the extensors of the fingers, 43 over their flexors; 0 begins with the trial."""
    result = load("recruitment_sweep", ["elements=[0, 16, 43]", "duration_s=12"]).run(tmp_path)
    assert result.metrics["swept_elements"] == [2]
    joint = result.metrics["joints"]["F3_mcp_flexion"]
    assert (joint["lowered_by"], joint["raised_by"]) == ([16], [43])
    with Recording(result.recording) as recording:
        said = sentence_of(known_of(recording))
    assert said.startswith("2 of 2 elements moved an angle by 6 deg or more; the strongest, deg (element): ")
    assert f"F3_mcp_flexion +{joint['raised_deg'][0]:.0f} (43)" in said
