"""Files that lie beside each submission when it is run."""

import pytest

from robsim.grading._submissions import loaded_slots, read_submission
from submissions import CONTROL, notebook, packed, write

GIVEN = {"task.py": b"GOAL = 3\n", "table.csv": b"1,2\n"}
WITH_TASK = "from task import GOAL\ndef control(step):\n    return GOAL, 0\n"


def answer_of(path):
    with loaded_slots(read_submission(path, CONTROL, GIVEN), CONTROL) as callbacks:
        return callbacks["control"](None)


def folder(tmp_path):
    return write(tmp_path / "s001", control=WITH_TASK)


def one_file(tmp_path):
    (tmp_path / "s002.py").write_text(WITH_TASK)
    return tmp_path / "s002.py"


def zipped(tmp_path):
    return packed(tmp_path / "s003.zip", {"s003/control.py": WITH_TASK})


def a_notebook(tmp_path):
    return notebook(tmp_path / "s004.ipynb", *WITH_TASK.split("\n", 1))


@pytest.mark.parametrize("form", [folder, one_file, zipped, a_notebook])
def test_every_form_of_submission_has_them(tmp_path, form):
    path = form(tmp_path)
    assert answer_of(path) == (3, 0)
    assert read_submission(path, CONTROL, GIVEN).sources["table.csv"] == b"1,2\n"


def test_they_count_in_place_of_copies_that_were_handed_in(tmp_path):
    path = write(tmp_path / "s001", control=WITH_TASK, task="GOAL = 9\n")
    assert answer_of(path) == (3, 0)


def test_a_copy_beside_a_single_file_is_no_second_solution(tmp_path):
    path = write(tmp_path / "s001", solution=WITH_TASK, task="GOAL = 9\n")
    assert answer_of(path) == (3, 0)
