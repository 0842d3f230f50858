"""Reference and measurement of a controller are compared before anything runs."""

import pytest

from fesloop.apps.cli import main
from fesloop.errors import InputError
from fesloop.experiment.files.parse import from_document, load

ROWS = ["wrist_extension", "finger_flexion"]
PHASES = [{"name": "rest", "duration_s": 0.5, "deg": {"wrist_extension": -20, "finger_flexion": 30}},
          {"name": "open", "duration_s": 0.5, "deg": {"wrist_extension": 20}}]

FAR = """
[experiment]
name = "far"
duration_s = 1

[blocks.reference]
kind = "grasp_phases"
rate = "40"
rows = ["wrist_extension", "finger_flexion"]
phases = [
  { name = "rest", duration_s = 0.5, deg = { wrist_extension = -20, finger_flexion = 30 } },
  { name = "open", duration_s = 0.5, deg = { wrist_extension = 20 } },
  { name = "close", duration_s = 0.5, deg = { finger_flexion = 130 } },
]
"""


def controlled(reference, rows=ROWS):
    """A hand that moves by a script, measured as synergies."""
    pid = {"kind": "pid", "rate": "40", "kp": [0.4] * 2, "ki": [0.0] * 2, "kd": [0.0] * 2,
           "mixing": [[1.0, 0.0], [0.0, 1.0]], "current_ma": [20, 20],
           "recruitment": {"threshold_ma": [10.0, 10.0], "spread": [0.35, 0.35]}}
    return {"experiment": {"name": "controlled", "duration_s": 1.0},
            "blocks": {"reference": {"rate": "40", **reference}, "controller": pid,
                       "hand": {"kind": "moving_hand", "phases": [{"duration_s": 1.0}]},
                       "synergies": {"kind": "synergies", "rate": "40", "rows": list(rows)}},
            "wires": [{"from": "reference.angles", "to": "controller.reference"},
                      {"from": "hand.angles", "to": "synergies.angles"},
                      {"from": "synergies.synergies", "to": "controller.measured"}]}


def jerk(*angles_deg):
    return {"kind": "minimum_jerk", "times_s": [float(i) for i in range(len(angles_deg))],
            "angles_deg": [list(angle) for angle in angles_deg]}


def test_the_same_rows_in_the_same_order_are_taken():
    for reference in ({"kind": "grasp_phases", "rows": ROWS, "phases": PHASES},
                      jerk((-20.0, 30.0), (-75.0, 95.0), (70.0, -32.5)),
                      {**jerk((-20.0, 30.0)), "rows": ROWS}):
        nodes = {node.name: node.part for node in from_document(controlled(reference)).nodes}
        assert nodes["reference"].outputs[0].shape == nodes["controller"].inputs[0].shape == (len(ROWS),)


@pytest.mark.parametrize(("rows", "named"), [
    (ROWS[::-1], "blocks.reference.rows: wrist_extension, finger_flexion; allowed: finger_flexion, "
                 "wrist_extension, as synergies has that controller measures; give both the same rows"),
    (["wrist_extension", "thumb_flexion"], "allowed: wrist_extension, thumb_flexion"),
])
def test_other_rows_or_another_order_are_named(rows, named):
    with pytest.raises(InputError, match=named):
        from_document(controlled({"kind": "grasp_phases", "rows": ROWS, "phases": PHASES}, rows))


@pytest.mark.parametrize(("angles", "named"), [
    ((-80.0, 30.0), "-80 deg is outside the range of motion of wrist_extension; allowed: -75 to 70 deg"),
    ((0.0, 100.0), "100 deg is outside the range of motion of finger_flexion; allowed: -32.5 to 95 deg"),
])
def test_angles_without_names_have_the_range_of_what_is_measured(angles, named):
    with pytest.raises(InputError, match=f"blocks.reference: {named}"):
        from_document(controlled(jerk((0.0, 0.0), angles)))


@pytest.mark.parametrize("name", ["finger_ilc", "finger_mpc", "finger_pid_latency"])
def test_shipped_references_keep_to_the_finger(name):
    with pytest.raises(InputError, match=r"angles_deg\[1\]\[1\]: 145 deg .* of F2_pip_flexion; .*100 deg"):
        load(name, ["blocks.reference.angles_deg.1.1=145"])


@pytest.mark.parametrize("command", ["check", "run"])
def test_the_command_line_says_it_in_one_line_with_exit_code_2(tmp_path, capsys, command):
    path = tmp_path / "far.toml"
    path.write_text(FAR)
    assert main([command, str(path)]) == 2
    told = [line for line in capsys.readouterr().err.splitlines() if "range of motion" in line]
    assert len(told) == 1
    assert "blocks.reference.phases[2].deg.finger_flexion: 130 deg" in told[0]
    assert "stay within it, or give a range_deg of your own" in told[0]
