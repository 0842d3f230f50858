"""Records of identification experiments on plants whose truth is known."""

import numpy as np

from controllers.identification import Excitation
from controllers.identification.patient_model import IdentificationRecord
from fesloop.loop.block import Context, Tick

FINGER = {"current_ma": (40.0,) * 4, "width_us": ((0.0, 400.0),) * 4, "prbs_us": ((0.0, 150.0),) * 4,
          "lead_s": 1.0, "prbs_s": 45.0}


def finger_record(finger, noise_deg=0.3, rate_hz=50, **changed):
    """A finger's angles under `Excitation`, with white noise of a tracker."""
    excitation = Excitation(**FINGER | changed)
    state, source, tick = finger.init(Context("finger")), excitation.init(Context("excitation", 1)), Tick()
    period, rows = 10**9 // rate_hz, []
    for k in range(int(excitation.duration_s * rate_hz)):
        tick.index, tick.time_ns = k, k * period
        pulses, phase = excitation.step(source, (), tick)
        rows.append((pulses, finger.read(state, [pulses])[0], phase))
        finger.advance(state, [pulses], k * period, (k + 1) * period)
    pulses, angles, phases = (np.array(column) for column in zip(*rows, strict=True))
    noise = np.deg2rad(noise_deg) * np.random.default_rng(0).standard_normal(angles.shape)
    return IdentificationRecord(period_s=1.0 / rate_hz, stimulation=pulses, measured=angles + noise,
                                phase=phases, outputs=("MCP", "PIP", "DIP"))
