"""Parts of pages that are made when the site is built: all that there is stands in them, and is right."""

import re
import shlex
from collections import Counter
from importlib import import_module
from pathlib import Path

import pytest
from block_kinds import block_pages, kinds_of
from command_pages import command_pages
from experiment_pages import commands_of, experiment_page, passages

import fesloop
import fesloop.analysis.study
import fesloop.show.figures
from fesloop.apps.cli.parser import make_parser
from fesloop.apps.cli.reproduce_command import PAPERS
from fesloop.experiment import registry
from fesloop.experiment.files.parse import read
from fesloop.experiment.files.source import shipped

DOCS = Path(__file__).resolve().parents[2] / "docs"
PACKAGES = ("controllers", "plants", "estimators", "fesloop")


def fenced(page, name):
    return re.findall(rf"^```\{{{name}\}} ?(.*)\n((?:.*\n)*?)```$", (DOCS / page).read_text(), re.MULTILINE)


def test_every_shipped_experiment_has_its_place_once():
    named = Counter(name for _, lines in fenced("experiments.md", "experiments") for name in lines.split())
    assert named == Counter(shipped())


@pytest.mark.parametrize("name", shipped())
def test_every_command_of_an_experiments_page_is_one_of_the_program(name):
    every = list(commands_of(name))
    assert every
    for command in every:
        assert not command.endswith("\\")
        words = shlex.split(command)
        assert words[0] == "fesloop"
        make_parser().parse_args(words[1:])


@pytest.mark.parametrize("name", shipped())
def test_a_page_has_every_variant_and_every_short_name(name):
    text, document = "\n".join(experiment_page(name)), read(name)[1]
    for alias in document.get("aliases", {}):
        assert f"| `{alias}` |" in text
    for variant, table in document.get("variants", {}).items():
        assert f"| `{variant}=...` |" in text
        for option in set(table) - {"default"} | {table["default"]}:
            assert f"| `{option}` |" in text


def test_a_comment_is_prose_and_commands():
    text = ("# One line,\n# and one.\n#\n#     fesloop run a \\\n#         --set b=c\n#     fesloop list\n#\n"
            "# Then.\n\n# Not.")
    found = [(each.is_command, each.lines) for each in passages(text)]
    assert found == [(False, ("One line,", "and one.")),
                     (True, ("fesloop run a \\", "    --set b=c", "fesloop list")),
                     (False, ("Then.",))]


def test_every_picture_is_small_and_told_of():
    import json

    pictures = {path.stem: path.stat().st_size for path in (DOCS / "_pictures").glob("*.*g")}
    assert set(pictures) == set(json.loads((DOCS / "_pictures" / "shown.json").read_text()))
    assert set(pictures) <= set(shipped())
    assert max(pictures.values()) < 120_000


def test_every_picture_of_a_reproduction_is_small_and_on_a_page():
    pages = "".join(page.read_text() for page in DOCS.rglob("*.md"))
    shown = set(re.findall(r"\]\(\.\./results/(\w+\.png)\)", pages))
    sizes = {path.name: path.stat().st_size for path in (DOCS / "results").glob("*.png")}
    assert shown
    assert shown == set(sizes)
    assert max(sizes.values()) < 150_000


def test_every_block_kind_is_in_the_reference():
    pages = {package: "\n".join(block_pages(package)) for package in PACKAGES}
    for kind in registry.kinds():
        block = registry.find(kind)
        package = block.__module__.partition(".")[0]
        assert kind in kinds_of(package)
        assert f"## `{kind}`" in pages[package]
        named = re.search(rf"autoclass:: ([\w.]+)\.{block.__qualname__}$", pages[package], re.MULTILINE)
        assert getattr(import_module(named[1]), block.__qualname__) is block
    shown = {argument for page in (DOCS / "reference").glob("*.md")
             for argument, _ in fenced(page.relative_to(DOCS), "block-kinds")}
    assert shown == set(PACKAGES)


@pytest.mark.parametrize(("module", "page"), [
    (fesloop, "fesloop.md"), (fesloop.analysis.study, "studies.md"), (fesloop.show.figures, "studies.md")])
def test_every_public_name_is_in_the_reference(module, page):
    shown: dict[str, list[str]] = {}
    current = "fesloop"
    for directive, name in re.findall(r"^\.\. (\w+):: ([\w.]+)$", (DOCS / "reference" / page).read_text(),
                                      re.MULTILINE):
        if directive == "currentmodule":
            current = name
        elif directive.startswith("auto") and "." not in name:
            shown.setdefault(current, []).append(name)
    assert sorted(shown[module.__name__]) == sorted(module.__all__)


def test_every_command_is_told_of_with_its_options():
    text = "\n".join(command_pages())
    every = re.findall(r"^    ([a-z][a-z-]*) ", make_parser().format_help(), re.MULTILINE)
    assert {"run", "study", "report"} <= set(every)
    for name in every:
        assert f"\n## fesloop {name}\n" in f"\n{text}"
    assert "## fesloop fmu build" in text
    assert "| `--late` |" in text
    assert "| `--out` | folder of the recording (default: runs) |" in text


def test_every_paper_has_its_place_on_the_page_of_validation():
    shown = [name for name, _ in fenced("validation.md", "result")]
    assert shown == re.findall(r"fesloop reproduce (\w+)", (DOCS / "validation.md").read_text())
    assert set(shown) == set(PAPERS)


def test_the_help_of_reproduce_names_every_paper(capsys):
    with pytest.raises(SystemExit):
        make_parser().parse_args(["reproduce", "--help"])
    assert set(PAPERS) <= set(re.findall(r"\w+", capsys.readouterr().out))
