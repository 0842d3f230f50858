"""Plants the faults of `mutants.toml` one at a time in a copy of the project, and reports which tests notice.

    python tests/mutants.py [--lane quick|full] [--only NAME]... [--tests PATH]... [--workers N] [--check]

Each fault is tried on the tests of its room first, then, where these pass, on all tests of the lane: the
quick lane is what `pytest` runs by default, the full lane is every test. With `--tests`, only those are run.
`--check` only finds the places of all faults. Exits with 1 where the whole list leaves more faults unnoticed
than it may, with 2 where the text of a fault is no longer in the library.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
LIST = ROOT / "tests" / "mutants.toml"
PACKAGES = ("fesloop", "plants", "estimators", "controllers")
LANES = {"quick": (), "full": ("-m", "")}
"""Arguments of pytest that select a lane, after those of pyproject.toml."""
LEAST = {"quick": 0.8, "full": 0.95}
"""Share of all faults that a lane must notice."""
NOTICED = {1, 2}
"""Exit codes of pytest: a test failed; collection failed, or xdist stopped at the first failure."""


class Mutant(NamedTuple):
    """A fault: `new` in place of `old`, which the file holds once."""

    name: str
    kind: str
    file: str
    old: str
    new: str
    tests: list[str]


class Place(NamedTuple):
    """A part of a file."""

    path: Path
    begin: int
    end: int


class NotFoundError(Exception):
    """A fault's text is not in the library, or more than once."""


def listed(path: Path = LIST) -> list[Mutant]:
    """Every fault of the list."""
    return [Mutant(**table) for table in tomllib.loads(path.read_text(encoding="utf-8"))["mutant"]]


def place(mutant: Mutant, root: Path = ROOT) -> Place:
    """Where a fault goes: in its file, or, if that does not hold its text, in the only module that does.

    Words are compared, not the blanks between them. Raises NotFoundError.
    """
    own = root / mutant.file
    found = _places(mutant.old, [own] if own.is_file() else [])
    if len(found) != 1:
        found = _places(mutant.old, (path for package in PACKAGES
                                     for path in sorted((root / package).rglob("*.py"))))
    if len(found) != 1:
        where = ", ".join(str(each.path.relative_to(root)) for each in found)
        raise NotFoundError(f"{mutant.name}: {mutant.file} does not hold {mutant.old!r} once"
                            + (f"; other modules: {where}" if where else ", nor does another module"))
    return found[0]


def _places(old: str, paths: Iterable[Path]) -> list[Place]:
    words = re.compile(r"\s+".join(map(re.escape, old.split())))
    return [Place(path, *match.span())
            for path in paths for match in words.finditer(path.read_text(encoding="utf-8"))]


def copy(root: Path, target: Path) -> None:
    """Copy what Git knows of, or would add, and what Numba has compiled of it."""
    names = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                           cwd=root, capture_output=True, text=True, check=True).stdout.split("\0")
    compiled = (path.relative_to(root) for package in PACKAGES for path in (root / package).rglob("*.nb[ic]"))
    for name in (*filter(None, names), *compiled):
        if (root / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, target / name)


def notices(tests: Sequence[str], lane: str, workers: str, root: Path) -> bool:
    """Whether a test fails in a copy of the project. Raises RuntimeError where pytest cannot run them."""
    paths = [str(root), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-x", "--no-header", "-p", "no:cacheprovider", "-n", workers,
         f"--ignore={LIST.with_name('test_mutants.py').relative_to(ROOT)}", *LANES[lane], *tests],
        cwd=root, env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths)),
                       "PYTHONDONTWRITEBYTECODE": "1"}, capture_output=True, text=True)
    if done.returncode not in {0, *NOTICED}:
        said = f"{done.stdout[-2000:]}{done.stderr[-2000:]}"
        raise RuntimeError(f"pytest ended with {done.returncode}:\n{said}")
    for line in done.stdout.splitlines():
        if line.startswith(("FAILED", "ERROR")):
            print(f"    {line[:160]}", flush=True)
    return done.returncode in NOTICED


def tried(mutant: Mutant, given: argparse.Namespace, root: Path) -> bool:
    """Whether a fault is noticed."""
    path, begin, end = place(mutant, root)
    sound = path.read_text(encoding="utf-8")
    path.write_text(sound[:begin] + mutant.new + sound[end:], encoding="utf-8")
    try:
        first = given.tests or [test for test in mutant.tests if (root / test).exists()]
        return ((bool(first) and notices(first, given.lane, given.workers, root))
                or (not given.tests and notices([], given.lane, given.workers, root)))
    finally:
        path.write_text(sound, encoding="utf-8")


def main(arguments: Sequence[str]) -> int:
    """Print what becomes of each fault; exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--lane", choices=LANES, default="quick")
    parser.add_argument("--only", action="append", default=[], metavar="NAME")
    parser.add_argument("--tests", action="append", default=[], metavar="PATH")
    parser.add_argument("--workers", default="auto", metavar="N")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args(arguments)
    every = listed()
    chosen = [mutant for mutant in every if not given.only or mutant.name in given.only]
    lost = []
    for mutant in every:
        try:
            place(mutant)
        except NotFoundError as error:
            lost.append(str(error))
    print("\n".join(lost) or f"{len(every)} faults, each with its place")
    if lost:
        return 2
    if given.check:
        return 0
    noticed = Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder).resolve()
        copy(ROOT, root)
        for mutant in chosen:
            caught = tried(mutant, given, root)
            noticed[mutant.kind] += caught
            verdict = "caught" if caught else "SURVIVED"
            print(f"{verdict:8} {mutant.name} ({mutant.kind}, {mutant.file})", flush=True)
    print(f"{noticed.total()} of {len(chosen)} caught by the {given.lane} lane")
    return int(chosen == every and noticed.total() < LEAST[given.lane] * len(every))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
