"""Pages of the shipped experiments, from their files: what each is, how it is run, what `--set` changes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from markdown_text import cell, code, table, with_links

from fesloop.experiment.files.parse import read
from fesloop.experiment.files.variants import listed

PICTURES = Path(__file__).resolve().parents[1] / "_pictures"


@dataclass(frozen=True, slots=True)
class Passage:
    """Prose of the comment that a file begins with, or commands in it."""

    is_command: bool
    lines: tuple[str, ...]


def passages(text: str) -> list[Passage]:
    """The comment at the head of a file: lines indented by four are commands, others prose."""
    found: list[tuple[bool, list[str]]] = []
    fresh = True
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        bare = line[1:]
        is_command = bare.startswith("     ")
        if not bare.strip():
            fresh = True
            continue
        if fresh or found[-1][0] != is_command:
            found.append((is_command, []))
        found[-1][1].append(bare[5:] if is_command else bare.strip())
        fresh = False
    return [Passage(is_command, tuple(lines)) for is_command, lines in found]


def experiment_page(name: str) -> Iterator[str]:
    """Lines of MyST Markdown, to stand under a heading of the second level."""
    document = read(name)[1]
    yield from (f"### {name}", "", cell(document["experiment"]["description"]) + ".", "")
    yield from _picture(name)
    commands = 0
    for passage in passages(files("fesloop.experiment").joinpath("shipped", f"{name}.toml").read_text()):
        commands += passage.is_command
        yield from _shown(passage)
    if not commands:
        yield from ("```console", f"$ fesloop run {name}", "```", "")
    yield from _facts(name, document)
    yield from _settings(name, document)


def _shown(passage: Passage) -> Iterator[str]:
    if passage.is_command:
        yield "```console"
        within = False
        for line in passage.lines:
            yield line if within else f"$ {line}"
            within = line.endswith("\\")
        yield from ("```", "")
    else:
        yield from (with_links(" ".join(passage.lines)), "")


def _picture(name: str) -> Iterator[str]:
    """The picture, where there is one, with what was run for it."""
    for path in PICTURES.glob(f"{name}.*g"):
        shown = json.loads((PICTURES / "shown.json").read_text())[name]
        yield from (f"```{{figure}} /_pictures/{path.name}", f":alt: {_told(shown)}", "",
                    f"{_told(shown)}: `{shown['command']}`", "```", "")


def _told(shown: Mapping[str, Any]) -> str:
    """Alternative text of a picture."""
    return {"hand": "The hand; a tracker's estimate in orange where there is one",
            "arrays": "The electrode arrays on the unrolled forearm, and what they recruit",
            "search": "What each element of the arrays was good for at best; ringed is what was found",
            "courses": "The first joint, and what is stimulated or what each trial came to",
            }[shown["drawn"]]


def _facts(name: str, document: Mapping[str, Any]) -> Iterator[str]:
    """How long a run takes and what it needs."""
    about, guide = document["experiment"], document.get("guide", {})
    trials = about.get("trials", 1)
    lasts = f"{about['duration_s']:g} s" if "duration_s" in about else "as long as what it plays"
    facts = [f"Lasts {lasts}" if trials == 1 else f"Has {trials} trials of {lasts}"]
    if guide:
        facts.append(f"takes about {guide['takes_s']:g} s")
        needs = [re.sub(r"^extra (\w+)$", r"the extra `\1`", each) for each in guide.get("needs", [])]
        facts += [f"needs {each}" for each in needs]
    yield from ("; ".join(facts) + ".", "")
    if guide.get("try_next"):
        yield from ("Then try:", "", "```console", *(f"$ {each}" for each in guide["try_next"]), "```", "")


def _settings(name: str, document: Mapping[str, Any]) -> Iterator[str]:
    """Variants and short names, folded away."""
    variants = listed(document) if "variants" in document else {}
    aliases = document.get("aliases", {})
    if not (variants or aliases):
        return
    yield from (f":::{{dropdown}} What `--set` changes in {name}", "")
    for variant, options in variants.items():
        default = options["default"]
        texts = {default: ""} | options["options"]
        rows = [(code(option), (cell(text) or "as the file stands") + " (default)" * (option == default))
                for option, text in texts.items()]
        yield from table((code(f"{variant}=..."), "what it picks"), rows)
    if aliases:
        rows = [(code(alias), "<br>".join(code(each) for each in ([keys] if isinstance(keys, str) else keys)))
                for alias, keys in aliases.items()]
        yield from table(("short name", "key"), rows)
    yield from (":::", "")


def commands_of(name: str) -> Iterator[str]:
    """Every command on an experiment's page."""
    within = ""
    for line in experiment_page(name):
        if line.startswith("$ ") or within:
            within += line.removeprefix("$ ").removesuffix("\\")
            if not line.endswith("\\"):
                yield within
                within = ""
