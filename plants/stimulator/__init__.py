"""8-channel stimulator: from commands for its channels to pulses of elements."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from plants.stimulator.block import Stimulator

__all__ = ["Stimulator"]

__getattr__ = found_in(__name__, {"Stimulator": "block"})
