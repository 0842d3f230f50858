"""How the library's modules depend on each other."""

import house
import pytest
from hypothesis import given
from hypothesis import strategies as st


def test_no_module_is_part_of_a_circle_and_none_imports_from_above():
    graph = house.imports(house.modules())
    assert len(graph) > 300
    assert house.circles(graph) == []
    assert house.upward(graph, house.storeys()) == []


@given(length=st.integers(2, 6), beside=st.integers(0, 3))
def test_a_circle_is_found_whatever_hangs_on_it(length, beside):
    ring = [f"ring{i}" for i in range(length)]
    graph = {name: {ring[(i + 1) % length]} for i, name in enumerate(ring)}
    graph |= {f"user{i}": {ring[0]} for i in range(beside)}
    assert house.circles(graph) == [sorted(ring)]


def test_an_arrow_to_a_storey_above_is_found():
    rooms = [{"low"}, {"high", "beside"}]
    graph = {"low.a": {"high.b"}, "high.b": {"low.a", "beside.c"}, "beside.c": set()}
    assert house.upward(graph, rooms) == [("low.a", "high.b")]


def test_imports_for_types_alone_and_within_functions_count(tmp_path):
    typed = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from p.b import B\n"
    (tmp_path / "a.py").write_text(typed)
    (tmp_path / "b.py").write_text("class B:\n    def f(self):\n        from p import a\n        return a\n")
    known = {"p.a": tmp_path / "a.py", "p.b": tmp_path / "b.py"}
    assert house.imports(known) == {"p.a": {"p.b"}, "p.b": {"p.a"}}


@pytest.mark.slow
def test_a_run_loads_few_modules():
    assert house.loaded_by_a_run() <= house.MOST_LOADED
