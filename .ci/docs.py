"""Runs what the pages of docs/ show, each in a scratch folder of its own: `docs.py [--workers N] [PAGE...]`.

A fenced block under a line that is a name in backquotes is a file, and is written. Blocks of `sh` are run by
bash, which stops at the first command that fails, blocks of `python` without a name by Python. What needs
hardware, a file of the reader's or hours is in blocks of `console`, behind `$ `, or of `py`, and is not run.
Without a PAGE: every page that has something to run. Exits with 1 if a page fails, after printing its output.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from patience import patient

DOCS = Path(__file__).resolve().parents[1] / "docs"
_FENCE = re.compile(r"(?:^`(?P<file>[\w./-]+)`\n\n)?^```(?P<language>\w+)\n(?P<text>.*?)^```$",
                    re.MULTILINE | re.DOTALL)
_RUN = {"sh": ["bash", "-euxo", "pipefail"], "python": [sys.executable]}


class Step(NamedTuple):
    """A block of a page: text for the file of that name, or, without a name, to run as its language."""

    file: str | None
    language: str
    text: str


def steps(page: Path) -> list[Step]:
    """Files and commands of a page, in order."""
    found = [Step(**match.groupdict()) for match in _FENCE.finditer(page.read_text())]
    return [step for step in found if step.file or step.language in _RUN]


def write(step: Step, folder: Path) -> None:
    """Write a page's file into a folder."""
    path = folder / str(step.file)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(step.text)


def follow(page: Path) -> str | None:
    """Run a page, and return its output up to the failure, or None if every step succeeds."""
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as output:
        for step in steps(page):
            if step.file:
                write(step, Path(folder))
                continue
            # A file and not the standard input: processes that Python starts read their parent's again.
            script = Path(folder) / f"page_step.{step.language}"
            script.write_text(patient(step.text) if step.language == "sh" else step.text)
            if subprocess.run([*_RUN[step.language], script.name], cwd=folder, stdout=output,
                              stderr=subprocess.STDOUT).returncode:
                output.seek(0)
                return f"{output.read()}\n{page}: failed in\n{step.text}"
    print(f"--- {page.name}: ok, {time.monotonic() - began:.0f} s", flush=True)
    return None


def main(pages: list[Path], workers: int | None) -> int:
    """Run every page, those that keep in step with the wall clock one after the other; exit code."""
    run = [page for page in pages if any(step.file is None for step in steps(page))]
    paced = [page for page in run if any("--realtime" in step.text for step in steps(page))]
    with ThreadPoolExecutor(workers) as pool:
        outputs = [*pool.map(follow, [page for page in run if page not in paced]), *map(follow, paced)]
    failures = [output for output in outputs if output is not None]
    print("\n".join(failures), file=sys.stderr, end="")
    return 1 if failures else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("pages", nargs="*", type=Path)
    given = parser.parse_args()
    sys.exit(main([page.resolve() for page in given.pages] or sorted(DOCS.rglob("*.md")), given.workers))
