"""What a learning controller keeps of each sample, and what it tells of those that are doubtful."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.ilc.trial import SeenTrial
from fesloop.loop.block import Tick
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]


def note(seen: SeenTrial, latch: StatusLatch, k: int, inputs: Sequence[Sample], sd_max_deg: float,
         tick: Tick) -> None:
    """Keep the measurement of tick k, and tell what of it is doubtful.

    `inputs`: `measured` and `measured_sd` (outputs,), rad, and `trusted`.
    """
    sample, spread, trusted = inputs
    measured, sd = cast(Array, sample.value), cast(Array, spread.value)
    broken = ~np.isfinite(measured)
    vague = ~(sd <= math.radians(sd_max_deg))
    latch.put(tick, "non_finite", bool(broken.any()), "a measurement is not finite: left out of learning")
    latch.put(tick, "uncertain", bool(vague.any()),
              f"a measurement's sd is above {sd_max_deg:g} deg: left out of learning")
    distrusted = not cast(float, trusted.value) >= 0.5
    latch.put(tick, "not_trusted", distrusted, "said not to be trusted: left out of learning")
    seen.note(k, sample.newest_ns, measured, broken | vague | distrusted)
