"""`fesloop bench shipped`: what files say of their time is what it takes, to an order of magnitude."""

import pytest

from fesloop.apps.bench import shipped
from fesloop.errors import RunError
from fesloop.experiment.files.layout import Guide, guide_of
from fesloop.experiment.files.parse import read


@pytest.mark.slow
def test_what_a_file_says_is_within_a_factor_of_what_it_takes(monkeypatch):
    """CPU time of a start and a short run; a slow or busy machine takes several times as long."""
    monkeypatch.setattr(shipped, "shipped", lambda: ["finger_control", "hil_twin", "tracker_hour"])
    row, = shipped.run(short=True)["rows"]
    assert row["case"] == "finger_control"
    assert row["reference_us_median"] == 1e6 * guide_of(read("finger_control")[1]).takes_s
    assert 0.1 < row["ratio"] < 10.0


def test_what_cannot_run_here_is_left_out_and_what_fails_is_told(monkeypatch):
    guide = Guide(job="hardware", takes_s=1.0)
    assert shipped.seconds_of("replay", guide) is None
    monkeypatch.setattr(shipped.sys, "executable", "false")
    with pytest.raises(RunError, match="fesloop run finger_control"):
        shipped.seconds_of("finger_control", guide)
