import numpy as np
import pytest
from scipy.interpolate import BPoly

from controllers.reference import MinimumJerk
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick

TIMES = (0.5, 1.25, 2.0, 3.0)
ANGLES = ((0.0, 10.0), (40.0, 60.0), (40.0, 60.0), (5.0, -3.0))


def stepped(block, time_s):
    tick = Tick()
    tick.time_ns = round(time_s * 1e9)
    return block.step(block.init(Context("reference")), (), tick)


def test_equals_the_quintic_hermite_that_rests_at_each_way_point():
    points = [[[angle], [0.0], [0.0]] for angle in ANGLES]
    quintic = BPoly.from_derivatives(TIMES, [[p[0][0], np.zeros(2), np.zeros(2)] for p in points])
    times = np.linspace(TIMES[0], TIMES[-1], 301)
    block = MinimumJerk(times_s=TIMES, angles_deg=ANGLES)
    np.testing.assert_allclose(np.degrees(block.angles_at(times)), quintic(times), atol=1e-10)


def test_stands_still_before_the_first_and_after_the_last():
    block = MinimumJerk(times_s=TIMES, angles_deg=ANGLES)
    np.testing.assert_allclose(np.degrees(stepped(block, 0.1)[0]), ANGLES[0])
    np.testing.assert_allclose(np.degrees(stepped(block, 7.0)[0]), ANGLES[-1])


def test_one_way_point_is_a_constant():
    block = MinimumJerk(times_s=(0.0,), angles_deg=((20.0,),), preview=3)
    now, ahead = stepped(block, 1.0)
    np.testing.assert_allclose(np.degrees(now), [20.0])
    np.testing.assert_allclose(np.degrees(ahead), [[20.0]] * 3)


def test_preview_is_what_the_block_will_say_at_those_instants():
    block = MinimumJerk(times_s=TIMES, angles_deg=ANGLES, preview=5, preview_period_ms=40.0)
    _, ahead = stepped(block, 0.6)
    later = [stepped(block, 0.6 + 0.04 * k)[0] for k in range(1, 6)]
    np.testing.assert_allclose(ahead, later, atol=1e-12)


@pytest.mark.parametrize(("faulty", "key"), [
    ({"times_s": (1.0, 0.5)}, "times_s"),
    ({"times_s": (0.0,)}, "angles_deg"),
    ({"angles_deg": ((0.0,), (1.0, 2.0))}, "angles_deg"),
    ({"angles_deg": ((0.0,), (float("nan"),))}, "angles_deg"),
    ({"angles_deg": ((0.0,), (200.0,))}, r"angles_deg\[1\]\[0\]: 200 deg is outside the range of motion"),
    ({"rows": ("F2_pip_flexion",), "angles_deg": ((0.0,), (110.0,))},
     r"angles_deg\[1\]\[0\]: 110 deg .* of F2_pip_flexion; allowed: -20 to 100 deg"),
    ({"rows": ("F2_pip_flexion", "F2_dip_flexion")}, "rows: 2 names"),
    ({"rows": ("F2_pip",)}, "did you mean"),
    ({"range_deg": {"F2_pip_flexion": (0.0, 90.0)}}, "rows"),
    ({"preview": -1}, "preview"),
    ({"preview_period_ms": 0.0}, "preview_period_ms"),
])
def test_names_the_faulty_key(faulty, key):
    given = {"times_s": (0.0, 1.0), "angles_deg": ((0.0,), (1.0,))} | faulty
    with pytest.raises(InputError, match=key):
        MinimumJerk(**given)
