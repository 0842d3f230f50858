"""Compiled functions are compiled anew when a file that they depend on has changed, and only then."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FILES = {
    "inner": "from fesloop.compiled import compiled\n\n@compiled\ndef base(x):\n    return x + 1\n",
    "constants": "SCALE = 10\n",
    "middle": "from kernels_here.constants import SCALE\nfrom kernels_here import (\n    inner,\n)\n"
              "base = inner.base\n",
    "outer": "from fesloop.compiled import compiled\nfrom kernels_here.middle import SCALE, base\n\n"
             "@compiled\ndef top(x):\n    return SCALE * base(x)\n",
    "aside": "UNUSED = 1\n",
}
PROGRAM = """
from kernels_here.outer import top
print(top(1), sum(top.stats.cache_hits.values()))
"""


@pytest.fixture
def package(tmp_path):
    folder = tmp_path / "kernels_here"
    folder.mkdir()
    for name, text in {**FILES, "__init__": ""}.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def answer(package):
    """The value, and how often a kept function was found."""
    paths = os.pathsep.join([str(package.parent), str(ROOT)])
    # Python takes a changed file of the same length and second for the same one, if it keeps bytecode.
    env = {**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([sys.executable, "-c", PROGRAM], env=env, capture_output=True, text=True,
                          check=True)
    return tuple(map(int, done.stdout.split()))


@pytest.mark.slow
def test_a_compiled_function_is_kept_between_processes(package):
    assert [answer(package), answer(package)] == [(20, 0), (20, 1)]


@pytest.mark.parametrize(("name", "old", "new", "value"), [
    ("inner", "x + 1", "x + 2", 30), ("constants", "10", "100", 200),
    ("outer", "SCALE *", "1 + SCALE *", 21)])
def test_a_change_of_any_file_that_it_depends_on_compiles_it_anew(package, name, old, new, value):
    answer(package)
    file = package / f"{name}.py"
    file.write_text(file.read_text().replace(old, new))
    assert answer(package) == (value, 0)


@pytest.mark.slow
def test_other_files_and_times_of_files_do_not(package):
    answer(package)
    (package / "aside.py").write_text("UNUSED = 2\n")
    for file in package.glob("*.py"):
        os.utime(file, (0, 0))
    assert answer(package) == (20, 1)
