"""Plausible mistakes in the tables of the stimulated hand, and runs that break: one line each."""

from pathlib import Path

import numpy as np
import pytest

from fesloop.apps.cli import main
from fesloop.experiment.recording.reading import Recording

CHAIN = str(Path(__file__).with_name("chain.toml"))
NAN_POSE = "[nan, 0.0, 0.0, 0.0]"
MISTAKES = {
    "blocks.programme.current_ma=[[-5, 0, 0]]": "blocks.programme.current_ma[0][0]: -5; allowed: a finite",
    "blocks.stimulator.rate=320": "blocks.stimulator.rate: this block has a clock of its own",
    'blocks.stimulator.frequency_hz="100"': "blocks.stimulator.frequency_hz: 100; allowed: 20 to 50",
    'blocks.stimulator.preset="generation4"': "'generation1', 'generation2' or 'generation3'",
    "blocks.stimulator.compliance_v=900.0": "at most 500",
    "blocks.stimulator.electrodes=[{elements=[59]},{elements=[4]},{elements=[5]}]":
        "blocks.stimulator.electrodes[0].elements: element 59 does not exist; allowed: 0 to 58",
    "blocks.stimulator.electrodes=[{elements=[5]},{elements=[-1]},{elements=[4]}]":
        "blocks.stimulator.electrodes[1].elements",
    "blocks.stimulator.electrodes=[{elements=[5]},{elements=[4]}]":
        "stimulator.electrodes: 2 virtual electrodes; allowed: 3",
    "blocks.stimulator.electrodes=[{elements=[5, 6], shares=[0.5, 0.6]}]": "that add up to 1",
    "blocks.stimulator.elements=40": "blocks.stimulator.electrodes[1].elements: element 46 does not exist",
    "blocks.electrodes.arrays=[{rows=5, columns=7}]": "'stimulator.elements' has shape (59, 3)",
    'blocks.electrodes.rate="40"': "read at 40 Hz, and 'stimulator.elements' puts out 320 messages a second",
    "blocks.electrodes.skin_gain=[1.0]": "blocks.electrodes.skin_gain: shape (1,)",
    "blocks.electrodes.shift_mm=300.0": "element 0 lies 358 mm from the elbow",
    'blocks.electrodes.motor_points=[{muscle="THENAR", around_deg=0.0, along_mm=9.0, depth_mm=3.0}]':
        "is a muscle of the hand",
    'blocks.muscles.model="hill"': "'hammerstein', 'riener', 'ding2003' or 'ding2007'",
    'blocks.muscles.model="ding2003"': "ding2003.fatigue",
    "blocks.muscles.delay_ms=-1.0": "blocks.muscles.delay_ms: -1.0 is negative",
    'blocks.muscles.reflex.muscles=["FDP"]': "did you mean 'FDP5'?",
    "blocks.muscles.tremor={band_hz=[12.0, 4.0]}": "the lower frequency, then the upper",
    "blocks.hand.object={position_m=[0.0, 0.05, 0.0]}": "blocks.hand.object: reaches 64.7 mm into hand",
    'blocks.hand.object={shape="egg"}': "'cylinder', 'block', 'ball', 'card' or 'mug'",
    'blocks.hand.object={shape="mug", size_mm=[80.0, 90.0, 1.0, 30.0]}': "a wall of 1 mm; allowed: 2 to",
    'blocks.hand.object={shape="ball", size_mm=[1.0, 2.0]}': "blocks.hand.object.size_mm: (1.0, 2.0)",
    "blocks.hand.object={mass_kg=0.0}": "blocks.hand.object.mass_kg",
    "blocks.hand.object={mass_kg=1e-20, position_m=[0.0, 0.1, -0.5]}": "realistic sizes and masses",
    f"blocks.hand.object={{orientation={NAN_POSE}}}": "blocks.hand.object.orientation[0]: nan",
    f"blocks.hand.forearm_orientation={NAN_POSE}": "blocks.hand.forearm_orientation[0]: nan",
    "blocks.hand.table={height_m=-0.07}": "blocks.hand.object: reaches 30.0 mm into table",
    "blocks.hand.table={height_m=0.0, centre_m=[0.0, 0.07], half_m=[0.02, 0.02]}":
        "blocks.hand.table: reaches",
    "blocks.hand.splint_deg={wrist_flexon=0.0}": "blocks.hand.splint_deg.wrist_flexon: is not a freedom",
    "blocks.hand.splint_deg={wrist_flexion=200.0}": "blocks.hand.splint_deg.wrist_flexion: 200",
    "blocks.hand.start_deg={F2_pip_flexion=nan}": "blocks.hand.start_deg.F2_pip_flexion: nan",
    "blocks.hand.strength=[1.0, 2.0]": "blocks.hand.strength: 2 factors; allowed: 29, or none",
    "blocks.hand.step_ms=50.0": "blocks.hand.step_ms: 50; allowed: 0.01 to 10 ms",
    "blocks.hand.hand={hand_mm=1.0}": "blocks.hand.hand.hand_mm: 1 mm; allowed: 100 to 260 mm",
}


@pytest.mark.parametrize("setting", MISTAKES)
def test_a_mistake_is_one_line(setting, capsys):
    code = main(["check", CHAIN, "--set", setting])
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert MISTAKES[setting] in line


def test_a_hand_that_becomes_unstable_ends_the_run_and_what_was_is_kept(capsys, tmp_path):
    """With muscles 1000 times as strong, some time after the start."""
    strength = ", ".join(["1e3"] * 29)
    code = main(["run", CHAIN, "--set", f"blocks.hand.strength=[{strength}]", "--out", str(tmp_path)])
    out, err = capsys.readouterr()
    (line,) = [line for line in err.splitlines() if line.startswith("fesloop:")]
    assert code == 1
    assert "Traceback" not in err
    assert "hand became unstable at " in line
    broke_ns = 1_000_000 * int(line.partition(" ms:")[0].rpartition(" ")[2])
    with Recording(out.strip()) as recording:
        seen = recording.signal("hand.angles")
        assert recording.status == "failed"
        assert seen.times_ns[-1] == broke_ns - 1_000_000
        assert np.isfinite(seen.values).all()
        assert len(seen.values) > 20
        (event,) = [event for event in recording.events if event.status == "failed"]
    assert (event.where, event.time_ns) == ("loop", broke_ns - 1_000_000)
    assert event.detail in line


@pytest.mark.parametrize(("setting", "told"), [
    ("blocks.programme.current_ma=[[200, 0, 0]]", "current_limited"),
    ("blocks.programme.width_us=[[900, 0, 0]]", "width_limited"),
    ("blocks.programme={kind='programme', rate='40', times_s=[0], current_ma=[[60, 0, 0]], "
     "width_us=[[500, 0, 0]]}", "charge_limited")])
def test_stimulation_outside_a_range_is_cut_and_told_once(setting, told, capsys, tmp_path):
    arguments = ["--set", setting, "--set", "experiment.duration_s=0.3", "--out", str(tmp_path)]
    assert main(["run", CHAIN, *arguments]) == 0
    with Recording(capsys.readouterr().out.strip()) as recording:
        assert [event.where for event in recording.events if event.status == told] == ["safety"]
        given = recording.signal("stimulator.elements").values
        assert 0.0 < given[:, :, 0].max() <= 60e-3
        assert given[:, :, 1].max() <= 500e-6
        assert (given[:, :, 0] * given[:, :, 1]).max() <= 20e-6
