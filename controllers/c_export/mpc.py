"""`mpc` as C: observer, condensed quadratic programme and its solver."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.c_export import common, quadratic_programme
from controllers.mpc.block import Mpc
from controllers.mpc.design import candidates_of
from controllers.mpc.kernel import SLACK
from controllers.mpc.memory import Memory
from controllers.mpc.plan import KNEE_RAD
from controllers.quadratic_programme import DEFAULT_ITERATIONS, DEFAULT_REFRESH
from controllers.timing import period_ns
from fesloop.c_code.program import Operations, Program, array, define, template
from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, duration_ns

_SOURCES = ("risen.c", "observer.c", quadratic_programme.SOURCE)


def _faults(block: Mpc, where: str, wired: frozenset[str]) -> Iterator[InputError]:
    """Yield an InputError for each setting that C export does not support."""
    for key, given, remedy in (
        ("adaptation", block.adaptation is not None, "remove it; identify the patient's model first"),
        (
            "horizon_charge_max_uc",
            math.isfinite(block.horizon_charge_max_uc),
            "limit charge in the safety block",
        ),
        ("solver", block.solver != "daqp", 'set solver = "daqp"'),
    ):
        if given:
            yield InputError(f"{where}.{key}", "is not available in C", "a controller without it", remedy)


def program(block: Mpc, context: Context, wired: frozenset[str] = frozenset(), ticks: int = 0) -> Program:
    """The controller with the period of its clock.

    Parameters
    ----------
    wired: inputs that have a wire.
    ticks: of a trial, which `memory` records.

    Raises InputError for adaptation, a limit on charge over the horizon, another solver than daqp, and memory
    of trials of less than two ticks.
    """
    for fault in _faults(block, context.name, wired):
        raise fault
    period, outputs, muscles = period_ns(context), block.model.outputs, block.model.inputs
    candidate = candidates_of(block, period)[0]
    plan, observer, horizon = candidate.plan, candidate.observer, block.horizon
    states, unknowns, rows = observer.c.shape[1], plan.hessian.shape[0], plan.rows.shape[0]
    drives, known = horizon * muscles, plan.free.shape[0]
    stored = (known - horizon * outputs - states) // muscles - 1
    source = "reference_preview" if "reference_preview" in wired else "reference"
    feels = "force" in wired
    inputs = tuple(port for port in block.inputs
                   if port.name in (source, "measured", *(("force",) if feels else ())))
    sizes = {"STATES": states, "MUSCLES": muscles, "OUTPUTS": outputs, "HORIZON": horizon, "DRIVES": drives,
             "UNKNOWNS": unknowns, "BOUNDS": unknowns + rows, "KEPT": observer.kept}
    touching = _contact(block, observer.touching_gain) if feels else _NO_CONTACT
    learning = _memory(block, block.memory, period, ticks, context.name) if block.memory else _NO_MEMORY
    preview = source == "reference_preview"
    settings = (
        *(f"#define {name} {value}" for name, value in sizes.items()),
        f"#define BOXES {rows - drives}",
        f"#define STORED {stored}",
        "#define PRESENT (STATES + STORED * MUSCLES)",
        "#define KNOWN (PRESENT + HORIZON * OUTPUTS + MUSCLES)",
        f"#define RUNGS {observer.ladder.shape[0]}",
        "",
        f"#define REFERENCE_AT(in, step, output) (in)->{source}{'[step]' if preview else ''}[output]",
        f"#define REFERENCE_NEWEST_NS {source}_newest_ns",
        "",
        define("SLEW", block.slew, "greatest change of a drive from tick to tick"),
        define("CHARGE_RISE_C", 1e-6 * block.charge_rise_uc, "C, greatest rise of charge per phase a tick"),
        f"#define DELAY_NS INT64_C({observer.delay_ns}) /* ns, from a drive to its effect */",
        define("AGE_MAX_MS", block.max_age_ms, "ms, age beyond which a measurement is not used"),
        define("HOLD_MS", block.hold_ms, "ms for which the drive is held without a usable measurement"),
        define("RAMP_MS", max(block.ramp_ms, 1e-9), "ms in which it then falls to 0"),
        define("BEGIN_S", block.begin_s, "s before which nothing is commanded"),
        define("COMPENSATE_AGE", int(block.compensate_age), "1: predict across the age of a measurement"),
        "",
        array("DRIVE_GREATEST", block.reach(), "greatest drive of each muscle"),
        *common.allocation_settings(block.allocation()),
        array("OFFSET", observer.offset, "rad, outputs at rest"),
        array("OUTPUT_MAP", observer.c, "outputs from states"),
        array("OBSERVER_GAIN", observer.gain, "states, then disturbances, per rad of innovation"),
        array(
            "LADDER",
            observer.ladder,
            "transposed transition over 1, 2, 4 ... 512 ns, as many us, ms, a period",
        ),
        array(
            "FREE", plan.free, "optimal drives without limits, from states, offset less reference, last drive"
        ),
        *quadratic_programme.settings(plan.hessian, plan.rows, DEFAULT_ITERATIONS),
        *touching.settings,
        *learning.settings,
    )
    if rows > drives:
        settings += (
            define("KNEE_RAD", KNEE_RAD, "rad, excess of a box at which its price has doubled"),
            array("BOX_PLACE", plan.boxes[:, 0], "step x OUTPUTS + output of each box", "int"),
            array("BOX_LEAST", plan.boxes[:, 1], "rad"), array("BOX_GREATEST", plan.boxes[:, 2], "rad"),
            array("BOX_ROW", plan.rows[drives:], "angles from the unknowns"))
    return Program(
        name=context.name,
        period_ns=period,
        inputs=inputs,
        outputs=block.outputs,
        sizes={**sizes, **touching.sizes, **learning.sizes},
        title=f"Predictive control of {outputs} outputs through {muscles} muscles over {horizon} periods "
        '(fesloop block "mpc")',
        state=(*_STATE, *touching.state, *learning.state),
        statuses={**dict((common.OK, common.NO_INPUT, common.SATURATED, common.NON_FINITE,
                          common.STALE_INPUT)), **quadratic_programme.STATUSES, **touching.statuses},
        settings=settings,
        operations=_operations(block, period, sizes, known, observer.ladder.shape[0], touching, learning),
        code=(
            common.head(),
            common.allocation_code(),
            *(template(common.PACKAGE, name) for name in (*_SOURCES, *learning.sources, "mpc.c")),
        ),
        between=learning.between,
        types=(*_LOOP, *quadratic_programme.TYPES),
    )


_LOOP = (
    "/* An estimate, and what has been issued to the plant behind it. */",
    "typedef struct {",
    "    int64_t at_ns;                       /* instant of the estimate: the newest capture */",
    "    double x[BLOCK_STATES];              /* estimate at that instant */",
    "    double disturbance[BLOCK_OUTPUTS];   /* rad, of the outputs */",
    "    int64_t stamps[BLOCK_KEPT];          /* instants of the last drives, oldest first */",
    "    double issued[BLOCK_KEPT][BLOCK_MUSCLES];",
    "    double drive[BLOCK_MUSCLES], pulses[BLOCK_MUSCLES][2]; /* present ones; A and s */",
    "} block_loop;",
    "",
)
_STATE = (
    "block_loop loop;",
    "double planned[BLOCK_DRIVES];        /* last solution */",
    "int used;                            /* steps of it that have been issued; 0: there is none */",
    "int64_t held_ns;                     /* since when the drive is held or ramped, and from what */",
    "double held[BLOCK_MUSCLES];",
    "block_qp qp;",
)


class _Contact(NamedTuple):
    """Settings, state, sizes and statuses of contact, the forces that are read, and programmes of a tick."""

    settings: tuple[str, ...]
    state: tuple[str, ...] = ()
    sizes: Mapping[str, int] = MappingProxyType({})
    statuses: Mapping[str, str] = MappingProxyType({})
    forces: int = 0
    programmes: int = 1


class _Memory(NamedTuple):
    """Settings, state, sizes, sources and functions of what is learnt from trial to trial, and operations."""

    settings: tuple[str, ...] = ("#define MEMORY 0",)
    state: tuple[str, ...] = ()
    sizes: Mapping[str, int] = MappingProxyType({})
    sources: tuple[str, ...] = ()
    between: tuple[str, ...] = ()
    flops: int = 0


_NO_MEMORY = _Memory()
_MEMORY_STATE = (
    "double expected[BLOCK_SAMPLES][BLOCK_OUTPUTS]; /* rad, disturbance to expect of this trial */",
    "double best[BLOCK_SAMPLES][BLOCK_OUTPUTS];     /* rad, that of the trial of least error */",
    "int expected_count, best_count;                /* ticks of both */",
    *common.PROGRESS_STATE,
    "int samples, touched;                          /* recorded ticks; first one in contact, or -1 */",
    "unsigned char recorded[BLOCK_SAMPLES], controlled[BLOCK_SAMPLES], covered[BLOCK_SAMPLES];",
    "int64_t captured_ns[BLOCK_SAMPLES];            /* record of this trial */",
    "double measured[BLOCK_SAMPLES][BLOCK_OUTPUTS], asked[BLOCK_SAMPLES][BLOCK_OUTPUTS]; /* rad */",
    "double issued[BLOCK_SAMPLES][BLOCK_MUSCLES];",
    "double posture[BLOCK_SAMPLES][BLOCK_OUTPUTS];  /* rad, between trials; as all that follows */",
    "double learnt[BLOCK_SAMPLES][BLOCK_OUTPUTS];",
    *common.SPLINE_STATE,
)


def _memory(block: Mpc, memory: Memory, period: int, ticks: int, where: str) -> _Memory:
    """Learning of what trials of a number of ticks have in common."""
    if ticks < 2:
        raise InputError(f"{where}.memory", f"learns from trials of {ticks} ticks", "2 or more",
                         "lengthen the experiment, or remove memory")
    delay_ns = duration_ns(block.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
    model = block.model.sampled(period, delay_ns)
    outputs, muscles, states = block.model.outputs, block.model.inputs, model.a.shape[0]
    padding = memory.padding(period)
    hidden = [int(not block.grasping_outputs or i in block.grasping_outputs) for i in range(outputs)]
    settings = (
        "#define MEMORY 1",
        f"#define SAMPLES {ticks} /* ticks of a trial that are recorded */",
        f"#define MODEL_STATES {states}",
        f"#define PADDING {padding} /* samples by which a trial is extended */",
        f"#define GAP_MAX_NS INT64_C({memory.gap_ns(period)}) /* ns between interpolated captures */",
        define("LEARNT_SHARE", memory.share, "share of the difference that is taken over"),
        *common.progress_settings(memory.stop_after),
        *common.low_pass_settings(memory.section(period)[0], memory.cutoff_hz),
        array("OUTPUT_WEIGHT", block.output_weight or (1.0,) * outputs, "per rad^2"),
        array("BLOCKED", hidden, "1: an object may block that output", "int"),
        array("MODEL_A", model.a, "sampled model: states from states"),
        array("MODEL_B", model.b, "states from drives"),
        array("MODEL_C", model.c, "outputs from states"),
    )
    flops = (ticks * (outputs * 100 + 2 * states * (states + muscles + outputs)) + 40 * padding * outputs)
    return _Memory(
        settings,
        (*_MEMORY_STATE, f"double scratch[BLOCK_SAMPLES + {2 * padding}];"),
        {"SAMPLES": ticks},
        ("spline.c", "progress.c", "low_pass.c", "memory.c"),
        (
            "/* Learn from the trial that has ended; the next step is the first one of the next trial,",
            " * and time_ns begins at 0 again. */",
            "void block_next_trial(block_state *state);",
        ),
        flops)


_NO_CONTACT = _Contact(("#define CONTACT 0", "#define GRASPING 0"))


def _contact(block: Mpc, gain: NDArray[np.float64]) -> _Contact:
    """Contact as felt by the sensors of the input `force`, and `gain`, that of the observer in it."""
    felt = [int(not block.contact_places or place in block.contact_places) for place in block.places]
    led = bool(block.grasping_channels)
    settings: tuple[str, ...] = (
        "#define CONTACT 1",
        f"#define GRASPING {int(led)} /* 1: some channels follow the model alone in contact */",
        define("CONTACT_N", block.contact.force_n, "N, greatest force above which something is touched"),
        define("CONTACT_MS", block.contact.lasts_ms, "ms for which it is above"),
        define("RELEASE_N", block.contact.lost_n, "N, greatest force below which nothing is touched"),
        define("RELEASE_MS", block.contact.lost_ms, "ms for which it is below"),
        array("FELT", felt, "1: the force of that sensor counts as contact", "int"),
        array("TOUCHING_GAIN", gain, "as OBSERVER_GAIN, in contact"),
    )
    state: tuple[str, ...] = (
        "int touching;                        /* 1: the hand touches something */",
        "int64_t since_ns;                    /* since when forces contradict that */")
    if led:
        grasps = [int(channel in block.grasping_channels) for channel in range(block.model.inputs)]
        settings += (array("GRASPS", grasps, "1: the channel follows the model alone in contact", "int"),
                     define("SLACK", SLACK, "tolerance on the drives of these channels"))
        state += ("int led;                             /* 1: the loop on the model alone has begun */",
                  "block_loop alone;")
    return _Contact(settings, state, {"SENSORS": len(felt)}, dict([common.NO_FORCE]), len(felt), 1 + led)


def _operations(
    block: Mpc, period: int, sizes: dict[str, int], known: int, rungs: int, touching: _Contact,
    learning: _Memory,
) -> Operations:
    """Upper bounds of each part."""
    states, muscles, outputs = sizes["STATES"], sizes["MUSCLES"], sizes["OUTPUTS"]
    n, bounds, kept = sizes["UNKNOWNS"], sizes["BOUNDS"], sizes["KEPT"]
    rung = 2 * states * (states + muscles)
    periods = duration_ns(block.max_age_ms, NS_PER_MS, "max_age_ms") // period + 2
    observer = 2 * rung * (periods + kept * (rungs - 1)) + 4 * outputs * (states + outputs + 1)
    boxes = bounds - n - sizes["DRIVES"]
    assembly = 2 * n * known + 2 * known + 16 * bounds + 4 * n * boxes + 40 * muscles
    start, iteration, last = quadratic_programme.worst_case(n, bounds)
    pulses = (common.ALLOCATION_FLOPS + 20) * muscles
    once = observer + assembly + start + DEFAULT_ITERATIONS * iteration + last + pulses
    contact = 2 * touching.forces + 8 + 8 * sizes["DRIVES"] if touching.forces else 0
    led = touching.programmes > 1
    twice = ("all of it twice in contact, for the loop on the model alone",) if led else ()
    expecting = (sizes["HORIZON"] + 1) * (5 * outputs + 6) if learning.flops else 0
    between = ((f"block_next_trial: {learning.flops}, once a trial",) if learning.flops else ())
    return Operations(
        touching.programmes * once + contact + expecting,
        touching.programmes * (common.ALLOCATION_CALLS + 4) * muscles,
        (
            f"estimate and prediction: {observer}, for captures at most {block.max_age_ms:g} ms apart; each "
            f"further period between two captures takes {rung}",
            f"programme of {n} unknowns and {bounds} bounds: {assembly}",
            f"its solution: {start} once in {DEFAULT_REFRESH} solves, {last} at its end, and {iteration} "
            f"for each of less than ITERATIONS_MAX = {DEFAULT_ITERATIONS} working sets; a smaller one "
            "bounds it further, and the last solution goes on where it is passed",
            f"pulses: {pulses}",
            *twice,
            *between,
        ),
        learning.flops,
    )
