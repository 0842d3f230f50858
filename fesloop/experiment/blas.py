"""One thread for BLAS, so that sums have one order and a run the same bits wherever it runs.

Matrices here are small, too: threads wait for each other longer than they multiply.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Leave BLAS one thread, of all of this process, until the context is left (about 1 ms)."""
    with threadpool_limits(1, "blas"):
        yield
