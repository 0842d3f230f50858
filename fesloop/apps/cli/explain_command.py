"""`fesloop explain`."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Mapping
from textwrap import fill

from fesloop.analysis.study.design.shipped_studies import kept_metrics
from fesloop.apps.cli.output import print_json, print_table
from fesloop.errors import InputError
from fesloop.experiment.metrics.words import Definition, definitions_of, groups, plain_text

_WIDTH = 100


def execute(args: Namespace) -> int:
    """Print definitions of numbers; without a name, a line for each."""
    if not args.metrics:
        return _list_all(as_json=args.json)
    found, studies = {}, kept_metrics()
    for name in args.metrics:
        try:
            found[name] = definitions_of(name, studies)
        except InputError:
            if name not in studies:
                raise
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
                           else "There is always a number."))
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
