"""Block kinds: what a package that does not import amounts to."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.experiment import registry


class Broken:
    """An entry point whose package ends in an error."""

    value = "broken.package:Block"

    def __init__(self, cause):
        self.cause = cause

    def load(self):
        raise ImportError("initialization failed") from self.cause


@pytest.fixture
def broken(monkeypatch):
    """Makes `kind` one whose package ends in an error with this cause."""
    def make(kind, cause):
        monkeypatch.setattr(registry, "_entries", lambda: {kind: Broken(cause)})
    return make


def test_a_package_that_does_not_import_is_named(broken):
    broken("broken_kind", None)
    with pytest.raises(InputError, match=r"'broken_kind' \(broken\.package:Block\) does not import: init"):
        registry.find("broken_kind")


def test_an_interrupt_while_importing_is_an_interrupt(broken):
    broken("interrupted_kind", KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        registry.find("interrupted_kind")


@pytest.mark.parametrize("kind", ["__main__:Policy", "my.package:Block"])
def test_a_class_that_is_no_kind_is_told_how_to_become_one(kind):
    with pytest.raises(InputError, match=r"@fesloop\.block .*entry point .*fesloop\.blocks"):
        registry.find(kind)


def test_summaries_are_the_first_lines_of_docstrings():
    for kind in registry.kinds():
        assert registry.summary(kind) == registry.find(kind).__doc__.strip().partition("\n")[0]
        assert registry.summary(kind)


def test_the_summary_of_a_class_without_a_source_is_read_from_the_class(monkeypatch):
    monkeypatch.setattr(registry, "_source", lambda module: None)
    assert registry.summary("pid") == registry.find("pid").__doc__.strip().partition("\n")[0]


def installed(folder, tmp_path, url):
    """A site directory that says that the package `mine` was installed from `url`, and its source folder."""
    info = tmp_path / "site" / "mine-1.0.dist-info"
    info.mkdir(parents=True, exist_ok=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (info / "direct_url.json").write_text(json.dumps({"url": url, "dir_info": {"editable": True}}))
    folder.mkdir(exist_ok=True)
    (folder / "pyproject.toml").write_text(
        '[project]\nname = "mine"\n[project.entry-points."fesloop.blocks"]\nnew_kind = "mine:Block"\n')
    return tmp_path / "site"


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=20, deadline=None)
@given(st.sampled_from(["new_kind", "other_kind"]), st.sampled_from(["", "file", "https"]))
def test_a_kind_that_a_source_declares_since_its_installation_is_to_be_installed(
        monkeypatch, tmp_path, kind, scheme):
    """Whatever the folder is called; a package from elsewhere, or without the kind, is not blamed."""
    folder = tmp_path / "my source"
    url = {"": "", "file": folder.as_uri(), "https": folder.as_uri().replace("file", "https")}[scheme]
    with monkeypatch.context() as changed:
        changed.syspath_prepend(installed(folder, tmp_path, url))
        with pytest.raises(InputError, match=f"there is no block kind '{kind}'") as refused:
            registry.find(kind)
    hint = (f"{folder}/pyproject.toml declares it since mine was installed: install it again "
            f"(pip install -e '{folder}')")
    assert (hint in str(refused.value)) == (kind == "new_kind" and scheme == "file")
