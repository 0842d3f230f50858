"""Contribution of one set of recordings to `fesloop reproduce people`."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.result import Sweep

_NONE: Mapping[str, Any] = MappingProxyType({})


class Part(NamedTuple):
    """Rows of the comparison, sweeps, and curves for figures, of one set of recordings."""

    rows: list[Row]
    sweeps: dict[str, Sweep]
    curves: Mapping[str, Any] = _NONE
