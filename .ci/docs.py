"""Do what the pages of docs/ show: `docs.py PAGE...` follows each page in a scratch folder of its own.

A fenced block under a line that is a name in backquotes is a file, and is written. Blocks of `sh` are run by
bash, which stops at the first command that fails, blocks of `python` without a name by Python. What needs
hardware, a file of yours or hours stands in blocks of `console`, behind `$ `, or of `py`, and is not run.
Without a PAGE: every page that has something to run. Ends with 1 if a page fails, after what it printed.
"""

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
    """Something to do: write `text` to the file of that name, or, without a name, run it as its language."""

    file: str | None
    language: str
    text: str


def steps(page: Path) -> list[Step]:
    """What a page asks to be written and run, in order."""
    found = [Step(**match.groupdict()) for match in _FENCE.finditer(page.read_text())]
    return [step for step in found if step.file or step.language in _RUN]


def write(step: Step, folder: Path) -> None:
    """Leave a page's file in a folder."""
    path = folder / str(step.file)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(step.text)


def follow(page: Path) -> str | None:
    """Do what a page says; what it printed up to what failed, or None if all of it went well."""
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as told:
        for step in steps(page):
            if step.file:
                write(step, Path(folder))
                continue
            # A file and not the standard input: processes that Python starts read their parent's again.
            script = Path(folder) / f"page_step.{step.language}"
            script.write_text(patient(step.text) if step.language == "sh" else step.text)
            if subprocess.run([*_RUN[step.language], script.name], cwd=folder, stdout=told,
                              stderr=subprocess.STDOUT).returncode:
                told.seek(0)
                return f"{told.read()}\n{page}: failed in\n{step.text}"
    print(f"--- {page.name}: ok, {time.monotonic() - began:.0f} s", flush=True)
    return None


def main(pages: list[Path]) -> int:
    """Follow every page, one a core, and what keeps in step with the wall clock by itself; exit code."""
    run = [page for page in pages if any(step.file is None for step in steps(page))]
    paced = [page for page in run if any("--realtime" in step.text for step in steps(page))]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        failures = list(pool.map(follow, [page for page in run if page not in paced]))
    failures += map(follow, paced)
    told = [failure for failure in failures if failure is not None]
    print("\n".join(told), file=sys.stderr, end="")
    return 1 if told else 0


if __name__ == "__main__":
    given = [Path(each).resolve() for each in sys.argv[1:]]
    sys.exit(main(given or sorted(DOCS.rglob("*.md"))))
