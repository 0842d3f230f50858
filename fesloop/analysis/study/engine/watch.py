"""Who is told how far a study is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol


class Watch(Protocol):
    """Who is told how far a study is."""

    def stage(self, text: str, fraction: float | None = None) -> None:
        """What is being done before the runs."""

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """Runs that are done, that failed by cause, and all; told also while nothing comes."""


class Nobody:
    """Who is told and says nothing."""

    def stage(self, text: str, fraction: float | None = None) -> None:
        """As of `Watch`."""

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """As of `Watch`."""
