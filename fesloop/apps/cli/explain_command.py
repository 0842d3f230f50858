"""`fesloop explain`."""

from __future__ import annotations

import re
import sys
from argparse import Namespace
from collections.abc import Mapping, Sequence
from textwrap import fill

from fesloop.analysis.study.design.shipped_studies import kept_metrics, shipped_studies
from fesloop.apps.cli.output import print_json, print_table
from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.experiment.files.source import read_experiment, shipped
from fesloop.experiment.metrics.words import Definition, definitions_of, groups, plain_text

_WIDTH = 100
_MOST_NAMED = 5
"""Names that a message lists (chosen: it is one line)."""


def execute(args: Namespace) -> int:
    """Print definitions of numbers; without a name, a line for each."""
    if not args.metrics:
        return _list_all(as_json=args.json)
    found, studies = {}, kept_metrics()
    for name in args.metrics:
        try:
            found[name] = definitions_of(name, studies)
        except InputError as fault:
            if name not in studies:
                raise _explained(name, fault) from None
            found[name] = []
    if args.json:
        print_json({name: {"definitions": [each.as_table() for each in definitions],
                           "studies": studies.get(name, {})} for name, definitions in found.items()})
        return 0
    for number, (name, definitions) in enumerate(found.items()):
        if number:
            print()
        print("\n\n".join([*map(_text, definitions), *_in_studies(name, studies.get(name, {}))]))
    return 0


def _explained(name: str, fault: InputError) -> InputError:
    """The fault of a name that is no number, with what else has the name or a part of it."""
    if kind := _kind_of_signal(name):
        package = registry.find(kind).__module__.partition(".")[0]
        return InputError(
            fault.where, f"{name!r} is a signal of a recording (block kind {kind}), and no number",
            "numbers as commands print them", f"docs/reference/{package}.md explains the outputs of {kind}")
    whole = [f"the {word} {name} (`{command}`)" for word, known, command in (
        ("experiment", shipped(), f"fesloop check {name}"),
        ("study", shipped_studies(), f"fesloop study {name} --dry-run"),
        ("kind of block", registry.kinds(), "fesloop list")) if name in known]
    printed = [each.name for group in groups() for each in group.definitions
               if name in group.command.replace(",", "").split()]
    if printed:
        whole.insert(0, f"the command `fesloop {name}`, which prints {_some(printed)}")
    parts = [f"{word} ({_some(likes)})" for word, likes in (
        ("numbers", [each.name for group in groups() for each in group.definitions
                        if name in re.split(r"[_\W]+", each.name)]),
        ("experiments", [each for each in shipped() if name in each.split("_")])) if likes]
    if whole:
        found = f"{name!r} is {', and '.join(whole)}, and no number"
    elif parts:
        found = f"{name!r} is no number, but a part of names of {' and of '.join(parts)}"
    else:
        return fault
    return InputError(fault.where, found, "numbers as commands print them", "`fesloop explain` lists all")


def _kind_of_signal(name: str) -> str:
    """Kind of the block of a shipped experiment whose output a name NODE.PORT is; empty without one."""
    node, _, port = name.strip().partition(".")
    for experiment in shipped() if port else ():
        table = read_experiment(experiment)[1]["blocks"].get(node)
        if table and f"`{port}`" in (registry.find(table["kind"]).__doc__ or ""):
            return str(table["kind"])
    return ""


def _some(names: Sequence[str]) -> str:
    """The first few of some names."""
    every = list(dict.fromkeys(names))
    more = f" and {len(every) - _MOST_NAMED} more" if len(every) > _MOST_NAMED else ""
    return ", ".join(every[:_MOST_NAMED]) + more


def _list_all(*, as_json: bool) -> int:
    if as_json:
        print_json({group.title: [each.as_table() for each in group.definitions] for group in groups()})
        return 0
    for group in groups():
        print_table(f"{group.title} ({group.command})", ("number", "unit", "what it is"), [
            (each.name, each.unit, _first_sentence(each.what)) for each in group.definitions], sys.stdout)
        print()
    return 0


def _first_sentence(text: str) -> str:
    first, stop, _ = plain_text(text).partition(". ")
    return first + stop.strip()


def _text(definition: Definition) -> str:
    """Paragraphs on a number, its name and unit first."""
    unit = f", {definition.unit}" if definition.unit else ""
    lines = [f"{definition.name}{unit} ({definition.command})", _indented(definition.what)]
    lines += [_indented(f"{part}: {what}") for part, what in definition.parts.items()]
    if definition.shown:
        lines.append(_indented(f"Printed as: {', '.join(definition.shown)}"))
    lines.append(_indented(f"No number (- in tables, nan, null in JSON): {definition.nan}." if definition.nan
                           else "There is always one."))
    return "\n".join(lines)


def _in_studies(name: str, sources: Mapping[str, str]) -> list[str]:
    """A paragraph on a number that shipped studies keep under a name of their own."""
    if not sources or set(sources.values()) == {name}:
        return []
    by_source: dict[str, list[str]] = {}
    for study, source in sources.items():
        by_source.setdefault(source, []).append(study)
    return ["\n".join([f"{name} (fesloop study)", *(
        _indented(f"{source} in {', '.join(where)}") for source, where in by_source.items()), *(
        _indented(f"See: fesloop explain {source.partition(':')[0].rstrip('?')}") for source in by_source)])]


def _indented(text: str) -> str:
    return fill(plain_text(text), _WIDTH, initial_indent="    ", subsequent_indent="    ")
