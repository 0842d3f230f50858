"""Iterative learning control in C equals the block, over trials."""

from __future__ import annotations

import numpy as np
import pytest
from c_code_parts import QUICK, STRICT, build, needs_gcc, record_type, run, stepped
from c_controller_parts import RATE, ilc, ilc_program, trials

import fesloop
from controllers.c_export.ilc import LAWS
from controllers.ilc.block import Ilc


def farthest(exported, block: Ilc, records: np.ndarray, binary) -> float:
    """Greatest difference of currents in A and of pulses as shares of the longest."""
    ours, theirs = run(binary, exported, records), stepped(block, exported, RATE, records)
    assert np.ptp(theirs) > 1e-4
    far = np.abs(ours[:, 1:] - theirs)
    far[:, 1::2] /= 1e-6 * block.width_max_us
    return float(far.max())


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_an_hour_of_trials_is_the_blocks_to_the_last_digits(tmp_path, law):
    block = ilc(law=law, stop_after=0)
    exported = ilc_program(block)
    records = trials(block, record_type(exported), 596, 1)  # of 6.04 s
    far = farthest(exported, block, records, build(exported, tmp_path, QUICK))
    print(f"{law}: greatest difference {far:.2g}")
    assert far < 1e-9


@needs_gcc
@pytest.mark.parametrize(
    ("law", "changes"),
    [
        ("noilc", {"begin_s": 0.5, "first_drive": (0.1, 0.0, 0.2, 0.05), "forgetting": 0.1}),
        ("gradient", {"align_captures": False, "max_gap_ms": 41.0}),
        ("phase_lead", {"gain": 2.5, "cutoff_hz": 5.0}),
        ("phase_lead", {"gain": 1.0, "cutoff_hz": 0.0, "lead_ms": 60.0}),
    ],
)
def test_some_trials_under_sanitizers_are_the_blocks(tmp_path, law, changes):
    block = ilc(law=law, duration_s=4.0, **changes)
    exported = ilc_program(block, "measured_sd", "trusted")
    records = trials(block, record_type(exported), 9, 2)
    assert farthest(exported, block, records, build(exported, tmp_path, STRICT)) < 1e-9


@pytest.mark.parametrize(("changes", "wired", "where"), [
    ({"law": "noilc_constrained"}, (), "control.law"), ({"law": "newton"}, (), "control.law"),
    ({"trial_charge_max_uc": 500.0}, (), "control.trial_charge_max_uc"), ({}, ("force",), "control.force")])
def test_what_c_lacks_is_refused(changes, wired, where):
    with pytest.raises(fesloop.InputError, match=f"{where}.*not available in C"):
        ilc_program(ilc(**changes), *wired)
