"""`mpc` as C: observer, condensed quadratic programme and its solver."""

from __future__ import annotations

import math
from collections.abc import Iterator

from controllers.c_export import common, quadratic_programme
from controllers.mpc.block import Mpc
from controllers.mpc.design import candidates_of
from controllers.mpc.plan import KNEE_RAD
from controllers.quadratic_programme import DEFAULT_ITERATIONS, DEFAULT_REFRESH
from controllers.timing import period_ns
from fesloop.c_code.program import Operations, Program, array, define, template
from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, duration_ns

_SOURCES = ("risen.c", "observer.c", quadratic_programme.SOURCE, "mpc.c")


def _faults(block: Mpc, where: str, wired: frozenset[str]) -> Iterator[InputError]:
    """Yield an InputError for each setting that C export does not support."""
    for key, given, remedy in (
        ("adaptation", block.adaptation is not None, "remove it; identify the patient's model first"),
        ("memory", block.memory is not None, "remove it"),
        (
            "horizon_charge_max_uc",
            math.isfinite(block.horizon_charge_max_uc),
            "limit charge in the safety block",
        ),
        ("solver", block.solver != "daqp", 'set solver = "daqp"'),
    ):
        if given:
            yield InputError(f"{where}.{key}", "is not available in C", "a controller without it", remedy)
    if "force" in wired:
        yield common.no_contact(where)


def program(block: Mpc, context: Context, wired: frozenset[str] = frozenset()) -> Program:
    """The controller with the period of its clock; `wired` are the inputs that have a wire.

    Raises InputError for adaptation, memory, a limit on charge over the horizon, contact, and another solver
    than daqp.
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
    inputs = tuple(port for port in block.inputs if port.name in (source, "measured"))
    sizes = {"STATES": states, "MUSCLES": muscles, "OUTPUTS": outputs, "HORIZON": horizon, "DRIVES": drives,
             "UNKNOWNS": unknowns, "BOUNDS": unknowns + rows, "KEPT": observer.kept}
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
        sizes=sizes,
        title=f"Predictive control of {outputs} outputs through {muscles} muscles over {horizon} periods "
        '(fesloop block "mpc")',
        state=_state(),
        statuses={**dict((common.OK, common.NO_INPUT, common.SATURATED, common.NON_FINITE,
                          common.STALE_INPUT)), **quadratic_programme.STATUSES},
        settings=settings,
        operations=_operations(block, period, sizes, known, observer.ladder.shape[0]),
        code=(
            common.head(),
            common.allocation_code(),
            *(template(common.PACKAGE, name) for name in _SOURCES),
        ),
        types=quadratic_programme.TYPES,
    )


def _state() -> tuple[str, ...]:
    return (
        "int64_t at_ns;                       /* instant of the estimate: the newest capture */",
        "double x[BLOCK_STATES];              /* estimate at that instant */",
        "double disturbance[BLOCK_OUTPUTS];   /* rad, of the outputs */",
        "int64_t stamps[BLOCK_KEPT];          /* instants of the last drives, oldest first */",
        "double issued[BLOCK_KEPT][BLOCK_MUSCLES];",
        "double drive[BLOCK_MUSCLES], pulses[BLOCK_MUSCLES][2]; /* present ones; A and s */",
        "double planned[BLOCK_DRIVES];        /* last solution */",
        "int used;                            /* steps of it that have been issued; 0: there is none */",
        "int64_t held_ns;                     /* since when the drive is held or ramped, and from what */",
        "double held[BLOCK_MUSCLES];",
        "block_qp qp;",
    )


def _operations(block: Mpc, period: int, sizes: dict[str, int], known: int, rungs: int) -> Operations:
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
    total = observer + assembly + start + DEFAULT_ITERATIONS * iteration + last + pulses
    return Operations(
        total,
        (common.ALLOCATION_CALLS + 4) * muscles,
        (
            f"estimate and prediction: {observer}, for captures at most {block.max_age_ms:g} ms apart; each "
            f"further period between two captures takes {rung}",
            f"programme of {n} unknowns and {bounds} bounds: {assembly}",
            f"its solution: {start} once in {DEFAULT_REFRESH} solves, {last} at its end, and {iteration} "
            f"for each of less than ITERATIONS_MAX = {DEFAULT_ITERATIONS} working sets; a smaller one "
            "bounds it further, and the last solution goes on where it is passed",
            f"pulses: {pulses}",
        ),
    )
