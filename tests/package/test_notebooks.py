"""The notebooks that ship: clean, and executed as they are."""

import importlib
import json

import pytest

from commands import command
from robsim._base.shipped import NOTEBOOKS, copy_notebooks

SHIPPED = sorted(NOTEBOOKS.glob("*.ipynb"))
LEFT_BEHIND = """
import threading
print([thread.name for thread in threading.enumerate() if thread.name.startswith("robsim")])
"""
each = pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)


def code_cells(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def test_there_are_notebooks():
    assert [file.name for file in SHIPPED] == [
        "00_panel.ipynb",
        "01_first_drive.ipynb",
        "02_write_a_controller.ipynb",
        "03_identification.ipynb",
        "04_state_estimation.ipynb",
        "05_latency.ipynb",
        "06_live.ipynb",
    ]


@each
def test_a_notebook_is_short_and_stripped(file):
    notebook = json.loads(file.read_text(encoding="utf-8"))
    assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
    assert notebook["metadata"]["kernelspec"]["name"] == "python3"
    assert 4 <= len(code_cells(notebook)) <= 10
    for cell in code_cells(notebook):
        assert (cell["outputs"], cell["execution_count"], cell["metadata"]) == ([], None, {})


@pytest.mark.slow
@each
def test_a_notebook_runs_as_a_student_gets_it(file, tmp_path):
    nbclient, nbformat = map(importlib.import_module, ("nbclient", "nbformat"))  # 2 s
    copy_notebooks(tmp_path)
    notebook = nbformat.read(tmp_path / file.name, as_version=4)
    notebook.cells.append(nbformat.v4.new_code_cell(LEFT_BEHIND))
    place = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(notebook, timeout=100, resources=place).execute()
    assert notebook.cells.pop()["outputs"][0]["text"] == "[]\n"
    outputs = [output for cell in code_cells(notebook) for output in cell["outputs"]]
    assert not [output["text"] for output in outputs if output.get("name") == "stderr"]
    kinds = [set(output["data"]) for output in outputs if "data" in output]
    pictures = [kind for kind in kinds if kind & {"image/png", "text/html"}]
    assert len(pictures) >= 3


@pytest.mark.long
def test_the_command_copies_them_and_never_overwrites(tmp_path):
    copied = command("notebooks", "coursework", cwd=tmp_path)
    assert copied.exit_code == 0, copied.stderr
    for file in SHIPPED:
        assert file.name in copied.stdout
        assert (tmp_path / "coursework" / file.name).read_bytes() == file.read_bytes()
    mine = tmp_path / "coursework" / SHIPPED[0].name
    mine.write_text("my work")
    for file in SHIPPED[1:]:
        (tmp_path / "coursework" / file.name).unlink()
    again = command("notebooks", "coursework", cwd=tmp_path)
    assert again.exit_code == 2
    assert f"coursework has {mine.name} already: nothing was written" in again.stderr
    assert [file.name for file in mine.parent.iterdir()] == [mine.name]
    assert mine.read_text() == "my work"


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(NotADirectoryError, match="taken is a file, not a folder"):
        copy_notebooks(tmp_path / "taken")
    with pytest.raises(TypeError, match="folder must be a path, got 3"):
        copy_notebooks(3)
