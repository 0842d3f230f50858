"""Muscles: from recruitment and stimulation frequency to activation, with fatigue."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.muscles.plant import Muscles

__all__ = ["Muscles"]

__getattr__ = found_in(__name__, {"Muscles": "plant"})
