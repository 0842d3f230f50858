"""Presets: what is given stands, what is left open is the hardware's; and a table of a file says as much."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from pydantic import TypeAdapter

from fesloop.errors import InputError
from fesloop.forms import schema
from plants.imus.block import HAND_SITES, Imus
from plants.imus.device import NUMBERS, PRESETS, TriadErrors
from plants.imus.disturbances import Dipole, MagneticField

TABLE = {
    "measures": ["acc", "mag"], "preset": "kortier2014", "sites": ["hand", 3, "F2d"], "loss": 0.01,
    "gyroscope": {"noise_sd": 0}, "accelerometer": {"limit": 80.0}, "soft_tissue": {"natural_hz": 6},
    "magnetic_field": {"strength_ut": 50, "dipoles": [
        {"position": [1, 0, 0.2], "moment": [1, 0, 0]},
        {"position": [0, 0.02, 0], "moment": [0, 0.1, 0], "carrier": "hand"}]},
    "tremor": {}, "artefacts": {"window_ms": 2}}


def made(table):
    """From a table, as an experiment file makes it."""
    checked = TypeAdapter(schema.table(Imus, {})).validate_json(json.dumps(table))
    return schema.make(Imus, checked, {}, "blocks.imus")


@pytest.mark.parametrize("preset", list(PRESETS))
def test_every_number_of_a_preset_is_given(preset):
    found = PRESETS[preset]
    for triad in (found.gyroscope, found.accelerometer, found.magnetometer):
        assert np.isfinite(triad.numbers()).all()
        assert len(triad.numbers()) == len(NUMBERS)


def test_kortiers_table_1_and_hardware():
    imus = Imus(preset="kortier2014")
    assert imus.gyroscope.noise_sd == 5e-4
    assert imus.gyroscope.walk == 1e-4
    assert imus.accelerometer.noise_sd == 4e-2
    assert imus.gyroscope.limit == pytest.approx(math.radians(2000.0))
    assert imus.sites == HAND_SITES[1:]
    assert imus.mag_sites == ("hand", "F1d", "F2d", "F3d", "F4d", "F5d")


def test_the_mpu_9250s_data_sheet():
    imus = Imus(preset="salchow2019")
    assert 1.0 / math.degrees(imus.gyroscope.resolution) == pytest.approx(16.4)
    assert 9.80665 / imus.accelerometer.resolution == pytest.approx(2048.0)
    assert math.degrees(imus.gyroscope.noise_sd) == pytest.approx(0.01 * math.sqrt(50.0))
    # Calibrated: well inside the raw zero rate of +-5 deg/s and offset of +-60 mg.
    assert math.degrees(3.0 * imus.gyroscope.bias_sd) < 1.0
    assert 3.0 * imus.accelerometer.bias_sd < 0.02 * 9.80665
    assert imus.mounting_angle_deg == (5.0, 10.0)
    assert imus.sites == HAND_SITES[1:]
    assert len(Imus(sites=("forearm",)).outputs) == 3


def test_sensors_without_calibration_have_the_data_sheets_errors_and_the_same_noise():
    raw, calibrated = Imus(preset="salchow2019_raw"), Imus(preset="salchow2019")
    assert math.degrees(3.0 * raw.gyroscope.bias_sd) == pytest.approx(5.0)
    assert 3.0 * raw.accelerometer.bias_sd == pytest.approx(0.06 * 9.80665)
    assert 3.0 * raw.accelerometer.scale_sd == pytest.approx(0.03)
    for kind in ("gyroscope", "accelerometer", "magnetometer"):
        one, other = getattr(raw, kind), getattr(calibrated, kind)
        assert (one.noise_sd, one.limit, one.resolution) == (other.noise_sd, other.limit, other.resolution)
        assert one.turn_deg > other.turn_deg
        assert one.bias_sd > other.bias_sd


def test_what_is_given_stands_even_where_it_is_zero():
    imus = Imus(preset="salchow2019", gyroscope=TriadErrors(noise_sd=0.0), soft_iron=0.0,
                mounting_angle_deg=(0.0, 0.0), mag_sites=("hand",))
    assert imus.gyroscope == replace(PRESETS["salchow2019"].gyroscope, noise_sd=0.0)
    assert imus.accelerometer == PRESETS["salchow2019"].accelerometer
    assert (imus.soft_iron, imus.mounting_angle_deg, imus.mag_sites) == (0.0, (0.0, 0.0), ("hand",))
    assert replace(imus, loss=0.1).gyroscope == imus.gyroscope


def test_a_strip_left_off_takes_its_magnetometer_with_it():
    imus = Imus(preset="kortier2014", sites=("hand", "F2p", "F2m", "F2d"))
    assert [port.shape for port in imus.outputs] == [(4, 3)] * 3


def test_a_table_makes_the_object_and_the_object_the_table():
    imus = made(TABLE)
    assert imus.sites == ("hand", 3, "F2d")
    assert imus.gyroscope.noise_sd == 0.0
    assert imus.gyroscope.walk == 1e-4
    assert imus.accelerometer.limit == 80.0
    assert imus.magnetic_field == MagneticField(strength_ut=50.0, dipoles=(
        Dipole(position=(1.0, 0.0, 0.2), moment=(1.0, 0.0, 0.0)),
        Dipole(position=(0.0, 0.02, 0.0), moment=(0.0, 0.1, 0.0), carrier="hand")))
    plain = schema.plain(imus)
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert made(plain) == imus


@pytest.mark.parametrize(("table", "found"), [
    ({"sites": ["hnad"]}, "blocks.imus.sites: 'hnad'"),
    ({"magnetic_field": {"strength_ut": -1}}, "blocks.imus.magnetic_field.strength_ut: -1.0"),
    ({"accelerometer": {"limit": -1}}, "blocks.imus.accelerometer.limit: -1.0"),
    ({"soft_tissue": {"damping": 2}}, "blocks.imus.soft_tissue.damping: 2.0")])
def test_faults_are_named_by_their_key(table, found):
    with pytest.raises(InputError, match=found):
        made(table)
