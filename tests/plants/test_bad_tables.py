"""Plausible mistakes in the tables of the hand and its sensors: each is one line, key and remedy."""

import pytest

from fesloop.apps.cli import main

HAND = 'blocks.hand={kind="moving_hand", %s}'
PHASE = HAND % "phases=[{%s}]"
MISTAKES = {
    "motion=P7": "no script is named 'P7'",
    "blocks.hand.pose_error_deg={F2_pip_flexin=3.0}": "F2_pip_flexin",
    "blocks.hand.pose_error_deg={F2_pip_flexion=90.0}": "-60 to 60 deg",
    "blocks.hand.repeat_sd_deg=-1.0": "0 to 30 deg",
    "blocks.hand.rest_deg={F2_pip_flexion=10.0}": "is given with a script",
    "blocks.hand.forearm_orientation=[2.0, 0.0, 0.0, 0.0]": "of length 1",
    'blocks.hand={kind="moving_hand"}': "phases, the name of a script, or recorded angles",
    PHASE % "duration_s=-1.0": "phases[0].duration_s",
    PHASE % "duration_s=1.0, posture_deg={F2_pip=3.0}": "'F2_pip'",
    PHASE % 'duration_s=1.0, contacts=[{first="F1", second="F2 tip"}]': "contacts[0].first",
    PHASE % 'duration_s=1.0, contacts=[{first="F1 tip", second="F1 top"}]': "a point of another finger",
    PHASE % "duration_s=1.0, arm={turn_deg=[1.0, 2.0]}": "arm.turn_deg[2]: is missing",
    PHASE % "duration_s=1.0, cycles=2, stay_s=0.5": "less than half of duration_s",
    "blocks.imus.preset=salchow": "'salchow2019'",
    'blocks.imus.sites=["hand", "F1x"]': "'F1x'",
    'blocks.imus.measures=["gyro"]': "'gyr', 'acc' or 'mag'",
    "blocks.imus.mounting_angle_deg=[10.0, 5.0]": "smallest <= largest",
    "blocks.imus.mounting_angle_deg=[5.0, 500.0]": "within 0 to 180",
    "blocks.imus.loss=1.0": "below 1",
    "blocks.imus.gyroscope={bias=0.1}": "did you mean 'bias_sd'?",
    "blocks.imus.gyroscope={instability_time_s=0.0}": "above 0",
    "blocks.imus.soft_tissue={damping=1.5}": "above 0 and below 1",
    "blocks.imus.soft_tissue={outwards=[1.0, 1.0, 0.0]}": "of length 1",
    "blocks.imus.magnetic_field={strength_ut=-1.0}": "0 or more",
    "blocks.imus.magnetic_field={inclination_deg=100.0}": "from -90 to 90",
    "blocks.imus.magnetic_field={dipoles=[{position=[0.0, 0.0, 0.0]}]}": "dipoles[0].moment: is missing",
    'blocks.imus.magnetic_field={dipoles=[{position=[0.0, 0.0, 0.0], moment=[1.0, 0.0, 0.0], '
    'carrier="thumb"}]}': "'thumb'",
    "blocks.imus.tremor={band_hz=[12.0, 8.0]}": "the lowest first",
    "blocks.imus.tremor={rise_s=0.0}": "above 0",
    "blocks.imus.artefacts={window_ms=-1.0}": "above 0",
    "blocks.imus.artefacts={}": "imus.pulses",
    "blocks.imus.pulses={full_charge_uc=0.0}": "above 0",
    'blocks.force={kind="fingertip_force", rate="100"}': "'fingertip_force' is now called 'force_sensors'",
    'blocks.force={kind="force_sensors", rate="100", sensors=5}': "'sensors' is now called 'places'",
    'blocks.force={kind="force_sensors", rate="100", places=["F2x"]}': "'F2x' is no part of the hand",
    'blocks.force={kind="force_sensors", rate="100", range_n=0.0}': "above 0",
    'blocks.force={kind="force_sensors", rate="100", noise_sd=-1.0}': "0 or more",
    'blocks.force={kind="force_sensors"}': "blocks.force.rate: is missing",
    'blocks.force={kind="force_sensors", rate="100"}': "force.contact_force",
    'score.trackers=["salchow_m3"]': "'salchow_m3.fingertips'",
    'score.tips=["F1"]': "5, one a fingertip",
    'record.leave_out=["hand.fingertips"]': "left out of the recording",
}


@pytest.mark.parametrize("setting", MISTAKES)
def test_a_mistake_is_one_line(setting, capsys):
    code = main(["check", "salchow2019", "--set", setting])
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert MISTAKES[setting] in line


def test_angles_for_places_are_of_another_unit_and_shape(capsys):
    assert main(["check", "salchow2019", "--set", "score.fingertips=hand.angles"]) == 2
    unit, shape = capsys.readouterr().err.splitlines()
    assert "a signal in 'm'" in unit
    assert "(tips, 3), positions" in shape
