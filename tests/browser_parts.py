"""Waiting for what a page does."""

from typing import Any

import pytest

_POLLS, _POLL_MS = 150, 100


def until(shown: Any, expression: str) -> None:
    """Wait until a JavaScript expression is true: the page's policy forbids Playwright's own way to wait."""
    for _ in range(_POLLS):
        if shown.evaluate(f"Boolean({expression})"):
            return
        shown.wait_for_timeout(_POLL_MS)
    pytest.fail(f"never true: {expression}")
