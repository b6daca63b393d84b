"""The notebooks run from the first cell to the last; their own assertions are the test."""

import os
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")
pytest.importorskip("matplotlib")
pytest.importorskip("pandas")

FOLDER = Path(__file__).parents[1] / "notebooks"
# The end of the last cell's result.
RESULTS = {
    "a_bearings_life": "alarm at recording",
    "what_did_my_simulation_leave_out": "mismatch: misalignment",
    "from_a_notebook_to_a_microcontroller": "C and Python agree to the bit" if os.environ.get("BALLRACE_C_LIBRARY") else "not compiled",
}


def test_every_notebook_is_run():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} == set(RESULTS)


@pytest.mark.parametrize("name", RESULTS)
def test_a_notebook_runs_and_comes_without_outputs(name, tmp_path):
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(not cell.outputs and cell.execution_count is None for cell in code), "committed with outputs"
    # In another folder: here `ballrace` is the sources.
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()
    pictures = [output for cell in code for output in cell.outputs if "image/png" in output.get("data", {})]
    assert len(pictures) >= 2
    assert RESULTS[name] in code[-1].outputs[-1]["data"]["text/plain"]
