"""Virtual electrodes: the elements of an array that a stimulator's channel is switched onto."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from plants.checks import require_positive

Array = NDArray[np.float64]
_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualElectrode:
    """Elements that share a channel's current.

    Attributes
    ----------
    elements: their numbers.
    shares: of the current, adding up to 1; empty: equal ones.
    """

    elements: tuple[int, ...]
    shares: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.elements or len(set(self.elements)) < len(self.elements) or min(self.elements) < 0:
            raise InputError("virtual_electrode.elements", f"{self.elements}",
                             "one or more numbers, each once")
        if self.shares:
            require_positive("virtual_electrode", self, "shares")
            if len(self.shares) != len(self.elements) or abs(sum(self.shares) - 1.0) > _TOLERANCE:
                raise InputError("virtual_electrode.shares", f"{self.shares}",
                                 f"{len(self.elements)} numbers, one an element, that add up to 1")


def multiplexing(electrodes: Sequence[VirtualElectrode], channels: int, elements: int) -> Array:
    """Share of each channel's current that each element has, (channels, elements).

    Without electrodes channel c has element c. Raises InputError for elements that do not exist and for
    another number of electrodes than channels.
    """
    electrodes = electrodes or [VirtualElectrode(elements=(channel,)) for channel in range(channels)]
    if len(electrodes) != channels:
        raise InputError("stimulator.electrodes", f"{len(electrodes)} virtual electrodes",
                         f"{channels}, one a channel, or none")
    shares = np.zeros((channels, elements))
    for channel, electrode in enumerate(electrodes):
        numbers = list(electrode.elements)
        if max(numbers) >= elements:
            raise InputError(f"stimulator.electrodes[{channel}].elements",
                             f"element {max(numbers)} does not exist", f"0 to {elements - 1}")
        shares[channel, numbers] = electrode.shares or 1.0 / len(numbers)
    return shares


def fault_of(shares: Array) -> str:
    """What is wrong with shares (channels, elements); empty where nothing is.

    Every row holds no number below 0 and adds up to 1, or to 0 for a channel that is switched onto nothing.
    """
    if not np.isfinite(shares).all() or (shares < 0.0).any():
        return "a share is negative or not finite"
    total = shares.sum(axis=1)
    wrong = np.flatnonzero((np.abs(total - 1.0) > _TOLERANCE) & (total != 0.0))
    if not wrong.size:
        return ""
    return f"the shares of channel {wrong[0]} add up to {total[wrong[0]]:g}, not to 1 or 0"
