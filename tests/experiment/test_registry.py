"""Block kinds: what a package that does not import amounts to."""

import pytest

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
