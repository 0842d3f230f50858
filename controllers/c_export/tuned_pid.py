"""`tuned_pid` as C: gains, inverse at rest and the programme that mixes the drives."""

from __future__ import annotations

import numpy as np

from controllers.c_export import common, quadratic_programme
from controllers.pid.tuned import TunedPid, farthest, mixing_hessian
from controllers.quadratic_programme import DEFAULT_ITERATIONS, DEFAULT_REFRESH
from controllers.timing import period_ns
from fesloop.c_code.program import Operations, Program, array, define, template
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_S


def program(
    block: TunedPid, context: Context, wired: frozenset[str] = frozenset(), ticks: int = 0
) -> Program:
    """The controller with the period of its clock; `wired` are the inputs that have a wire."""
    state, outputs, muscles = block.init(context), block.model.outputs, block.model.inputs
    preview = block.preview if "reference_preview" in wired else 0
    hessian, delayed = mixing_hessian(state.gain), len(state.asked)
    kp, integral, pull, pole, rate = state.gains.T
    sizes = {"OUTPUTS": outputs, "MUSCLES": muscles, "DELAYED": delayed, "UNKNOWNS": muscles,
             "BOUNDS": muscles}
    asked = "(in)->reference[output]"
    if preview:
        asked = ("((in)->reference_preview_newest_ns >= 0 ? (in)->reference_preview[AHEAD[output]][output] : "
                 f"{asked})")
    settings = (
        *(f"#define {name} {value}" for name, value in sizes.items()),
        f"#define PREVIEW {preview} /* coming references */",
        f"#define FEEDFORWARD {int(block.feedforward)} /* 1: the inverse of the model at rest is used */",
        f"#define ASKED(in, output) {asked}",
        f"#define COMING(in, step, output) {'(in)->reference_preview[step][output]' if preview else '0.0'}",
        f"#define BEGIN_NS {round(block.begin_s * NS_PER_S)} /* ns before which nothing is commanded */",
        define("AGE_MAX_MS", block.max_age_ms, "ms, age beyond which a measurement is not used"),
        define("CHARGE_RISE_C", 1e-6 * block.charge_rise_uc, "C, greatest rise of charge per phase a tick"),
        array("KP", kp, "rad per rad"), array("INTEGRAL", integral, "rad per rad a tick"),
        array("PULL", pull, "share a tick of what the limits cut off by which the integral is reduced"),
        array("POLE", pole, "pole of the derivative"), array("RATE", rate, "rad per rad of change a tick"),
        array("OFFSET", block.model.offset, "rad, outputs at rest"),
        array("FARTHEST", farthest(state.gain, state.reach), "rad, limit of references and outputs"),
        *((array("AHEAD", state.ahead, "coming reference that is delay and lag from now", "int"),)
          if preview else ()),
        array("LATE", state.late, "ticks, delay of the expected response", "int"),
        array("SLOW", state.slow, "its pole a tick"),
        array("GAIN", state.gain, "rad, effect of the drives at rest"),
        array("FREE", np.linalg.solve(hessian, state.gain.T), "drives without limits, per rad"),
        array("DRIVE_GREATEST", state.reach, "greatest drive of each muscle"),
        *quadratic_programme.settings(hessian, np.empty((0, muscles)), DEFAULT_ITERATIONS),
        *common.allocation_settings(block.allocation()),
    )
    law = outputs * (26 + 2 * muscles) + muscles * (2 * outputs + 12)
    start, iteration, last = quadratic_programme.worst_case(muscles, muscles)
    pulses = (common.ALLOCATION_FLOPS + 20) * muscles
    return Program(
        name=context.name,
        title=f"PID of {outputs} outputs through {muscles} muscles, tuned by the patient's model (fesloop "
        'block "tuned_pid")',
        period_ns=period_ns(context),
        inputs=tuple(port for port in block.inputs if preview or port.name != "reference_preview"),
        outputs=block.outputs,
        state=(
            "double integral[BLOCK_OUTPUTS], derivative[BLOCK_OUTPUTS]; /* rad */",
            "double previous[BLOCK_OUTPUTS];              /* rad, measurement of the step before */",
            "double asked[BLOCK_DELAYED][BLOCK_OUTPUTS];  /* rad, references, newest first */",
            "double expected[BLOCK_OUTPUTS];              /* rad, expected response to them */",
            "double pulses[BLOCK_MUSCLES][2];             /* present ones, A and s */",
            "int primed;                                  /* whether there was a measurement */",
            "block_qp qp;",
        ),
        sizes=sizes,
        statuses={**dict((common.OK, common.NO_INPUT, common.SATURATED, common.NON_FINITE,
                          common.STALE_INPUT)), **quadratic_programme.STATUSES},
        settings=settings,
        code=(common.head(), common.allocation_code(),
              *(template(common.PACKAGE, name)
                for name in ("risen.c", quadratic_programme.SOURCE, "tuned_pid.c"))),
        operations=Operations(
            law + start + DEFAULT_ITERATIONS * iteration + last + pulses,
            (common.ALLOCATION_CALLS + 4) * muscles,
            (
                f"the law: {law}, for {outputs} outputs and {muscles} muscles",
                f"mixing: {start} once in {DEFAULT_REFRESH} solves, {last} at its end, and {iteration} for "
                f"each of less than ITERATIONS_MAX = {DEFAULT_ITERATIONS} working sets",
                f"pulses: {pulses}",
            ),
        ),
        types=quadratic_programme.TYPES,
    )
