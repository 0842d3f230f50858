"""Whether pulses may go to a device, whoever asks for them."""

from __future__ import annotations

import math

from plants.devices.driver import Pulses
from plants.stimulator.generations import Preset

_ROUND_OFF = 1e-6


def wrong_pulses(pulses: Pulses, device: Preset, charge_max: float) -> str:
    """What of the pulses must not be given; empty if all is well.

    `charge_max`: C, of a phase, the user's limit.
    """
    more = 1.0 + _ROUND_OFF
    for channel, (current, width) in enumerate(pulses):
        if not (math.isfinite(current) and math.isfinite(width) and current >= 0.0 and width >= 0.0):
            return f"channel {channel}: {current} A, {width} s"
        if current > 1e-3 * device.current_max_ma * more or width > 1e-6 * device.width_max_us * more:
            return f"channel {channel}: {1e3 * current:g} mA, {1e6 * width:g} us are beyond the device"
        if current * width > charge_max * more:
            return f"channel {channel}: {1e6 * current * width:g} uC are beyond {1e6 * charge_max:g}"
    return ""
