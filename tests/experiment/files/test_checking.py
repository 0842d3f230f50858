"""The forms that tables are checked against are kept, and are never those of other classes."""

from dataclasses import dataclass

import pytest

from fesloop.errors import InputError
from fesloop.experiment.files.parse import check, load


def block_class(annotation):
    """Another class each time, of the same name."""
    @dataclass(frozen=True, kw_only=True)
    class Gain:
        gain: annotation

    return Gain


def document(gain):
    return {"experiment": {"name": "gains"}, "blocks": {"gain": {"kind": "gain", "gain": gain}}}


def test_a_kind_that_is_another_class_now_is_checked_by_that():
    first, second = block_class(float), block_class(str)
    for _ in range(2):
        check(document(1.5), {"gain": first}, [])
        check(document("loud"), {"gain": second}, [])
        with pytest.raises(InputError, match=r"blocks\.gain\.gain: \"loud\" is text; allowed: a number"):
            check(document("loud"), {"gain": first}, [])
        with pytest.raises(InputError, match=r"blocks\.gain\.gain: 1\.5 is a number; allowed: text"):
            check(document(1.5), {"gain": second}, [])


def test_a_kind_that_comes_to_others_is_known():
    gain = block_class(float)
    tables = document(1.0)
    tables["blocks"]["other"] = {"kind": "other", "gain": 2.0}
    check(document(1.0), {"gain": gain}, [])
    check(tables, {"gain": gain, "other": block_class(float)}, [])


@pytest.mark.parametrize(("name", "setting", "told"), [
    ("grasp_ilc", 'blocks.controller.bank=["A.toml"]', 'bank[0]: "A.toml" is text; allowed: a table; to name '
     'a file: { file = "A.toml" }'),
    ("grasp_mpc", 'blocks.controller.model="A.toml"', 'to name a file: { file = "A.toml" }'),
    ("grasp_mpc", 'blocks.hand.table="A.toml"', '"A.toml" is text; allowed: a table')])
def test_a_file_in_place_of_its_table_is_answered_with_the_table(name, setting, told):
    with pytest.raises(InputError) as refused:
        load(name, [setting])
    assert str(refused.value).endswith(told)
