"""An assignment made of a notebook: its exercises are its tests."""

import pytest

import robsim
from robsim.teach import check_assignment, copy_notebooks, grade_submission, load_assignment
from robsim.teach.assignments import new_assignment

NAMES = [one.name for one in robsim.teach.notebook_exercises()["02_park"]]
CHECK = "voltages = robsim.teach.checked(voltages)"


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
    assert got["the notebook as students get it"] == "0 of 9"


@pytest.mark.long
@pytest.mark.parametrize("tag", ["robsim-skip", "of-another-program"])
def test_a_mistake_costs_its_exercise(hw2, solved, tag):
    text = solved.read_text(encoding="utf-8").replace("robsim-skip", tag)
    solved.write_text(text.replace("return drive + turn, drive", "return drive - turn, drive"))
    assert failed(hw2, solved) == ["test_voltages_public", "test_voltages_hidden"]


@pytest.mark.long
@pytest.mark.parametrize(
    "trick",
    [
        "from robsim.teach import checked as better\\nvoltages = better(voltages)",
        "import robsim.teach.exercises as all_of_them\\n"
        "voltages = all_of_them.notebook_exercises()['02_park'][1].right",
    ],
)
def test_nobody_gets_points_for_the_answers_of_robsim(hw2, tmp_path, trick):
    copy_notebooks(tmp_path / "begun")
    file = tmp_path / "begun/02_park.ipynb"
    text = file.read_text(encoding="utf-8").replace("robsim-skip", "robsim")
    assert CHECK in text
    file.write_text(text.replace(CHECK, trick))
    assert len(failed(hw2, file)) == 2 * len(NAMES)


def test_its_sheet_names_each_exercise(hw2):
    sheet = (hw2.folder / "sheet.md").read_text(encoding="utf-8")
    assert all(f"| `{name}` | 1 | 2 |" in sheet for name in NAMES)
    assert load_assignment(hw2.folder).functions == tuple(NAMES)
