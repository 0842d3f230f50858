"""`unmoved_rmse_deg` is the error of a run in which nothing moves, whatever the run itself did."""

import numpy as np
import pytest

import fesloop


@pytest.mark.parametrize("after_s", [0.0, 1.0, 2.5])
def test_it_does_not_depend_on_what_controls(after_s, tmp_path):
    """Minimum jerk from rest: its mean square about the first posture from `after_s` on, at 1 kHz."""
    settings = [f"score.after_s={after_s}", "experiment.duration_s=3", "tracker=ideal"]
    told = {}
    for control in ("pid", "mpc"):
        done = fesloop.load("finger_control", [*settings, f"control={control}"]).run(out=tmp_path)
        told[control] = done.metrics["unmoved_rmse_deg"][0]
        with fesloop.Recording(done.recording) as recording:
            truth, wanted = recording.signal("patient.angles"), recording.signal("reference.angles")
        rows = np.searchsorted(wanted.times_ns, truth.times_ns, side="right") - 1
        scored = truth.times_ns >= after_s * 1e9
        away = np.degrees(wanted.values[rows][scored] - truth.values[0])
        assert told[control] == pytest.approx(np.sqrt(np.mean(np.square(away))), rel=1e-6)
    assert told["pid"] == pytest.approx(told["mpc"], rel=1e-6)
