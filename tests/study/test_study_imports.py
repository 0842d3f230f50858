import subprocess
import sys

import pytest

import fesloop.analysis.study

HEAVY = ("dask", "distributed", "pandas", "pyarrow", "matplotlib", "scipy")


@pytest.mark.parametrize("use", [
    "import fesloop.analysis.study", "from fesloop.analysis.study import load, Figure"])
def test_reading_a_study_takes_none_of_what_runs_and_draws_it(use):
    code = f"{use}; import sys; print(*(set({HEAVY!r}) & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout.strip() == ""


def test_every_public_name_is_there():
    assert set(fesloop.analysis.study.__all__) == set(dir(fesloop.analysis.study))
    for name in fesloop.analysis.study.__all__:
        assert getattr(fesloop.analysis.study, name).__module__.startswith("fesloop.analysis.study")
    with pytest.raises(AttributeError, match="no attribute 'lod'"):
        fesloop.analysis.study.lod  # noqa: B018
