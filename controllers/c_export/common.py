"""Parts that the C programmes of several controllers share: head, and conversion of drives to pulses."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import LEAST_FRACTION, Allocation
from controllers.progress import FAR_WORSE, WORSE
from fesloop.c_code.program import array, define, template

PACKAGE = "controllers.c_export"
ALLOCATION_FLOPS, ALLOCATION_CALLS = 54, 7
"""Operations and calls of one channel in allocation.c: the quantile calls log, sqrt, and erfc and exp twice,
the channel exp."""
OK, NO_INPUT, SATURATED, NON_FINITE, STALE_INPUT = (
    ("OK", "a channel's drive was computed from these inputs"), ("NO_INPUT", "an input has not arrived yet"),
    ("SATURATED", "a channel is at its longest pulse"), ("NON_FINITE", "an input is not finite"),
    ("STALE_INPUT", "the newest capture is too old"))
NO_FORCE = ("NO_FORCE", "forces are not finite or too old: contact is as before")


SPLINE_STATE = (
    "int64_t stamp_ns[BLOCK_SAMPLES];              /* captures, each once */",
    "double knot[BLOCK_SAMPLES], value[BLOCK_SAMPLES], moment[BLOCK_SAMPLES], above[BLOCK_SAMPLES];",
)
"""State of spline.c, beside `scratch` of as many numbers or more."""
PROGRESS_STATE = (
    "double least, before;                         /* rad, least error and that of the trial before */",
    "int trials, worse, stopped;                   /* noted; successive worse ones; at its end */",
)
"""State of progress.c."""


def progress_settings(stop_after: int) -> tuple[str, ...]:
    """Constants of progress.c."""
    return (define("STOP_AFTER", stop_after, "worse trials that end the learning; 0: never"),
            define("WORSE", WORSE, "least error times this, and growth, make a trial worse"),
            define("FAR_WORSE", FAR_WORSE, "least error times this makes a trial worse"))


def low_pass_settings(section: NDArray[np.float64], cutoff_hz: float) -> tuple[str, ...]:
    """Constants of low_pass.c from b0 b1 b2 a0 a1 a2, (6,)."""
    from scipy.signal import sosfilt_zi

    return (array("SECTION", section, f"b0 b1 b2 a0 a1 a2 of the low-pass, {cutoff_hz:g} Hz"),
            array("SECTION_STEADY", sosfilt_zi(section[np.newaxis])[0], "its state for an input of 1"))


def head() -> str:
    """Start of the code: what it includes."""
    return '#include "BLOCK_HEADER"\n#include "block_settings.h"\n'


def allocation_settings(allocation: Allocation) -> tuple[str, ...]:
    """Constants of allocation.c."""
    table = allocation.table()
    return (
        array("CURRENT_A", table[:, 0], "A, current of each channel while its pulse is longer than 0"),
        array("LONGEST_S", table[:, 1], "s, longest pulse of each channel"),
        array(
            "LINEAR_WIDTH_S", table[:, 2], "s, pulse of a full drive without recruitment curve; 0: with one"
        ),
        array("THRESHOLD_MA", table[:, 3], "mA, effective current that recruits half of the muscle"),
        array("SPREAD", table[:, 4], "standard deviation of the logarithms of the axons' thresholds"),
        array("CHRONAXIE_S", table[:, 5], "s, of the strength-duration curve"),
        define("LEAST_FRACTION", LEAST_FRACTION, "of a muscle, up to which there is no pulse"),
        f"#define SQRT_HALF ({math.sqrt(0.5)!r})",
        f"#define SQRT_TWO_PI ({math.sqrt(2.0 * math.pi)!r})",
    )


def allocation_code() -> str:
    """The text of allocation.c."""
    return template(PACKAGE, "allocation.c")
