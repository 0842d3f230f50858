import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from controllers.reference import Cyclic
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document
from fesloop.loop.block import Context, Tick

ROWS = ("wrist_extension", "finger_flexion")
TOLD = {"rows": ROWS, "period_s": 4.0, "mean_deg": {"wrist_extension": 5.0, "finger_flexion": 40.0},
        "amplitude_deg": {"finger_flexion": 25.0}, "cycles": 3, "start_s": 1.0}


def degrees(block, times_s, output=0):
    told = []
    for time in times_s:
        tick = Tick()
        tick.time_ns = round(time * 1e9)
        told.append(np.degrees(block.step(block.init(Context("reference")), (), tick)[output]))
    return np.array(told)


def test_sinusoids_begin_and_end_at_their_near_end():
    times = np.linspace(1.0, 13.0, 41)
    told = degrees(Cyclic(**TOLD), times)
    np.testing.assert_allclose(told[:, 0], 5.0)
    np.testing.assert_allclose(told[:, 1], 40.0 - 25.0 * np.cos(2 * np.pi * (times - 1.0) / 4.0), atol=1e-6)
    np.testing.assert_allclose(degrees(Cyclic(**TOLD), [0.0, 13.01, 40.0])[:, 1], 15.0)


def test_open_close_moves_as_quintics_and_stands_still_between():
    block = Cyclic(**TOLD, shape="open_close", flank_s=1.5)
    points = [[[angle], [0.0], [0.0]] for angle in (15.0, 65.0, 65.0, 15.0, 15.0)]
    quintics = BPoly.from_derivatives([1.0, 2.5, 3.0, 4.5, 5.0], np.array(points))
    times = np.linspace(1.0, 5.0, 81)
    for cycle in range(3):
        told = degrees(block, times + 4.0 * cycle)[:, 1]
        np.testing.assert_allclose(told, quintics(times)[:, 0], atol=1e-5)


def test_a_row_that_lags_does_the_same_later_and_as_often():
    ahead = Cyclic(**TOLD)
    late = Cyclic(**TOLD, lag_deg={"finger_flexion": 90.0})
    times = np.linspace(0.0, 16.0, 65)
    np.testing.assert_allclose(degrees(late, times + 1.0), degrees(ahead, times), atol=1e-6)


def test_an_amplitude_below_zero_begins_at_the_greater_end():
    block = Cyclic(**TOLD | {"amplitude_deg": {"finger_flexion": -25.0}})
    np.testing.assert_allclose(degrees(block, [0.0, 3.0])[:, 1], [65.0, 15.0], atol=1e-6)


def test_no_cycles_go_on_without_end():
    block = Cyclic(**TOLD | {"cycles": 0})
    np.testing.assert_allclose(degrees(block, [4003.0])[0, 1], 65.0, atol=1e-6)


@settings(deadline=None)
@given(st.sampled_from(["sine", "open_close"]), st.floats(0.5, 10.0), st.integers(0, 4), st.floats(0.0, 40.0),
       st.floats(0.0, 720.0))
def test_keeps_between_its_ends_and_previews_what_it_will_say(shape, period, cycles, time, lag):
    block = Cyclic(**TOLD | {"shape": shape, "period_s": period, "cycles": cycles,
                             "lag_deg": {"finger_flexion": lag}}, preview=4, preview_period_ms=30.0)
    ahead = degrees(block, [time], output=1)[0]
    np.testing.assert_allclose(ahead, degrees(block, time + 0.03 * np.arange(1, 5)), atol=1e-5)
    assert (ahead[:, 1] >= 15.0 - 1e-9).all()
    assert (ahead[:, 1] <= 65.0 + 1e-9).all()


def test_a_file_makes_the_same_object():
    table = {"kind": "cyclic", "rate": "40", **{key: value for key, value in TOLD.items() if key != "rows"},
             "rows": list(ROWS)}
    experiment = from_document({"experiment": {"name": "told", "duration_s": 3.0},
                                "blocks": {"reference": table}})
    assert experiment.nodes[0].part == Cyclic(**TOLD)
    assert from_document(experiment.document()) == experiment


@pytest.mark.parametrize(("changed", "named"), [
    ({"period_s": 0.0}, "period_s"), ({"cycles": -1}, "cycles"), ({"start_s": -1.0}, "start_s"),
    ({"flank_s": 1.0}, "flank_s: given with shape"),
    ({"shape": "open_close", "flank_s": 2.1}, "flank_s: 2.1; allowed: above 0, at most 2"),
    ({"shape": "open_close", "flank_s": 0.0}, "flank_s"),
    ({"mean_deg": {"finger_flexion": 40.0}}, "mean_deg: has no angle of wrist_extension"),
    ({"lag_deg": {"finger_flexion": -1.0}}, "lag_deg.finger_flexion: -1; allowed: .* 0 or more"),
    ({"amplitude_deg": {"finger": 1.0}}, "amplitude_deg.finger: is no row"),
    ({"amplitude_deg": {"finger_flexion": float("nan")}}, "amplitude_deg.finger_flexion"),
    ({"amplitude_deg": {"finger_flexion": 60.0}},
     "amplitude_deg.finger_flexion: 100 deg is outside the range of motion .* -32.5 to 95 deg"),
    ({"mean_deg": {"wrist_extension": 80.0, "finger_flexion": 40.0}}, "mean_deg.wrist_extension: 80 deg"),
])
def test_names_what_cannot_be(changed, named):
    with pytest.raises(InputError, match=named):
        Cyclic(**TOLD | changed)
