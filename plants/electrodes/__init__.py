"""Electrode arrays on a forearm: from pulses of their elements to recruitment of muscles."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.electrodes.recruitment import Electrodes

__all__ = ["Electrodes"]

__getattr__ = found_in(__name__, {"Electrodes": "recruitment"})
