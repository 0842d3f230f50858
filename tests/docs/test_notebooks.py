"""Notebooks of the documentation: they run, and are kept without outputs."""

from pathlib import Path

import pytest

NOTEBOOKS = Path(__file__).resolve().parents[2] / "docs" / "notebooks"
PATHS = sorted(NOTEBOOKS.glob("*.ipynb"))
_LONGEST_S = 60


@pytest.fixture
def books():
    nbformat = pytest.importorskip("nbformat")
    return {path: nbformat.read(path, 4) for path in PATHS}


def test_they_are_kept_without_outputs_and_listed(books):
    index = (NOTEBOOKS / "index.md").read_text()
    assert len(books) == 5
    for path, book in books.items():
        assert f"({path.name})" in index
        assert not any(cell.get("outputs") or cell.get("execution_count") for cell in book.cells)


@pytest.mark.slow
@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_it_runs_and_draws_one_figure(path, books, tmp_path):
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    book = books[path]
    nbclient.NotebookClient(book, timeout=_LONGEST_S, kernel_name="python3",
                            resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in book.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 1
    assert not [output for output in outputs
                if output.output_type == "error" or output.get("name") == "stderr"]
