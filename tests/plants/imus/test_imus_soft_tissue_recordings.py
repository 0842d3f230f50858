"""The model of soft tissue on a recording: sensors on foam beside others on the same rigid segments.

What a sensor on foam reads is predicted from its rigid neighbour; fitted in the first half, judged in the
second.
"""

import numba
import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from fesloop.streams.files import open_recording
from plants.imus.disturbances import SoftTissue, Tissue, own_rate, turn_back, wobble


@numba.njit
def predicted(tissue, rates, forces, period_s):
    """Rates (t, 3) of a sensor on the tissue over a bone of these rates and forces (t, 3)."""
    motion, read = np.zeros((4, 3)), rates.copy()
    for k in range(rates.shape[0]):
        wobble(tissue, rates[k], forces[k], 0.0 if k == 0 else period_s, motion)
        turn_back(motion[0], read[k])
        own_rate(motion[0], motion[1], read[k])
    return read


def outwards(tilt, turn):
    return np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])


@pytest.mark.parametrize("segment", range(5))
def test_the_model_explains_half_of_what_foam_does_to_a_sensor(recordings, segment):
    path = recordings / "chain5" / "trial1.npz"
    rigid, foam = (open_recording(path, kind) for kind in ("rigid", "nonrigid"))
    period_s, half = 1.0 / float(rigid.rate), rigid.samples // 2
    read = foam.gyr[:, segment].copy()
    rate, force = rigid.gyr[:, segment].copy(), rigid.acc[:, segment].copy()
    first, later = slice(0, half), slice(half, None)
    mounted, _ = Rotation.align_vectors(read[first], rate[first])
    default = SoftTissue().coefficients()

    def left(parameters, part):
        """What is unexplained, rad/s, by factors on the default numbers, outward direction and mounting."""
        turn = Rotation.from_rotvec(parameters[6:]) * mounted
        tissue = Tissue(*(np.array(default[:4]) * parameters[:4]), outwards(*parameters[4:6]))
        found = predicted(tissue, np.ascontiguousarray(turn.apply(rate[part])),
                          np.ascontiguousarray(turn.apply(force[part])), period_s)
        return (found - read[part]).ravel()

    # The sensors' boards lie on the foam, so z is out of it.
    start = [1.0, 1.0, 1.0, 1.0, 0.1, 0.0, 0.0, 0.0, 0.0]
    fit = least_squares(left, start, args=(first,), max_nfev=20)
    unexplained = np.square(left(fit.x, later)).sum()
    assert unexplained < 0.6 * np.square(read - mounted.apply(rate))[later].sum()
    assert outwards(*fit.x[4:6])[2] > 0.9
    assert (fit.x[:4] > 0.4).all()
    assert (fit.x[:4] < 1.8).all()
