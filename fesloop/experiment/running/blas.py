"""One thread for BLAS, so that sums have one order and a run the same bits wherever it runs.

Matrices here are small, too: threads wait for each other longer than they multiply.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

from threadpoolctl import ThreadpoolController


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Leave BLAS one thread, of all of this process, until the context is left."""
    with _libraries(len(sys.modules)).limit(limits=1, user_api="blas"):
        yield


@lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:
    """BLAS libraries that are loaded; a search takes a ms, so it is repeated only for more `modules`."""
    return ThreadpoolController()
