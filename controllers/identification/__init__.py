"""Identification of a patient's model from an excitation."""

from typing import TYPE_CHECKING

from fesloop.lazily import found_in

if TYPE_CHECKING:
    from controllers.identification.excitation import Excitation

__all__ = ["Excitation"]

__getattr__ = found_in(__name__, {"Excitation": "excitation"})
