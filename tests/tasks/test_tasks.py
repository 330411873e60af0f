"""What all kinds of tasks have in common: parameters, solutions, sheets."""

import numpy as np
import pytest

import robsim
from robsim.teach import (
    TASKS,
    EstimateTask,
    FollowTask,
    IdentifyTask,
    MeasureTask,
    ParkTask,
    Score,
    ScoreLimit,
    solution_folder,
    task,
)
from robsim.teach.tasks.solutions import solutions_in


def errors_of(one, solution):
    """What goes wrong in a run of a solution; None = nothing."""
    result = robsim.campaign(
        one.scenario,
        vary={"folder": {solution.name: solution_folder(one, solution)}},
        metrics={"task": one.score},
        runs=1,
        steps=one.steps,
        seed=3,
        progress=False,
    )
    assert {f"task_{score.name}" for score in one.scores} <= set(result.columns)
    return result["error"].tolist()


def test_a_task_by_name_is_that_of_its_class():
    assert task("measure", noise=20, steps=10) == MeasureTask(noise=20, steps=10)
    assert ParkTask(**ParkTask(goal=[300, 200, 1]).parameters) == ParkTask(goal=(300, 200, 1))
    assert ParkTask().simulation(seed=4, control=robsim.Spin()).run(3).info.scenario.seed == 4


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: task("mesure"), "'mesure'"),
        (lambda: task("measure", nois=3), "'nois'"),
        (lambda: MeasureTask(noise=-1), "noise"),
        (lambda: MeasureTask(dropout=1.1), "dropout"),
        (lambda: EstimateTask(steps=19), "steps"),
        (lambda: IdentifyTask(mismatch=0), "mismatch"),
        (lambda: ParkTask(goal=(1, 2)), "goal"),
        (lambda: ParkTask(goal=(20, 300, 0)), "goal.*80"),
        (lambda: FollowTask(waypoints=[(200, 900)]), "waypoints.*80"),
        (lambda: ParkTask(mismatch=1), "mismatch"),
        (lambda: ScoreLimit(full=1, zero=2, low=0.5), "low_zero"),
        (lambda: Score(name="a", title="a", floor=2, worst=1), "worst"),
        (lambda: Score(name="a", title="a", floor=1, worst=9, kind="lost"), "share"),
        (lambda: Score(name="a", title="a", floor=1, worst=100, kind="lost", share=0), "worst"),
    ],
)
def test_what_is_wrong_is_named(call, named):
    with pytest.raises((TypeError, ValueError), match=named):
        call()


@pytest.mark.parametrize("name", TASKS)
def test_a_task_has_what_it_says(name, tmp_path):
    one = task(name, steps=20)
    assert sum(score.share for score in one.scores) == pytest.approx(1)
    reference = one.solutions[0]
    assert (reference.name, reference.is_right) == ("reference", True)
    assert errors_of(one, reference) == [None]
    # Enough solutions, and a file to start from.
    assert sum(solution.is_right for solution in one.solutions) >= 2
    wrong = [solution.name for solution in one.solutions if not solution.is_right]
    assert wrong[0] == "naive"
    assert len(wrong) >= 5
    one.begin(tmp_path / "mine")
    for slot in one.slots:
        assert f"def {slot}(" in (tmp_path / f"mine/{slot}.py").read_text()
    # The sheet and the solutions are told the values.
    told = {}
    exec((tmp_path / "mine/task.py").read_text(), told)
    assert dict(one.values).items() <= told.items()
    for key, value in one.values.items():
        assert f"| `{key}` | `{value!r}` |" in one.sheet
    for score in one.scores:
        share = f"{100 * score.share:.0f} %" if score.share else "multiplies the others"
        assert f"| {score.title} | {score.unit} | {share} |" in one.sheet
    assert "{" not in one.sheet


def test_a_folder_without_a_reference_is_refused(tmp_path):
    place = tmp_path / "right" / "other"
    place.mkdir(parents=True)
    with pytest.raises(ValueError, match=r"control\.py"):
        solutions_in(tmp_path, ("control",))
    (place / "control.py").write_text("def control(step):\n    return 0, 0\n")
    with pytest.raises(ValueError, match="right/reference"):
        solutions_in(tmp_path, ("control",))
    place.rename(tmp_path / "right" / "reference")
    (found,) = solutions_in(tmp_path, ("control",))
    assert (found.name, found.is_right, list(found.files)) == ("reference", True, ["control"])


def test_the_files_of_a_solution_are_as_they_were_read(tmp_path):
    file = tmp_path / "control.py"
    file.write_text("from task import GOAL\n\ndef control(step):\n    return 0, 0\n")
    solution = robsim.teach.Solution.load(tmp_path, "control", is_right=True)
    file.write_text("nonsense")
    assert errors_of(ParkTask(steps=3), solution) == [None]


def test_a_statistic_is_a_geometric_mean_within_floor_and_worst():
    score = Score(name="e", title="error", floor=1, worst=100)
    assert score.statistic([2, 8], [1, 1]) == pytest.approx(4)
    assert score.statistic([0, np.nan], [1, 100]) == pytest.approx(1)
    assert score.statistic([np.nan], [1]) == pytest.approx(100)
    both = Score(name="n", title="nees", kind="consistency", floor=1e-3, worst=1e3)
    assert both.statistic([0.5, 2], [7, 7]) == pytest.approx(1)
    with pytest.raises(ValueError, match="2 and 1"):
        score.statistic([1, 2], [1])


def test_points_are_linear_in_the_logarithm_between_the_limits():
    limit = ScoreLimit(full=1.2, zero=4.8, low=0.5, low_zero=0.125)
    assert [limit.fraction(s) for s in (0.6, 1.2, 2.4, 4.8, 9)] == pytest.approx([1, 1, 0.5, 0, 0])
    assert [limit.fraction(s) for s in (0.5, 0.25, 0.125, 0.1)] == pytest.approx([1, 0.5, 0, 0])
    assert ScoreLimit(full=1.2, zero=1.1).fraction(1.3) == 0


@pytest.mark.long
@pytest.mark.parametrize("name", TASKS)
def test_a_run_has_a_figure(name):
    one = task(name, steps=20)
    with solution_folder(one, one.solutions[0]).callbacks() as callbacks:
        trace = one.simulation(seed=1, **callbacks).run(one.steps)
    figure = one.figure(trace, trace)
    assert len(figure.axes) >= 2
    assert "reference" in [text.get_text() for text in figure.legends[0].get_texts()]
    with pytest.raises(ValueError, match="no steps"):
        one.figure(trace[:0])
