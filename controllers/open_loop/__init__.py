"""Open-loop stimulation."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.open_loop.element_sweep import ElementSweep
    from controllers.open_loop.programme import Programme

__all__ = ["ElementSweep", "Programme"]

__getattr__ = found_in(__name__, {"ElementSweep": "element_sweep", "Programme": "programme"})
