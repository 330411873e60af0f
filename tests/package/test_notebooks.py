"""The notebooks that ship: clean, and executed as they are."""

import importlib
import json
import re
from pathlib import Path

import pytest

import robsim
from commands import command
from sizes import thorough

PACKAGE = Path(robsim.__file__).parent
NOTEBOOKS = PACKAGE / "notebooks"
SHIPPED = sorted(NOTEBOOKS.glob("*.ipynb"))
MANUAL = "09_the_manual_of_2008"
FIGURES = list(range(1, 36))  # of chapter 2 of the manual
LEFT_BEHIND = """
import threading
if "panel" in globals():  # which a student leaves open
    panel.close()
for thread in threading.enumerate():
    if thread.name.startswith("robsim"):
        thread.join(300)
print([thread.name for thread in threading.enumerate() if thread.name.startswith("robsim")])
"""
# As many runs as show that it works.
SHORTER = {
    '"runs = 3"': '"runs = 2"',
    '"steps = 40"': '"steps = 20"',
}
#: With panels, processes, cameras, all figures of the manual; ./run docs executes all.
BUSY = ("00_panel", "06_grade_a_class", "08_live", MANUAL)
each = pytest.mark.parametrize(
    "file",
    thorough(SHIPPED, [NOTEBOOKS / f"{name}.ipynb" for name in BUSY]),
    ids=lambda file: file.stem,
)


def code_cells(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def test_a_notebook_is_short_and_stripped():
    assert MANUAL in [file.stem for file in SHIPPED]
    for file in SHIPPED:
        notebook = json.loads(file.read_text(encoding="utf-8"))
        assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
        assert notebook["metadata"]["kernelspec"]["name"] == "python3"
        most = 26 if file.stem == MANUAL else 18
        assert file.stem == "index" or 4 <= len(code_cells(notebook)) <= most
        for cell in code_cells(notebook):
            assert (cell["outputs"], cell["execution_count"]) == ([], None)
            is_check = "robsim.teach.checked(" in "".join(cell["source"])
            assert cell["metadata"] == ({"tags": ["robsim-skip"]} if is_check else {})


def executed(folder, name, *options):
    """Copy the notebooks into a folder; return one of them after all its cells."""
    nbclient, nbformat = map(importlib.import_module, ("nbclient", "nbformat"))  # 2 s
    assert command("notebooks", str(folder), *options).exit_code == 0
    notebook = nbformat.read(folder / name, as_version=4)
    for cell in notebook.cells:
        for long, short in thorough({}, SHORTER).items():
            cell.source = cell.source.replace(long, short)
    notebook.cells.append(nbformat.v4.new_code_cell(LEFT_BEHIND))
    place = {"metadata": {"path": str(folder)}}
    client = nbclient.NotebookClient(notebook, timeout=600, resources=place)
    # An answer to a widget, sent while a reply is awaited, may leave both sides waiting.
    client.handle_comm_msg = lambda *_: None
    client.execute()
    left = "".join(output["text"] for output in notebook.cells.pop()["outputs"])
    assert left == "[]\n"
    outputs = [output for cell in code_cells(notebook) for output in cell["outputs"]]
    assert not [output["text"] for output in outputs if output.get("name") == "stderr"]
    return notebook, outputs


@pytest.mark.slow
@each
def test_a_notebook_runs_as_a_student_gets_it(file, tmp_path):
    notebook, outputs = executed(tmp_path, file.name)
    kinds = [set(output["data"]) for output in outputs if "data" in output]
    slider = "application/vnd.jupyter.widget-view+json"
    pictures = [kind for kind in kinds if kind & {"image/png", "text/html", slider}]
    assert len(pictures) >= 3 or not code_cells(notebook)
    if file.stem == MANUAL:
        check_figures(code_cells(notebook))


@pytest.mark.slow
@pytest.mark.parametrize("name", robsim.teach.notebook_exercises())
def test_a_notebook_runs_with_its_answers(name, tmp_path):
    _, outputs = executed(tmp_path, f"{name}.ipynb", "--solutions")
    told = "".join(output["text"] for output in outputs if output.get("name") == "stdout")
    for exercise in robsim.teach.notebook_exercises()[name]:
        assert f"{exercise.name} is right.\n" in told


def test_the_index_names_each_notebook_and_what_it_takes():
    text = (NOTEBOOKS / "index.ipynb").read_text(encoding="utf-8")
    rows = re.findall(r"\| (\d+) \| \[[^]]+\]\((\w+)\.ipynb\) \| \d+ \| [^|]+ \| [^|]+ \|", text)
    assert sorted(name for _, name in rows) == [one.stem for one in SHIPPED if one.stem != "index"]
    assert [int(number) for number, _ in rows] == [int(name[:2]) for _, name in rows]
    assert set(robsim.teach.notebook_exercises()) == {name for _, name in rows}


def test_each_exercise_is_a_cell_and_its_check():
    for name, exercises in robsim.teach.notebook_exercises().items():
        text = (NOTEBOOKS / f"{name}.ipynb").read_text(encoding="utf-8")
        sources = ["".join(cell["source"]) for cell in code_cells(json.loads(text))]
        checked = [re.fullmatch(r"(\w+) = robsim.teach.checked\(\1\)", one) for one in sources]
        checks = {found[1]: n for n, found in enumerate(checked) if found}
        assert list(checks) == [exercise.name for exercise in exercises]
        for exercise, at in checks.items():
            assert f"def {exercise}(" in sources[at - 1]
            assert sources[at - 1].endswith("    ...")


def check_figures(cells):
    """Each figure of the manual is there once, with what it shows, and no two are the same."""
    numbers, shown, above = [], [], []
    for output in (output for cell in cells for output in cell["outputs"]):
        data = output.get("data", {})
        caption = re.match(r"\*\*Figure 2-(\d+)\.\*\* \w", data.get("text/markdown", ""))
        if caption is None:
            above += [
                data[kind] for kind in ("image/png", "text/html", "text/markdown") if kind in data
            ]
        else:
            assert above, caption[0]
            numbers.append(int(caption[1]))
            shown += above
            above = []
    assert numbers == FIGURES
    assert len(set(shown)) == len(shown)


def manual():
    notebook = json.loads((NOTEBOOKS / f"{MANUAL}.ipynb").read_text(encoding="utf-8"))
    return ["".join(cell["source"]) for cell in notebook["cells"]]


def test_the_notebook_on_the_manual_has_all_its_figures():
    code = "\n".join(manual())
    assert [int(number) for number in re.findall(r"^figure\(\s*(\d+),", code, re.M)] == FIGURES


def test_the_table_of_2008_names_what_the_page_says():
    words = json.loads(next((PACKAGE / "gui").rglob("texts.json")).read_text("utf-8"))
    (text,) = (text for text in manual() if "| 2008 | now | names |" in text)
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    assert len(rows) > 30
    for _, now, *names in rows[2:]:
        bold = re.findall(r"\*\*(.*?)\*\*", now)
        assert [words[name] for name in re.findall(r"`(.*?)`", "".join(names))] == bold


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
    assert f"coursework already has {mine.name}, axes.svg: robsim wrote nothing" in again.stderr
    assert sorted(file.name for file in mine.parent.iterdir()) == [mine.name, "axes.svg"]
    assert mine.read_text() == "my work"
