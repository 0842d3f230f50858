"""A run has the same bits however many threads BLAS would like to have."""

import os
import subprocess
import sys

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from fesloop.loop.machine import one_blas_thread

RUN = """
import sys, tempfile
import fesloop
from fesloop import Recording
experiment = fesloop.load("grasp_mpc", ["experiment.duration_s=3.0", "scene=free", "score.after_s=1.0",
                                        "score.until_s=3.0"])
with tempfile.TemporaryDirectory() as folder:
    with Recording(experiment.run(folder).recording) as recording:
        print(recording.digest())
"""


def blas_threads():
    np.linalg.inv(np.eye(3))
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


def test_blas_has_one_thread_inside_and_its_own_afterwards():
    before = blas_threads()
    with one_blas_thread():
        assert blas_threads() == {1}
    assert blas_threads() == before


@pytest.mark.slow
def test_a_run_does_not_depend_on_the_threads_of_blas():
    def digest(threads):
        environment = {**os.environ, **dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), threads)}
        return subprocess.run([sys.executable, "-c", RUN], env=environment, check=True, capture_output=True,
                              text=True).stdout

    assert digest("1") == digest("2") != ""
