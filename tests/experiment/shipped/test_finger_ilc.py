"""What `finger_ilc` says of its law before it runs, and whether it comes true."""

from itertools import pairwise

import fesloop
from fesloop.apps.cli import main
from fesloop.experiment.recording.reading import Recording

DIVERGES = ["law=phase_lead", "gain=2.5", "trials=4"]


def test_a_law_that_diverges_says_so_beforehand(tmp_path, capsys):
    assert main(["check", "finger_ilc", *(part for each in DIVERGES for part in ("--set", each))]) == 0
    assert "may_diverge" in capsys.readouterr().out
    result = fesloop.load("finger_ilc", DIVERGES).run(tmp_path)
    errors = result.metrics["joint_rmse_deg"]
    assert all(later > earlier for earlier, later in pairwise(errors))
    assert errors[-1] > 2.0 * errors[0]
    with Recording(result.recording) as recording:
        (told,) = [event for event in recording.events if event.status == "may_diverge"]
    assert told.trial == 0
    assert told.time_ns == 0
    assert "times as strong as the model" in told.detail


def test_phase_lead_whose_condition_holds_says_nothing_and_learns(tmp_path, capsys):
    assert main(["check", "finger_ilc", "--set", "law=phase_lead"]) == 0
    assert "Cautions" not in capsys.readouterr().out
    result = fesloop.load("finger_ilc", ["law=phase_lead", "trials=4"]).run(tmp_path)
    errors = result.metrics["joint_rmse_deg"]
    assert all(later < earlier for earlier, later in pairwise(errors))
