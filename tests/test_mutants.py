"""The list of faults fits the library."""

from collections import Counter

import mutants
import pytest

EVERY = mutants.listed()


def test_every_fault_has_its_place():
    for mutant in EVERY:
        path, begin, end = mutants.place(mutant)
        text = path.read_text(encoding="utf-8")
        compile(text[:begin] + mutant.new + text[end:], str(path), "exec")


def test_faults_are_of_five_kinds_and_of_every_package():
    assert len({mutant.name for mutant in EVERY}) == len(EVERY) == 40
    assert set(Counter(mutant.kind for mutant in EVERY).values()) == {8}
    folders = (mutant.file.split("/") for mutant in EVERY)
    rooms = {"/".join(each[:2]) if each[0] == "fesloop" else each[0] for each in folders}
    assert rooms == {"plants", "estimators", "controllers", *(
        f"fesloop/{room}" for room in ("loop", "hand", "experiment", "streams", "analysis", "show"))}


def test_a_text_that_is_gone_or_moved_is_told(tmp_path):
    mutant = mutants.Mutant("sign", "sign", "fesloop/gone.py", "a +\n b", "a - b", [])
    (tmp_path / "fesloop").mkdir()
    with pytest.raises(mutants.NotFoundError, match=r"sign: fesloop/gone.py does not hold"):
        mutants.place(mutant, tmp_path)
    (tmp_path / "fesloop" / "here.py").write_text("total = a  + b")
    assert mutants.place(mutant, tmp_path) == (tmp_path / "fesloop" / "here.py", 8, 14)
    (tmp_path / "fesloop" / "there.py").write_text("a + b")
    with pytest.raises(mutants.NotFoundError, match=r"other modules: fesloop/here.py, fesloop/there.py"):
        mutants.place(mutant, tmp_path)
