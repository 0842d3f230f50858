"""`pid` as C."""

from __future__ import annotations

import numpy as np

from controllers.c_export import common
from controllers.pid.block import Pid
from controllers.timing import period_ns
from fesloop.c_code.program import Operations, Program, array, define, template
from fesloop.loop.block import Context


def program(block: Pid, context: Context, wired: frozenset[str] = frozenset(), ticks: int = 0) -> Program:
    """The controller with the period of its clock."""
    allocation, joints, muscles = block.allocation(), block.joints, block.muscles
    linear = block.recruitment_curve == "linear"
    settings = (
        f"#define JOINTS {joints}", f"#define MUSCLES {muscles}",
        array("KP", block.kp, "drive per rad"), array("KI", block.ki, "drive per rad s"),
        array("KD", block.kd, "drive s per rad"),
        define("DERIVATIVE_FILTER_S", 1e-3 * block.derivative_filter_ms, "s, filter of the derivative"),
        array("MIXING", block.mixing, "drive of each muscle (row) per unit of joint command"),
        array("BIAS", block.bias or (0.0,) * muscles, "drive of each muscle at zero command"),
        array("DRIVE_LEAST", np.full(muscles, -np.inf if linear else 0.0), "least drive"),
        array("DRIVE_GREATEST", allocation.reach(), "drive at the longest pulse"),
        *common.allocation_settings(allocation))
    law = 2 + joints * (13 + 2 * muscles + 7 * muscles) + 3 * muscles
    return Program(
        name=context.name,
        title=f'PID of {joints} joints through {muscles} muscles (fesloop block "pid")',
        period_ns=period_ns(context),
        inputs=block.inputs,
        outputs=block.outputs,
        state=(
            f"double integral[{joints}];   /* drive */",
            f"double derivative[{joints}]; /* drive, filtered */",
            f"double previous[{joints}];   /* rad, measurement of the step before */",
            "int primed;                  /* whether there was one */",
        ),
        sizes={"JOINTS": joints, "MUSCLES": muscles},
        statuses=dict((common.OK, common.NO_INPUT, common.SATURATED, common.NON_FINITE)),
        settings=settings,
        code=(common.head(), common.allocation_code(), template(common.PACKAGE, "pid.c")),
        operations=Operations(
            law + common.ALLOCATION_FLOPS * muscles,
            common.ALLOCATION_CALLS * muscles,
            (
                f"the law: {law}, for {joints} joints and {muscles} muscles",
                f"pulses: {common.ALLOCATION_FLOPS} and {common.ALLOCATION_CALLS} calls for each muscle",
                "every loop has a fixed number of passes",
            ),
        ),
    )
