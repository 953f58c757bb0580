"""Every notebook runs from its first cell to its last, and is kept without what came out."""

import os
import pathlib

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = pathlib.Path(os.environ["PLENOSCOPE_NOTEBOOKS"])


@pytest.mark.parametrize("name", ["look", "measure", "train"])
def test_a_notebook_runs(name, tmp_path):
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", 4)
    nbformat.validate(notebook)
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in notebook.cells)
    NotebookClient(notebook, timeout=1200, resources={"metadata": {"path": tmp_path}}).execute()
    pictures = [out for cell in notebook.cells for out in cell.get("outputs", []) if "image/png" in out.get("data", {})]
    assert pictures, "it shows something"


def test_all_notebooks_are_named_here():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} == {"look", "measure", "train"}
