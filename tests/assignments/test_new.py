"""A new assignment: a folder that is complete, has its own key and numbers, and can be read."""

import os
import stat
import sys

import pytest

from robsim.assignments import Assignment, new_assignment
from robsim.assignments._making.template import TEMPLATES
from robsim.grading import Key
from robsim.tasks._solutions import solutions_in

each = pytest.mark.parametrize("template", TEMPLATES)


@each
def test_a_new_folder_has_all_that_its_readme_names(tmp_path, template):
    made = new_assignment(template, tmp_path / "hw1", seed=1)
    names = {file.name for file in made.folder.iterdir()}
    assert {"assignment.toml", "sheet.md", "start", "own_tests.py", "solutions", "key"} <= names
    read = Assignment.load(tmp_path / "hw1")
    assert read == made
    assert read.title == TEMPLATES[template].title
    public, hidden = read.tests
    assert (public.public, hidden.public) == (True, False)
    assert public.task == hidden.task
    assert public.points + hidden.points == 9
    assert [file.public for file in read.files] == [True]


@each
def test_it_has_the_solutions_that_ship(tmp_path, template):
    made = new_assignment(template, tmp_path / "hw1", seed=1)
    task = made.tests[0].task
    copied = solutions_in(made.folder / "solutions" / task.name, task.slots)
    assert [(one.name, one.is_right) for one in copied] == [
        (one.name, one.is_right) for one in task.solutions
    ]
    assert [one.files for one in copied] == [one.files for one in task.solutions]
    assert sum(not one.is_right for one in copied) >= 5
    assert copied[0].name == "reference"


@each
def test_the_sheet_tells_what_is_written_and_what_it_gives(tmp_path, template):
    made = new_assignment(template, tmp_path / "hw1", seed=1)
    sheet = (made.folder / "sheet.md").read_text()
    for slot in made.slots:
        assert f"`{slot}" in sheet
        assert (made.folder / f"start/{slot}.py").is_file()
    assert "robsim grade . mine --public" in sheet
    assert "robsim tasks" not in sheet  # whose numbers are others
    assert "A call may take 1 s, the first one of a run 10 s" in sheet
    assert "| tests in `own_tests.py` | those in its `pytest.mark.points` | public |" in sheet
    for name, value in made.tests[0].task.values.items():
        assert f"| `{name}` | `{value!r}` |" in sheet


@each
def test_no_two_have_the_same_numbers_or_the_same_key(tmp_path, template):
    made = [new_assignment(template, tmp_path / f"hw{i}", seed=i) for i in range(8)]
    assert len({one.tests[0].task for one in made}) == 8
    assert len({one.key for one in made}) == 8
    again = new_assignment(template, tmp_path / "again", seed=0)
    assert again.tests[0].task == made[0].tests[0].task
    assert again.key != made[0].key


@pytest.mark.skipif(sys.platform == "win32", reason="modes of files are those of Unix")
def test_nobody_else_can_read_the_key(tmp_path):
    new_assignment("measurement", tmp_path / "hw1")
    assert stat.S_IMODE(os.stat(tmp_path / "hw1/key").st_mode) == 0o600
    assert not Key.read(tmp_path / "hw1/key").is_public


def test_the_name_is_that_of_the_folder_or_what_is_given(tmp_path, monkeypatch):
    assert new_assignment("measurement", tmp_path / "a/b/hw1").name == "hw1"
    assert new_assignment("measurement", tmp_path / "x", name='Übung "1"').name == 'Übung "1"'
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert new_assignment("measurement", "hw1").name == "hw1"


def test_what_exists_is_left_alone(tmp_path):
    (tmp_path / "hw1").mkdir()
    with pytest.raises(FileExistsError, match="hw1 exists: give another name"):
        new_assignment("measurement", tmp_path / "hw1")
    assert list((tmp_path / "hw1").iterdir()) == []


def test_wrong_arguments_are_refused_before_anything_is_written(tmp_path):
    with pytest.raises(ValueError, match=r"no template 'measurment'.*did you mean 'measurement'"):
        new_assignment("measurment", tmp_path / "hw1")
    with pytest.raises(TypeError, match="template must be text"):
        new_assignment(3, tmp_path / "hw1")
    with pytest.raises(ValueError, match="seed must lie within"):
        new_assignment("measurement", tmp_path / "hw1", seed=-1)
    with pytest.raises(ValueError, match="name must be 1 to 40"):
        new_assignment("measurement", tmp_path / "hw1", name="")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_filled_is_removed(tmp_path, monkeypatch):
    from robsim.assignments._making import folder

    monkeypatch.setattr(folder, "sheet_for", lambda assignment: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        new_assignment("measurement", tmp_path / "hw1")
    assert list(tmp_path.iterdir()) == []
