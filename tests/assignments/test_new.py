"""A new assignment: a folder that is complete, has its own key and numbers, and can be read."""

import os
import stat
import sys
from dataclasses import replace

import pytest

from robsim.teach import Key, load_assignment, new_assignment
from robsim.teach.tasks.solutions import solutions_in

each = pytest.mark.parametrize("template", ["park", "follow", "identify", "measure", "estimate"])


@each
def test_a_new_folder_is_an_assignment_with_the_solutions_that_ship(tmp_path, template):
    made = new_assignment(template, tmp_path / "hw1", seed=1)
    names = {file.name for file in made.folder.iterdir()}
    assert {"assignment.toml", "sheet.md", "start", "own_tests.py", "solutions", "key"} <= names
    read = load_assignment(tmp_path / "hw1")
    assert read == made
    public, hidden = read.tests
    assert (public.public, hidden.public) == (True, False)
    assert public.task == hidden.task
    assert public.points + hidden.points == 9
    assert [file.public for file in read.files] == [True]
    task = public.task
    found = solutions_in(made.folder / "solutions" / task.name, task.slots)
    assert [replace(one, folder=None) for one in found] == list(task.solutions)
    sheet = (made.folder / "sheet.md").read_text()
    for slot in made.slots:
        assert f"`{slot}" in sheet
        assert (made.folder / f"start/{slot}.py").is_file()
    for name, value in task.values.items():
        assert f"| `{name}` | `{value!r}` |" in sheet
    assert "robsim tasks" not in sheet  # whose numbers are others


@each
def test_no_two_have_the_same_numbers_or_the_same_key(tmp_path, template):
    made = [new_assignment(template, tmp_path / f"hw{i}", seed=i) for i in range(4)]
    assert len({one.tests[0].task for one in made}) == 4
    again = new_assignment(template, tmp_path / "again", seed=0)
    assert again.tests[0].task == made[0].tests[0].task
    assert len({one.key for one in [*made, again]}) == 5


@pytest.mark.skipif(sys.platform == "win32", reason="modes of files are those of Unix")
def test_nobody_else_can_read_the_key(tmp_path):
    new_assignment("measure", tmp_path / "hw1")
    assert stat.S_IMODE(os.stat(tmp_path / "hw1/key").st_mode) == 0o600
    assert not Key.read(tmp_path / "hw1/key").is_public


def test_the_name_is_that_of_the_folder_or_what_is_given(tmp_path, monkeypatch):
    assert new_assignment("measure", tmp_path / "a/b/hw1").name == "hw1"
    assert new_assignment("measure", tmp_path / "x", name='Übung "1"').name == 'Übung "1"'
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert new_assignment("measure", "hw1").name == "hw1"


def test_wrong_arguments_are_refused_before_anything_is_written(tmp_path):
    (tmp_path / "taken").mkdir()
    with pytest.raises(FileExistsError, match="taken"):
        new_assignment("measure", tmp_path / "taken")
    for template, wrong in (("mesure", {}), ("measure", {"seed": -1})):
        with pytest.raises(ValueError, match="seed" if wrong else "mesure"):
            new_assignment(template, tmp_path / "hw1", **wrong)
    assert list(tmp_path.rglob("*")) == [tmp_path / "taken"]


def test_a_folder_that_cannot_be_filled_is_removed(tmp_path, monkeypatch):
    folder = "robsim.teach.assignments.making"
    monkeypatch.setattr(f"{folder}.sheet_for", lambda assignment: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        new_assignment("measure", tmp_path / "hw1")
    assert list(tmp_path.iterdir()) == []
