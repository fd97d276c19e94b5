"""The notebooks in `examples/notebooks`, run as a reader would, in a folder of their own."""

import ast
import shutil
from pathlib import Path

import nbclient
import nbformat
import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
PATIENCE = 600  # for a cell on a busy machine [s]
FREE = {"model_lab", "numpy", "pandas", "matplotlib", "pathlib"}
CAMERA = "np.arange(0.0, KNOTS[-1], {})"  # times of the two files' camera, here twice as slow
CHECKS = {
    "two_csv_files": """
(effect,) = found.effects
assert effect.cause == "stiffening", effect
assert before.error > 3.0 * after.error and after.error < 1.3 * after.floor
assert after.unit == "deg"
""",
    "rubber_to_finger": """
errors = lab.ladder(pulls, {"base": "base", **laws}).errors
assert max(errors["gent_stiffening"], errors["yeoh_stiffening"]) < 0.5 * errors["base"]
assert angles["gent_stiffening"].iloc[-1] < angles["neo-Hooke"].iloc[-1]
""",
    "bag_to_hand": """
(effect,) = found.effects
assert effect.name == "ballooning"
assert abs(effect.parameters["gain"].value - 0.3) < 0.02  # as examples/record_bag.py has it
assert model.errors[-1] < 0.1 * model.errors[0]
""",
}


def notebook(name):
    return nbformat.read(EXAMPLES / "notebooks" / f"{name}.ipynb", as_version=4)


def code(name):
    return [cell for cell in notebook(name).cells if cell.cell_type == "code"]


def test_every_notebook_is_run_here():
    assert {path.stem for path in (EXAMPLES / "notebooks").glob("*.ipynb")} == set(CHECKS)


@pytest.mark.parametrize("name", CHECKS)
def test_a_notebook_holds_no_outputs_and_imports_the_lab_from_its_top(name):
    for cell in code(name):
        assert not cell.outputs and cell.execution_count is None
        text = "\n".join(line for line in cell.source.splitlines() if not line.startswith("%"))
        for node in ast.walk(ast.parse(text)):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) else []
            assert all(one.partition(".")[0] in FREE for one in names)
            assert not any(one.startswith("model_lab.") for one in names)


@pytest.mark.parametrize("name", CHECKS)
def test_a_notebook_runs_and_finds_what_is_in_its_data(name, tmp_path):
    shutil.copytree(EXAMPLES, tmp_path / "examples", ignore=shutil.ignore_patterns("__pycache__"))
    two_files = tmp_path / "examples" / "two_csv_files.py"
    script = two_files.read_text()
    assert CAMERA.format(0.05) in script
    two_files.write_text(script.replace(CAMERA.format(0.05), CAMERA.format(0.1)))
    book = notebook(name)
    book.cells.append(nbformat.v4.new_code_cell(CHECKS[name]))
    folder = str(tmp_path / "examples" / "notebooks")
    client = nbclient.NotebookClient(
        book, timeout=PATIENCE, resources={"metadata": {"path": folder}}
    )
    client.execute()
    shown = [out for cell in book.cells for out in cell.get("outputs", ())]
    pages = [out.data["text/html"] for out in shown if "text/html" in out.get("data", {})]
    assert pages and all("<svg" in page or "<table" in page for page in pages)
