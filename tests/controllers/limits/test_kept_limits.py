"""Limits of pulses that cannot be kept are refused, where a model has no recruitment."""

import pytest

from controllers.ilc import Ilc
from controllers.mpc import Mpc
from fesloop.errors import InputError
from plants.finger import Finger

LINEAR = Finger(recruitment_curve="linear").linear_model()
CURVED = Finger().linear_model()
MAKE = {"mpc": lambda model, **limits: Mpc(model=model, current_ma=(40.0,) * 4, **limits),
        "ilc": lambda model, **limits: Ilc(model=model, current_ma=(40.0,) * 4, duration_s=5.0, **limits)}


@pytest.mark.parametrize("kind", sorted(MAKE))
@pytest.mark.parametrize(("key", "value"), [("width_max_us", 400.0), ("charge_max_uc", 18.0)])
def test_a_limit_is_kept_or_refused(kind, key, value):
    MAKE[kind](LINEAR)
    assert getattr(MAKE[kind](CURVED, **{key: value}), key) == value
    with pytest.raises(InputError, match=f"{key}: {value:g} has no effect"):
        MAKE[kind](LINEAR, **{key: value})
