"""The sensors of two published hand trackers, and ideal ones.

K14: doi 10.1186/1743-0003-11-70; per segment an ST LSM330DLC, at fingertips and hand a Honeywell HMC5983.
S19: doi 10.3390/s19010208; InvenSense MPU-9259 everywhere, whose data sheet gives the figures of the
MPU-9250 (PS-MPU-9250A-01 rev. 1.0, tables 1 and 2; magnetometer: AK8963).

S19's sensors were calibrated once by a robot (section 2.1), K14's are taken to have been (chosen): what that
leaves of bias and, of accelerometers, of scale and cross-axis is chosen. A tolerance printed as +-x is taken
as three standard deviations (chosen). No data sheet states a bias instability: 10 and 20 deg/h, .1 and .05
mg, held for 100 s, are chosen, as consumer sensors show in Allan plots. Bandwidth is
half the sampling rate (chosen) where noise is given as a density.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from fesloop.hand.motion import STANDARD_GRAVITY
from plants.imus.device import NO_ERRORS, TriadErrors

PresetName = Literal["ideal", "kortier2014", "salchow2019"]
_DEG = math.pi / 180.0
_MILLI_G = 1e-3 * STANDARD_GRAVITY
_MILLI_GAUSS = 1e-7
_MICRO_TESLA = 1e-6


class Preset(NamedTuple):
    """Sensors of a hand.

    Attributes
    ----------
    gyroscope, accelerometer, magnetometer: with every number given.
    soft_iron: sd of the entries by which iron beside the magnetometer distorts the field.
    without: sites that carry no sensor.
    mag_sites: sites with a magnetometer; None: every site with a sensor.
    mounting_angle_deg: smallest and largest angle by which a sensor is stuck on awry.
    """

    gyroscope: TriadErrors
    accelerometer: TriadErrors
    magnetometer: TriadErrors
    soft_iron: float
    without: tuple[str, ...]
    mag_sites: tuple[str, ...] | None
    mounting_angle_deg: tuple[float, float]


PRESETS: dict[PresetName, Preset] = {
    "ideal": Preset(NO_ERRORS, NO_ERRORS, NO_ERRORS, 0.0, (), None, (0.0, 0.0)),
    "kortier2014": Preset(
        # Noise and walk: K14, table 1 (e_b read as a density). Digit, range, zero-rate and cross-axis: data
        # sheet at 2000 deg/s, from memory: 70 mdeg/s a digit, +-75 deg/s, which a still hand shows and takes
        # out: 1e-3 rad/s is left (chosen).
        gyroscope=TriadErrors(
            noise_sd=5e-4, bias_sd=1e-3, instability_sd=20.0 * _DEG / 3600.0, instability_time_s=100.0,
            walk=1e-4, scale_sd=0.01, axes_deg=0.4, turn_deg=0.3, limit=2000.0 * _DEG,
            resolution=0.070 * _DEG),
        # Noise: K14, table 1. Data sheet at 16 g, from memory: 12 mg a digit; raw +-60 mg at zero.
        accelerometer=TriadErrors(
            noise_sd=4e-2, bias_sd=0.05, instability_sd=0.1 * _MILLI_G, instability_time_s=100.0,
            walk=0.0, scale_sd=0.002, axes_deg=0.2, turn_deg=0.3, limit=16.0 * STANDARD_GRAVITY,
            resolution=12.0 * _MILLI_G),
        # Table 1 prints 1e-3 mG, a thousandth of the device's digit: read as 1e-3 G. Data sheet at 1.3 G,
        # from memory: 1090 digits a gauss. What calibration leaves of hard and soft iron is chosen.
        magnetometer=TriadErrors(
            noise_sd=1.0 * _MILLI_GAUSS, bias_sd=0.5 * _MICRO_TESLA, instability_sd=0.0,
            instability_time_s=100.0, walk=0.0, scale_sd=0.01, axes_deg=0.4, turn_deg=0.3,
            limit=1.3e3 * _MILLI_GAUSS, resolution=1e3 / 1090.0 * _MILLI_GAUSS),
        soft_iron=0.01, without=("forearm",), mag_sites=("hand", "F1d", "F2d", "F3d", "F4d", "F5d"),
        # The paper calibrates each sensor to its segment (eq. 34): what that leaves is not stated.
        mounting_angle_deg=(0.0, 0.0)),
    "salchow2019": Preset(
        # .01 deg/s a root hertz, scale +-3 %, cross-axis +-2 %, 16.4 digits a deg/s; zero rate +-5 deg/s raw.
        gyroscope=TriadErrors(
            noise_sd=0.01 * math.sqrt(50.0) * _DEG, bias_sd=0.0035,
            instability_sd=10.0 * _DEG / 3600.0, instability_time_s=100.0, walk=0.0, scale_sd=0.01,
            axes_deg=0.02 / 3.0 / _DEG, turn_deg=0.3, limit=2000.0 * _DEG, resolution=_DEG / 16.4),
        # .3 mg a root hertz, 2048 digits a g; raw: zero +-60 mg, scale +-3 %, cross-axis +-2 %.
        accelerometer=TriadErrors(
            noise_sd=0.3 * math.sqrt(50.0) * _MILLI_G, bias_sd=0.05,
            instability_sd=0.05 * _MILLI_G, instability_time_s=100.0, walk=0.0, scale_sd=0.002,
            axes_deg=0.2, turn_deg=0.3, limit=16.0 * STANDARD_GRAVITY,
            resolution=STANDARD_GRAVITY / 2048.0),
        # AK8963, from memory: .15 uT a digit, 4912 uT; noise of .6 uT and what calibration leaves: chosen.
        magnetometer=TriadErrors(
            noise_sd=0.6 * _MICRO_TESLA, bias_sd=1.0 * _MICRO_TESLA, instability_sd=0.0,
            instability_time_s=100.0, walk=0.0, scale_sd=0.01, axes_deg=0.02 / 3.0 / _DEG, turn_deg=0.5,
            limit=4912.0 * _MICRO_TESLA, resolution=0.15 * _MICRO_TESLA),
        soft_iron=0.01, without=("forearm",), mag_sites=None,
        # "in the order of 5 to 10 degrees" (section 4, of sensor-to-segment alignment).
        mounting_angle_deg=(5.0, 10.0)),
}
