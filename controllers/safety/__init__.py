"""Safety limits between a controller and a stimulator."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.safety.block import Safety

__all__ = ["Safety"]

__getattr__ = found_in(__name__, {"Safety": "block"})
