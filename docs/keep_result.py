"""Keeps what a command of fesloop printed, for the page on validation:

    fesloop reproduce kortier2014 --json | python docs/keep_result.py fesloop reproduce kortier2014

writes docs/results/kortier2014.json with the command, the version, the commit of the folder it is run in,
and the day.
"""

from __future__ import annotations

import json
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

RESULTS = Path(__file__).resolve().parent / "results"


def main(command: list[str]) -> int:
    """Write the file; exit code."""
    found = json.load(sys.stdin)
    name = found.get("paper") or found.get("bench")
    if not command or not name:
        print(f"usage: ... --json | {Path(sys.argv[0]).name} COMMAND...", file=sys.stderr)
        return 2
    head = ["git", "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(head, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()
    kept = {"command": " ".join(command), "version": version("fesloop"), "commit": commit,
            "day": datetime.now(UTC).date().isoformat(), "found": found}
    path = RESULTS / f"{name}.json"
    path.write_text(json.dumps(kept, indent=1) + "\n")
    print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
