"""What the parameters of the muscles come to: checked once, and the constants that follow from them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.movements import MUSCLES
from fesloop.loop.clock import NS_PER_MS, duration_ns
from plants.checks import require_not_negative, require_positive
from plants.muscles.ding import Ding2003, Ding2007
from plants.muscles.lags import Hammerstein, Riener, TwoLags
from plants.muscles.patient_drive import greatest_efforts
from plants.muscles.state import Contraction

if TYPE_CHECKING:
    from plants.muscles.plant import Muscles

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Constants:
    """Constants of the muscles.

    Attributes
    ----------
    contraction: of stimulated muscle. natural: of what nerves drive.
    delays_ns: of each signal, in the order of `plants.muscles.state`.
    sides: (muscles,), on which side of its joint each trembles; zeros without a tremor.
    efforts: (muscles,), the greatest at will.
    """

    contraction: Contraction
    natural: TwoLags
    delays_ns: tuple[int, int, int]
    sides: Array
    efforts: Array


def constants_of(muscles: Muscles) -> Constants:
    """The constants of these parameters; InputError for parameters that cannot be."""
    models: dict[str, Hammerstein | Riener | Ding2003 | Ding2007] = {
        "hammerstein": muscles.hammerstein, "riener": muscles.riener, "ding2003": muscles.ding2003,
        "ding2007": muscles.ding2007}
    if muscles.model not in models:
        raise InputError("muscles.model", f"{muscles.model!r}", ", ".join(models))
    if muscles.model == "ding2003" and muscles.fatigue is not None:
        raise InputError("muscles.fatigue", "the fitness equation beside model ding2003",
                         "no `fatigue` there", "that model tires by its own equations: ding2003.fatigue")
    if not 0.0 <= muscles.wear_per_trial < 1.0:
        raise InputError("muscles.wear_per_trial", f"{muscles.wear_per_trial}", "from 0 to below 1")
    require_positive("muscles", muscles, "fusion_hz", "natural_rad_s")
    require_not_negative("muscles", muscles, "rest_between_trials_s", "delay_growth")
    efforts = greatest_efforts(muscles.voluntary_limit, muscles.voluntary_limits)
    delay = duration_ns(muscles.delay_ms, NS_PER_MS, "muscles.delay_ms")
    reflex = duration_ns(muscles.reflex.delay_ms, NS_PER_MS, "reflex.delay_ms") if muscles.reflex else 0
    return Constants(
        contraction=models[muscles.model].contraction(),
        natural=TwoLags(1.0 / muscles.natural_rad_s, 1.0 / muscles.natural_rad_s),
        delays_ns=(delay, delay, delay + reflex),
        sides=muscles.tremor.sides() if muscles.tremor else np.zeros(len(MUSCLES)), efforts=efforts)
