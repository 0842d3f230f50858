"""Writes docs/metrics.md from the definitions of numbers that the program has.

    python docs/_extensions/metric_pages.py
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fesloop.experiment.metrics.words import Definition, Group, groups

PAGE = Path(__file__).resolve().parents[1] / "metrics.md"
_HEAD = """\
# Numbers

Every number that a command prints: its unit, what it is, and when there is none. Where there is none,
tables print `-`, Python has `nan` or `None`, JSON `null`; the summary of a run then also states the reason in
that run. `fesloop explain` prints the same:

```sh
fesloop explain grip_margin
fesloop explain "split_rmse_deg tracker"
```

So does `--explain grip_margin` of every command that prints numbers.

A number is found by its name in `--json`, or as it is printed. Numbers that [studies](studies.md) keep under
names of their own are explained by the number that they come from. This page is made from
`fesloop/experiment/metrics/words.toml` by `python docs/_extensions/metric_pages.py`.
"""


def metrics_page() -> str:
    """Text of the page."""
    return "\n".join([_HEAD, *(line for group in groups() for line in _section(group))])


def _section(group: Group) -> Iterator[str]:
    yield f"## {group.title}\n"
    yield f"`{group.command}`. {group.about}".strip() + "\n"
    yield "| number | unit | what it is | no number |"
    yield "|---|---|---|---|"
    for each in group.definitions:
        cells = (_name(each), each.unit, _what(each), each.nan)
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
    yield ""


def _name(definition: Definition) -> str:
    shown = ", ".join(definition.shown)
    return f"`{definition.name}`" + (f" ({shown})" if shown else "")


def _what(definition: Definition) -> str:
    return " ".join([definition.what, *(f"**{part}**: {what}." for part, what in definition.parts.items())])


if __name__ == "__main__":
    PAGE.write_text(metrics_page(), encoding="utf-8")
