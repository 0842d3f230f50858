"""Prints the commands of the README: `readme.py test` the one that tests, `readme.py commands` the others."""

import re
import sys
from pathlib import Path

from patience import patient

text = Path(__file__).resolve().parent.parent.joinpath("README.md").read_text()
blocks = re.findall(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
lines = [line for block in blocks for line in block.splitlines() if line.strip()]
tests = [line for line in lines if line.rstrip().endswith("-m pytest")]
if len(tests) != 1:
    sys.exit(f"README.md: {len(tests)} commands end in '-m pytest', expected one")
print(tests[0] if sys.argv[1] == "test" else patient("\n".join(line for line in lines if line not in tests)))
