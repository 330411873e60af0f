"""An assignment made of a notebook: its exercises are its tests."""

import pytest

import robsim
from robsim.teach import check_assignment, copy_notebooks, grade_submission, load_assignment
from robsim.teach.assignments import new_assignment

NAMES = [one.name for one in robsim.teach.notebook_exercises()["02_park"]]


@pytest.fixture(scope="module")
def hw2(tmp_path_factory):
    return new_assignment("02_park", tmp_path_factory.mktemp("made") / "hw2", seed=1)


@pytest.fixture
def solved(tmp_path):
    copy_notebooks(tmp_path / "solved", solutions=True)
    return tmp_path / "solved/02_park.ipynb"


def failed(assignment, submission):
    return [test.name for test in grade_submission(assignment, submission).tests if not test.points]


@pytest.mark.long
def test_it_is_fit_to_grade_by(hw2):
    report = check_assignment(hw2.folder, progress=False)
    assert report, report
    got = {title: row["got"] for title, row in report.tables[0].records()}
    assert got["right: the notebook with its answers"] == "9 of 9"
    nothing = (
        "the notebook as students get it",
        "empty submission",
        "hostile: exit",
        "hostile: hang",
    )
    assert {got[title] for title in nothing} == {"0 of 9"}


@pytest.mark.long
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("robsim-skip", "of-another-program"),
        ('robsim-skip"', '"'),
        ("= robsim.teach.checked(voltages)", "= checked(voltages)"),
    ],
)
def test_a_mistake_costs_its_exercise(hw2, solved, old, new):
    text = solved.read_text(encoding="utf-8")
    assert old in text
    text = text.replace("robsim-skip", "") if "checked" in old else text
    text = text.replace(old, new)
    solved.write_text(text.replace("return drive + turn, drive", "return drive - turn, drive"))
    assert failed(hw2, solved) == ["test_voltages_public", "test_voltages_hidden"]


@pytest.mark.long
@pytest.mark.parametrize(
    "trick",
    [
        "from robsim.teach import checked as better\ndef voltages(drive, turn): ...\n"
        "voltages = better(voltages)",
        "from robsim.teach.exercises.shipped import notebook_exercises as all_of_them\n"
        "voltages = all_of_them()['02_park'][1].right",
    ],
)
def test_nobody_gets_points_for_the_answers_of_robsim(hw2, tmp_path, trick):
    file = tmp_path / "voltages.py"
    file.write_text(trick)
    tests = {test.name: test for test in grade_submission(hw2, file).tests}
    assert not any(test.points for test in tests.values())
    assert "is unavailable in this assignment" in tests["test_voltages_public"].sentence


def test_hidden_numbers_are_secret_with_any_seed(hw2, tmp_path):
    other = new_assignment("02_park", tmp_path / "other", seed=1)
    hidden = [(made.folder / "hidden_tests.py").read_text() for made in (hw2, other)]
    assert hidden[0] != hidden[1]


def test_its_sheet_names_each_exercise(hw2):
    sheet = (hw2.folder / "sheet.md").read_text(encoding="utf-8")
    assert all(f"| `{name}` | 1 | 2 |" in sheet for name in NAMES)
    assert load_assignment(hw2.folder).functions == tuple(NAMES)
