"""Every command of the program with its options, from the parser that the program has."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from markdown_text import cell, code, table

from fesloop.apps.cli.parser import make_parser


def command_pages() -> Iterator[str]:
    """Lines of MyST Markdown, to stand under a heading of the first level."""
    yield from _pages(make_parser())


def _pages(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Commands of a parser, and theirs."""
    for actions in (each for each in parser._actions if isinstance(each, argparse._SubParsersAction)):
        helps = {each.dest: each.help for each in actions._choices_actions}
        for name, command in actions.choices.items():
            yield from (f"## {command.prog}", "", f"{cell(helps[name])}.", "")
            yield from ("```text", *_usage(command), "```", "")
            yield from _options(command)
            yield from _pages(command)


def _usage(command: argparse.ArgumentParser) -> list[str]:
    """How it is called, as its own help says."""
    return command.format_usage().removeprefix("usage: ").rstrip().replace("\n       ", "\n").splitlines()


def _options(command: argparse.ArgumentParser) -> Iterator[str]:
    """Options and arguments of a command, a line each."""
    formatter = command._get_formatter()
    rows = [(code(", ".join(each.option_strings) or formatter._format_action_invocation(each)),
             cell(formatter._expand_help(each) if each.help else ""))
            for each in command._actions
            if not isinstance(each, argparse._HelpAction | argparse._SubParsersAction)]
    if rows:
        yield from table(("", ""), rows)
