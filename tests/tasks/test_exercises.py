"""Exercises of the notebooks: right answers, mistakes, and sentences for these."""

from pathlib import Path

import numpy as np
import pytest

import robsim
from robsim.teach.exercises import shipped
from robsim.teach.exercises.exercise import called, drawn_cases
from robsim.teach.grading.arrays import as_arrays
from write_solutions import sources_in

SOURCES = Path(__file__).parents[2] / "notebooks/solutions"
EXERCISES = [one for group in robsim.teach.notebook_exercises().values() for one in group]
each = pytest.mark.parametrize("exercise", EXERCISES, ids=lambda one: one.name)


@pytest.mark.skipif(not SOURCES.is_dir(), reason="needs the sources")
def test_the_packed_answers_are_the_written_ones():
    assert shipped.sources() == sources_in(SOURCES), "run ./run stubs"


@each
def test_the_right_answer_is_right_with_any_numbers(exercise):
    for seed in range(3):
        assert robsim.teach.check_answer(exercise.right, seed=seed)


@each
def test_a_grader_can_call_it(exercise):
    for case in drawn_cases(exercise, 1):
        result = called(exercise.right, case)
        assert len(as_arrays("argument", case)) == len(case)
        assert as_arrays("result", result if isinstance(result, tuple) else (result,))


@each
def test_each_mistake_has_its_sentence(exercise):
    for sentence, wrong in exercise.mistakes.items():
        report = robsim.teach.check_answer(wrong, exercise.name)
        assert report.sentences == [sentence]


def test_the_names_differ():
    names = [one.name for one in EXERCISES]
    assert len(names) == len(set(names))


def to_the_right(pose, goal):
    """Begin, like a student, without the wrap."""
    return np.arctan2(goal[1] - pose[1], goal[0] - pose[0]) - pose[2]


def test_a_notebook_goes_on_with_a_right_answer(capsys):
    def unwritten(pose, goal): ...

    unwritten.__name__ = "to_the_right"
    for answer in (unwritten, to_the_right, to_the_right):
        used = robsim.teach.checked(answer)
        assert abs(used(np.array([0, 0, 3]), np.array([-1, -1]))) < 1.1
    told = capsys.readouterr().out
    assert told.count("Hint: ") == 1
    assert told.startswith("to_the_right is not written yet")


def test_an_answer_of_robsim_is_not_taken_for_the_students(capsys):
    right = robsim.teach.notebook_exercises()["02_park"][0].right
    assert robsim.teach.checked(right) is right
    assert capsys.readouterr().out == (
        "This to_the_right is robsim's: first run the cell with yours again.\n"
    )


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("chosen", lambda found: found.astype(float), "an index is an integer"),
        ("predict_state", list, "returns a list: make it an array"),
        ("poles", lambda found: found + 0j, "returns complex numbers"),
    ],
)
def test_a_right_value_in_a_form_that_breaks_later_is_refused(name, change, said):
    groups = robsim.teach.notebook_exercises().values()
    (found,) = [one for group in groups for one in group if one.name == name]
    (sentence,) = robsim.teach.check_answer(lambda *given: change(found(*given)), name).sentences
    assert said in sentence


def test_a_loop_without_end_is_ended_and_prints_come_once(monkeypatch, capsys):
    def to_the_right_with_prints(pose, goal):
        print("here")
        return to_the_right(pose, goal)

    robsim.teach.check_answer(to_the_right_with_prints, "to_the_right")
    assert capsys.readouterr().out == "here\n"

    def endless(pose, goal):
        while True:
            pass

    monkeypatch.setattr("robsim.teach.exercises.checking._LIMIT", 0.2)
    (sentence,) = robsim.teach.check_answer(endless, "to_the_right").sentences
    assert "does not end within 0.2 s" in sentence


@pytest.mark.parametrize(
    ("returned", "said"),
    [
        ([1, 2], "returns an array of shape (2,), and must return a number."),
        ("left", "returns a str, and must return a number."),
        (([1], [2]), "returns 2 results, an array of shape (1,), an array of shape (1,), and must"),
        (np.nan, " is nan, and must be "),
        ([[1], [2, 3]], "returns lists of different lengths, and must return a number."),
    ],
)
def test_what_comes_back_is_said(returned, said):
    (sentence,) = robsim.teach.check_answer(lambda *_: returned, "to_the_right").sentences
    assert said in sentence


def test_the_first_number_that_differs_is_told():
    def jacobian_of(state, u, theta):
        jacobian = right(state, u, theta)
        jacobian[2, 5] += 1
        return jacobian

    name = "13_extended_kalman_filter"
    (right,) = [e.right for e in robsim.teach.notebook_exercises()[name] if e.name == "jacobian_of"]
    (sentence,) = robsim.teach.check_answer(jacobian_of).sentences
    assert sentence.startswith("[2, 5] of jacobian_of([")


def test_a_function_that_changes_its_arguments_is_not_right():
    def to_the_right(pose, goal):
        goal -= pose[:2]
        return robsim.wrap_angle(np.arctan2(goal[1], goal[0]) - pose[2])

    (sentence,) = robsim.teach.check_answer(to_the_right).sentences
    assert sentence.startswith("It changes its argument goal, ")


def test_an_exercise_may_be_a_function_of_numpy():
    hypot = robsim.teach.Exercise(
        right=np.hypot, cases=lambda rng: (*rng.random((2, 3)),), hint="Pythagoras"
    )
    assert robsim.teach.check_answer(lambda x, y: (x * x + y * y) ** 0.5, hypot)

    def changing(*sides):
        sides[1][:] = 0
        return sides[0]

    (sentence,) = robsim.teach.check_answer(changing, hypot).sentences
    assert sentence.startswith("It changes its argument 2, ")


def test_an_error_has_its_line():
    def typo(pose, goal):
        return poes[0]  # noqa: F821

    (sentence,) = robsim.teach.check_answer(typo, "to_the_right").sentences
    assert "NameError: name 'poes' is not defined (test_exercises.py:" in sentence


def test_arguments_are_copies():
    def spoils(pose, goal):
        pose[:] = 0
        return 0

    given = np.ones(3), np.ones(2)
    called(spoils, given)
    assert given[0].all()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((lambda pose: 0,), "unknown exercise '<lambda>'"),
        ((to_the_right, "to_the_rihgt"), "did you mean 'to_the_right'?"),
        ((5,), "answer must be a function or a Submission, got 5"),
    ],
)
def test_wrong_arguments(arguments, said):
    with pytest.raises((TypeError, ValueError), match=said.replace("?", r"\?")):
        robsim.teach.check_answer(*arguments)


def test_a_submission_is_checked_by_the_same_cases(tmp_path):
    file = tmp_path / "voltages.py"
    file.write_text("def voltages(drive, turn):\n    return drive - turn, drive + turn\n")
    submission = robsim.teach.Submission(file, functions="voltages")
    (sentence,) = robsim.teach.check_answer(submission, "voltages").sentences
    assert sentence.startswith("The robot turns left")


def test_a_mean_pose_may_have_the_circular_mean_of_headings():
    def mean_pose(particles, weights):
        x, y, _ = weights @ particles
        heading = particles[:, 2]
        return x, y, np.arctan2(weights @ np.sin(heading), weights @ np.cos(heading))

    for seed in range(3):
        assert robsim.teach.check_answer(mean_pose, seed=seed)
