"""The PID in C equals the block."""

from __future__ import annotations

import numpy as np
import pytest
from c_code_parts import QUICK, STRICT, build, needs_gcc, record_type, run, stepped
from c_controller_parts import RATE, hour, pid, pid_program
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.pid.block import Pid
from fesloop.loop.clock import NS_PER_S
from fesloop.models.linear_model import Recruitment

pytestmark = needs_gcc


@pytest.mark.parametrize("curve", ["lognormal", "linear"])
def test_an_hour_is_the_blocks_to_the_last_digits(tmp_path, curve):
    block = pid(recruitment_curve=curve)
    exported = pid_program(block)
    records = hour(record_type(exported), 3600, np.random.default_rng(1))
    ours = run(build(exported, tmp_path, STRICT), exported, records)[:, 1:]
    theirs = stepped(block, exported, RATE, records)
    assert np.ptp(theirs) > 1e-4
    assert np.abs(ours - theirs).max() < 1e-9


@settings(max_examples=8, deadline=None)
@given(st.data())
def test_any_parameters_give_the_blocks_outputs(tmp_path_factory, data):
    joints, muscles = data.draw(st.integers(1, 3)), data.draw(st.integers(1, 4))
    gain = st.floats(-3.0, 3.0)
    row = st.tuples(*[gain] * joints)
    block = Pid(kp=data.draw(row), ki=data.draw(row), kd=data.draw(row),
                mixing=data.draw(st.tuples(*[row] * muscles)), current_ma=(30.0,) * muscles,
                derivative_filter_ms=data.draw(st.floats(0.0, 200.0)),
                recruitment_curve=data.draw(st.sampled_from(["lognormal", "linear"])),
                recruitment=Recruitment(threshold_ma=(9.0,) * muscles, spread=(0.3,) * muscles))
    exported = pid_program(block)
    records = np.zeros(300, record_type(exported))
    records["time_ns"] = records["measured_newest_ns"] = np.arange(300) * (NS_PER_S // 50)
    rng = np.random.default_rng(data.draw(st.integers(0, 999)))
    records["reference"], records["measured"] = rng.normal(0.0, 1.0, (2, 300, joints))
    folder = tmp_path_factory.mktemp("pid")
    ours = run(build(exported, folder, QUICK), exported, records)[:, 1:]
    theirs = stepped(block, exported, RATE, records)
    assert np.abs(ours - theirs).max() < 1e-9
