"""What a shift between estimates and reference can come from, and half a sample that VQF is ahead by."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.fusion.front_end import VqfBank
from fesloop.apps.cli.fit_error_command import delay_text

RATES_HZ = (25.0, 50.0, 100.0)


@settings(deadline=None, max_examples=60)
@given(st.floats(1.1, 500.0), st.floats(0.5, 50.0))
def test_a_shift_is_told_either_way_and_only_more_than_half_a_sample_is_the_references(shift, half):
    behind, ahead = delay_text(-shift, half, True), delay_text(shift, half, True)
    assert f"{shift:.3g} ms behind the reference" in behind
    assert f"--reference-late {-shift - half:.3g} " in behind
    assert f"{shift:.3g} ms ahead of the reference" in ahead
    assert f"half a sample ahead, {half:.3g} ms" in ahead
    assert ("--reference-late" in ahead) == (shift - half > 1.0)
    if shift - half > 1.0:
        assert f"--reference-late {shift - half:.3g} " in ahead


@settings(deadline=None, max_examples=20)
@given(st.floats(1.1, 500.0))
def test_a_tracker_that_leads_by_nothing_leaves_all_to_the_reference(shift):
    assert f"--reference-late {shift:.3g} corrects" in delay_text(shift, 0.0, True)
    assert "half a sample" not in delay_text(shift, 0.0, True)
    assert f"--reference-late {-shift:.3g} corrects" in delay_text(-shift, 0.0, True)


@pytest.mark.parametrize("recorded", [False, True])
def test_hardly_any_shift_is_not_told(recorded):
    assert delay_text(0.9, 20.0, recorded) == delay_text(-0.9, 20.0, recorded) == ""


def test_a_simulated_truth_is_not_called_late():
    for shift in (-30.0, 30.0):
        told = delay_text(shift, 5.0, False)
        assert "30 ms" in told
        assert "reference" not in told


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_vqf_is_half_a_sample_ahead_of_rates_of_an_instant(rate_hz):
    """About the vertical, where nothing but the gyroscope tells; of rates that are means it is not ahead."""
    times = np.arange(0.0, 40.0, 1.0 / rate_hz)

    def angle(at):
        return 0.6 * np.sin(2.0 * at)

    rate = 1.2 * np.cos(2.0 * times)
    mean = np.diff(angle(times), prepend=angle(-1.0 / rate_hz)) * rate_hz
    for about, lead_s in ((rate, 0.5 / rate_hz), (mean, 0.0)):
        bank = VqfBank(1, 1.0 / rate_hz, False, motionBiasEstEnabled=False, restBiasEstEnabled=False)
        turned = []
        for each in about:
            bank.update(np.array([[0.0, 0.0, each]]), np.array([[0.0, 0.0, 9.81]]), None)
            q = bank.orientation()[0]
            turned.append(2.0 * np.arctan2(q[3], q[0]))
        error = np.unwrap(turned) - angle(times)
        assert np.polyfit(rate, error, 1)[0] == pytest.approx(lead_s, abs=3e-4)
