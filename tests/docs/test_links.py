"""Links of pages and docstrings: DOIs are well formed, addresses are at hosts that we know."""

import re
import subprocess
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from docstrings import DOI, found_doi

ROOT = Path(__file__).resolve().parents[2]
HOSTS = {"bids-specification.readthedocs.io", "doi.org", "github.com", "labstreaminglayer.readthedocs.io",
         "python-control.org", "www.w3.org"}
NAMESPACES = "http://ssp-standard.org/SSP1/"
"""Start of names in XML that are no addresses: nothing is fetched from there."""
_ADDRESS = re.compile(r"\bhttps?://[^\s\"'`<>\\\])]+")
_DOI_LINK = re.compile(r"\[([^\]]*)\]\(https://doi\.org/(\S+?)\)(?!\d)")
_FORM = re.compile(r"10\.\d{4,9}/[!-~]*[A-Za-z0-9)]")


def told(endings, folders):
    """Files of the repository, new ones as well, in some folders or at its top."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True,
                            text=True).stdout.split("\n")
    every = listed if any(listed) else [str(path.relative_to(ROOT)) for path in ROOT.rglob("*.*")]
    return sorted(name for name in every if name.endswith(endings) and (ROOT / name).is_file()
                  and ("/" not in name or name.startswith(folders)) and "/node_modules/" not in name)


TOLD = told((".md", ".py", ".toml"), ("docs/", "fesloop/", "plants/", "estimators/", "controllers/"))


def test_there_is_what_to_look_at():
    assert {"README.md", "docs/index.md", "controllers/ilc/block.py"} <= set(TOLD)


@pytest.mark.parametrize("name", [name for name in TOLD if name.endswith(".md")])
def test_addresses_are_at_known_hosts(name):
    for address in _ADDRESS.findall((ROOT / name).read_text()):
        if address.startswith(NAMESPACES):
            continue
        parts = urlsplit(address)
        assert (parts.scheme, parts.netloc in HOSTS) == ("https", True), address


def test_addresses_in_the_code_are_at_known_hosts():
    for name in TOLD:
        if name.endswith((".py", ".toml")):
            for address in _ADDRESS.findall((ROOT / name).read_text()):
                host = urlsplit(address).netloc
                # A host in braces is the machine's own, named when the program runs.
                known = host in HOSTS or host.startswith("{") or address.startswith(NAMESPACES)
                assert known, f"{name}: {address}"


def test_dois_are_well_formed():
    found = 0
    for name in TOLD:
        text = (ROOT / name).read_text()
        for doi in (found_doi(match) for match in DOI.finditer(text)):
            assert _FORM.fullmatch(doi), f"{name}: {doi}"
            found += 1
    assert found > 50


@pytest.mark.parametrize("name", [name for name in TOLD if name.endswith(".md")])
def test_links_of_dois_lead_to_the_doi_that_they_name(name):
    for text, address in _DOI_LINK.findall((ROOT / name).read_text()):
        doi = unquote(address)
        assert _FORM.fullmatch(doi), f"{name}: {doi}"
        assert "10." not in text or doi in text, f"{name}: {text} leads to {doi}"


def test_every_naming_of_a_doi_has_one():
    """After the word there is one, but where the word itself is meant."""
    for name in TOLD:
        if name.startswith("docs/_"):
            continue
        for match in re.finditer(r"\bdoi[: ]\s*(\S+)", (ROOT / name).read_text()):
            assert match[1].startswith("10."), f"{name}: {match[0]}"
