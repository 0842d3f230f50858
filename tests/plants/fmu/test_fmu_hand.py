"""An FMU of a hand as others make them, of five joints in degrees, in the whole hand's place in its loop."""

from pathlib import Path

import numpy as np
import pytest

import fesloop
from fesloop import Recording
from fesloop.errors import InputError

WHOLE_HAND = Path(__file__).resolve().parents[2] / "experiment" / "whole_hand.toml"
OPTION = """
[variants.plant.others]
description = "a hand that others made, of five joints"
remove = ["patient", "blocks.stimulator", "blocks.electrodes", "blocks.muscles", "blocks.hand", "blocks.imus",
          "blocks.tracker"]
wires = [
    { from = "safety.stimulation", to = "hand.stimulation", latency_ms = 5 },
    { from = "hand.angles", to = "tracker.angles" },
    { from = "tracker.angles", to = "synergies.angles", latency_ms = 20 },
    { from = "tracker.angles", to = "safety.posture", latency_ms = 10 },
    { from = "hand.angles", to = "truth.angles" },
]

[variants.plant.others.blocks]
tracker = { kind = "ideal", rate = "100", noise_deg = 0.2 }

[variants.plant.others.blocks.synergies]
freedoms = ["thumb", "index_mcp", "index_pip", "middle_mcp", "middle_pip"]
weights.finger_flexion = { index_mcp = 0.25, index_pip = 0.25, middle_mcp = 0.25, middle_pip = 0.25 }

[variants.plant.others.blocks.truth]
freedoms = ["thumb", "index_mcp", "index_pip", "middle_mcp", "middle_pip"]
weights.finger_flexion = { index_mcp = 0.25, index_pip = 0.25, middle_mcp = 0.25, middle_pip = 0.25 }

[variants.plant.others.blocks.hand]
kind = "fmu"
path = "PATH"
step_rate = "400"

[[variants.plant.others.blocks.hand.input_ports]]
name = "stimulation"
variables = ["extensor.current_ma", "extensor.width_us", "flexor.current_ma", "flexor.width_us"]
shape = [2, 2]
unit = "A,s"
scale = [1e3, 1e6]

[[variants.plant.others.blocks.hand.output_ports]]
name = "angles"
variables = ["thumb.ip.angle_deg", "index.mcp.angle_deg", "index.pip.angle_deg", "middle.mcp.angle_deg",
             "middle.pip.angle_deg"]
unit = "rad"
scale = 57.29577951308232
"""


@pytest.fixture
def file(python_fmu, tmp_path):
    path = tmp_path / "whole_hand.toml"
    path.write_text(WHOLE_HAND.read_text() + OPTION.replace("PATH", str(python_fmu(2, script="hand"))))
    return path


@pytest.mark.slow
def test_it_is_controlled_in_the_sums_of_its_own_joints(file, tmp_path):
    own = ["blocks.controller.model.b=[[0, 0], [-50, 100]]",  # a rough model of that FMU
           "blocks.controller.model.recruitment={threshold_ma=[4.0, 6.0], spread=[0.3, 0.3]}"]
    result = fesloop.load(file, ["plant=others", *own]).run(tmp_path)
    first, second = result.metrics["joint_rmse_deg"]
    assert first > 5.0
    assert second < 0.5 * first
    with Recording(result.recording) as recording:
        angles = recording.signal("hand.angles", 1).values
        np.testing.assert_allclose(angles[0], np.deg2rad([15.0, 25.0, 25.0, 25.0, 25.0]))
        moved = np.ptp(angles, axis=0)
        np.testing.assert_allclose(moved / moved[1], [1 / 3, 1.0, 1.5, 1.0, 1.5], rtol=1e-6)
        pulses = recording.signal("safety.stimulation", 1).values
        charge_uc = 1e6 * np.prod(pulses, axis=-1)
        drive = np.clip((charge_uc[:, 1] - charge_uc[:, 0]) / 5.0, -1.0, 1.0)
        assert np.rad2deg(angles[:, 1].max()) <= 25.0 + 30.0 * drive.max()


@pytest.mark.parametrize(("before", "after", "found"), [
    ('"middle.pip.angle_deg"]', '"middle.pip.angle"]', "did you mean 'middle.pip.angle_deg'"),
    ('"middle.pip.angle_deg"]', "]", "hand.angles has shape (4,)|(4,)"),
    ("scale = [1e3, 1e6]", "scale = [1e3]", "1 scales"),
    ('"middle_pip"]\nweights', '"middle_dip"]\nweights', "freedom 'middle_pip'"),
])
def test_what_does_not_fit_the_fmu_is_named(file, before, after, found):
    text = file.read_text()
    assert before in text
    file.write_text(text.replace(before, after, 1))
    with pytest.raises(InputError) as refused:
        fesloop.load(file, ["plant=others"])
    assert any(each in str(refused.value) for each in found.split("|"))
