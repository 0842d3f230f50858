"""Parts that the C programmes of several controllers share: head, and conversion of drives to pulses."""

from __future__ import annotations

import math

from controllers.allocation import LEAST_FRACTION, Allocation
from fesloop.c_code.program import array, define, template
from fesloop.errors import InputError

PACKAGE = "controllers.c_export"
ALLOCATION_FLOPS, ALLOCATION_CALLS = 54, 7
"""Operations and calls of one channel in allocation.c: the quantile calls log, sqrt, and erfc and exp twice,
the channel exp."""
OK, NO_INPUT, SATURATED, NON_FINITE, STALE_INPUT = (
    ("OK", "a channel's drive was computed from these inputs"), ("NO_INPUT", "an input has not arrived yet"),
    ("SATURATED", "a channel is at its longest pulse"), ("NON_FINITE", "an input is not finite"),
    ("STALE_INPUT", "the newest capture is too old"))


def no_contact(where: str) -> InputError:
    """Fault of a controller to which force sensors are wired."""
    return InputError(f"{where}.force", "is wired, and contact is not available in C", "no force sensors",
                      "remove the wire; in the shipped grasps, --set glove=grip_only does so")


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
