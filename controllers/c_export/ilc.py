"""`ilc` as C: the drives of a trial, and the learning between trials."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from controllers.c_export import common
from controllers.ilc.block import Ilc
from controllers.ilc.laws import PADDING, Learning, low_pass, static_gain
from controllers.timing import period_ns
from controllers.trajectories import strongest
from fesloop.c_code.program import Operations, Program, array, define, template
from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.models.linear_model import SampledModel

LAWS = ("gradient", "noilc", "phase_lead")
"""Laws without a quadratic programme over a trial, whose solution would be no closer than its tolerance."""


def _faults(block: Ilc, where: str, wired: frozenset[str]) -> Iterator[InputError]:
    """Yield an InputError for each setting that C export does not support."""
    if block.law not in LAWS:
        why = ("bends recruitment" if block.law == "newton"
               else "solves a quadratic programme over a whole trial")
        yield InputError(f"{where}.law", f'"{block.law}" is not available in C: it {why}', ", ".join(LAWS),
                         "choose one of them")
    if block.bank:
        yield InputError(f"{where}.bank", "is not available in C", "one model", "remove it")
    if math.isfinite(block.trial_charge_max_uc):
        yield InputError(f"{where}.trial_charge_max_uc", "is not available in C", "no limit",
                         "limit charge in the safety block")
    if "force" in wired:
        yield InputError(f"{where}.force", "is wired, and contact is not available in C", "no force sensors",
                         "remove the wire; in the shipped grasps, --set glove=grip_only does so")


class _Law(NamedTuple):
    """Settings, members of the state, operations a trial and further sources of a learning law."""

    settings: tuple[str, ...]
    state: tuple[str, ...]
    flops: int
    sources: tuple[str, ...] = ()


def program(block: Ilc, context: Context, wired: frozenset[str] = frozenset(), ticks: int = 0) -> Program:
    """The controller with the period of its clock; `wired` are the inputs that have a wire.

    Raises InputError for laws that solve a quadratic programme over a trial or bend recruitment, for a bank
    of models, a limit on charge over a trial, and contact.
    """
    for fault in _faults(block, context.name, wired):
        raise fault
    period = period_ns(context)
    learning = block.learning(period)
    model, samples = learning.model, learning.samples
    states, muscles, outputs = model.a.shape[0], block.model.inputs, block.model.outputs
    law = _law(block, learning, model)
    inputs = tuple(port for port in block.inputs
                   if port.name in ("reference", "measured") or (port.name in wired and port.name != "force"))
    distrust = ["(in)->trusted < 0.5"] if "trusted" in wired else []
    if "measured_sd" in wired:
        distrust.append("!((in)->measured_sd[output] <= SD_MAX)")
    sizes = {"SAMPLES": samples, "MUSCLES": muscles, "OUTPUTS": outputs, "STATES": states}
    gap_ns = max(duration_ns(block.max_gap_ms, NS_PER_MS, "max_gap_ms"), 2 * period)
    settings = (
        *(f"#define {name} {value}" for name, value in sizes.items()),
        f"#define BEGINS {block.begins(period)} /* first tick that counts */",
        f"#define ALIGN_CAPTURES {int(block.align_captures)} /* 1: errors at the instants of the ticks */",
        f"#define GAP_MAX_NS INT64_C({gap_ns}) /* ns between captures that are interpolated */",
        define("SD_MAX", math.radians(block.sd_max_deg), "rad, standard deviation of a usable measurement"),
        f"#define DISTRUSTED(in, output) ({' || '.join(distrust) or '(void)(output), 0'})",
        define("REJECT_SHARE", block.reject_share, "share of doubtful measurements that rejects a trial"),
        *common.progress_settings(block.stop_after),
        define("FORGETTING", block.forgetting, "share of the drives forgotten a trial"),
        define("SLEW", block.slew, "greatest change of a drive from tick to tick"),
        array("FIRST_DRIVE", block.first_drive or (0.0,) * muscles, "drive of the first trial"),
        array("DRIVE_GREATEST", learning.limits.reach, "greatest drive of each muscle"),
        *common.allocation_settings(block.allocation()),
        array("OUTPUT_WEIGHT", learning.output_weight, "per rad^2"),
        *law.settings)
    pulses = common.ALLOCATION_FLOPS * muscles
    between = law.flops + samples * (outputs * 60 + muscles * 20)
    return Program(
        name=context.name,
        period_ns=period,
        inputs=inputs,
        outputs=block.outputs,
        sizes=sizes,
        title=f'Iterative learning control, law "{block.law}", of {outputs} outputs through {muscles} '
        f'muscles in trials of {samples} ticks (fesloop block "ilc")',
        state=(*_STATE, *law.state),
        settings=settings,
        statuses={
            **dict((common.OK, common.SATURATED)),
            "NO_REFERENCE": "no finite reference: the tick does not count",
            "PAST_END": "the trial is longer than its drives: the last one is held",
        },
        code=(
            common.head(),
            common.allocation_code(),
            *(template(common.PACKAGE, name)
              for name in (*law.sources, f"ilc_{block.law}.c", "spline.c", "progress.c", "ilc.c")),
        ),
        operations=Operations(
            pulses + 2 * outputs,
            common.ALLOCATION_CALLS * muscles,
            (
                f"pulses: {common.ALLOCATION_FLOPS} and {common.ALLOCATION_CALLS} calls for each muscle",
                f"block_next_trial: {between}, once a trial; every loop has a fixed number of passes",
            ),
            between,
        ),
        between=(
            "/* Learn from the trial that has ended; the next step is the first one of the next trial. */",
            "void block_next_trial(block_state *state);",
        ),
    )


_STATE = (
    "int index;                                    /* of the next tick */",
    "double drives[BLOCK_SAMPLES][BLOCK_MUSCLES];  /* of this trial */",
    "double first[BLOCK_SAMPLES][BLOCK_MUSCLES];   /* of the first trial */",
    "double best[BLOCK_SAMPLES][BLOCK_MUSCLES];    /* of the trial of least error */",
    *common.PROGRESS_STATE,
    "int64_t ticks_ns[BLOCK_SAMPLES], captured_ns[BLOCK_SAMPLES]; /* record of this trial */",
    "double measured[BLOCK_SAMPLES][BLOCK_OUTPUTS], reference[BLOCK_SAMPLES][BLOCK_OUTPUTS]; /* rad */",
    "unsigned char doubtful[BLOCK_SAMPLES][BLOCK_OUTPUTS], covered[BLOCK_SAMPLES][BLOCK_OUTPUTS];",
    "double error[BLOCK_SAMPLES][BLOCK_OUTPUTS];   /* rad, between trials; as all that follows */",
    "double next[BLOCK_SAMPLES][BLOCK_MUSCLES], change[BLOCK_SAMPLES][BLOCK_MUSCLES];",
    *common.SPLINE_STATE,
    f"double scratch[BLOCK_SAMPLES + {2 * PADDING}];",
)


def _law(block: Ilc, learning: Learning, model: SampledModel) -> _Law:
    states, muscles, outputs, samples = *model.b.shape, model.c.shape[0], learning.samples
    if block.law == "phase_lead":
        settings = [
            f"#define LEAD {learning.lead} /* ticks */",
            define("LEARNING_GAIN", learning.gain, "share of the error"),
            array("STATIC_INVERSE", np.linalg.pinv(static_gain(model)), "drives per rad in steady state"),
            f"#define LOW_PASS {int(learning.cutoff > 0.0)} /* 1: drives are low-passed */",
            f"#define PADDING {min(PADDING, samples - 1)} /* samples by which a trial is extended */",
        ]
        if learning.cutoff > 0.0:
            settings += common.low_pass_settings(low_pass(learning.cutoff)[0], block.cutoff_hz)
        return _Law(tuple(settings), (), samples * muscles * (3 * outputs + 20) + 40 * PADDING * muscles,
                    ("low_pass.c",) if learning.cutoff > 0.0 else ())
    matrices = (
        array("MODEL_A", model.a, "sampled model: states from states"),
        array("MODEL_B", model.b, "states from drives"),
        array("MODEL_C", model.c, "outputs from states"),
    )
    if block.law == "gradient":
        gain = learning.step / strongest(model, learning.weights())
        return _Law(
            (define("LEARNING_GAIN", gain, "step over the greatest eigenvalue of G'WG"), *matrices),
            (),
            samples * states * (3 * muscles + 2 * states + 3 * outputs),
        )
    flops = samples * (
        2 * states**2 * (4 * muscles + 2 * states + 2 * outputs)
        + 2 * muscles**2 * (states + muscles)
        + states * (8 * muscles + 8 * states + 4 * outputs)
    )
    return _Law((define("CHANGE_WEIGHT", learning.change_weight, "rho, per drive squared"), *matrices),
                ("double gains[BLOCK_SAMPLES][BLOCK_MUSCLES][BLOCK_STATES], "
                 "forward[BLOCK_SAMPLES][BLOCK_MUSCLES];",), flops)
