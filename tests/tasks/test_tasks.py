"""What all kinds of tasks have in common: parameters, solutions, sheets."""

import numpy as np
import pytest

import robsim
from robsim.tasks import TASKS, Follow, Limit, Measure, Park, Score, task
from robsim.tasks._solutions import SHIPPED, module_source, solutions_in

KINDS = pytest.mark.parametrize("name", TASKS)


def campaign_of(one, solutions, runs):
    return robsim.campaign(
        one.scenario,
        vary={"folder": {solution.name: solution.choice(one) for solution in solutions}},
        metrics={"task": one.score},
        runs=runs,
        steps=one.steps,
        seed=3,
        progress=False,
    )


def statistics(one, result, solution):
    def numbers(score, name):
        return result[f"task_{score.name}"][result["folder"] == name]

    return np.array(
        [
            score.statistic(numbers(score, solution.name), numbers(score, "reference"))
            for score in one.scores
        ]
    )


def test_a_task_by_name_is_that_of_its_class():
    assert task("measure", noise=20, steps=10) == Measure(noise=20, steps=10)
    assert Park(**Park(goal=[300, 200, 1]).parameters) == Park(goal=(300, 200, 1))
    assert Park().simulation(seed=4, control=robsim.Spin()).run(3).info.scenario.seed == 4


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: task("mesure"), "there is no task 'mesure': did you mean 'measure'?"),
        (lambda: task("measure", nois=3), "Measure has no option 'nois': did you mean 'noise'?"),
        (lambda: Measure(noise=-1), "noise must lie within 0..100"),
        (lambda: Measure(dropout=2), "dropout must lie within 0..1"),
        (lambda: Measure(steps=0), "steps must lie within 1.."),
        (lambda: Park(goal=(1, 2)), r"goal must be an array \(3,\)"),
        (lambda: Park(goal=(20, 300, 0)), "goal must be at least 80 px from the walls"),
        (lambda: Follow(waypoints=[(200, 900)]), "waypoints must be at least 80 px from the walls"),
        (lambda: Park(mismatch=1), "mismatch must lie within 0..0.3"),
        (lambda: Limit(full=1, zero=2, low=0.5), "low and low_zero must be given together"),
        (lambda: Score(name="a", title="a", floor=2, worst=1), "worst must be finite and above 2"),
    ],
)
def test_what_is_wrong_is_named(call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call()


@KINDS
def test_the_reference_has_all_the_scores(name):
    one = task(name, steps=20)
    assert sum(score.share for score in one.scores) == pytest.approx(1)
    reference = one.solutions[0]
    assert (reference.name, reference.is_right) == ("reference", True)
    row = campaign_of(one, [reference], 1)
    assert row["error"].tolist() == [None]
    columns = {column for column in row.columns if column.startswith("task_")}
    assert columns == {f"task_{score.name}" for score in one.scores}


@KINDS
def test_there_are_enough_solutions_and_a_file_to_start_from(name):
    one = task(name)
    assert sum(solution.is_right for solution in one.solutions) >= 2
    wrong = [solution.name for solution in one.solutions if not solution.is_right]
    assert wrong[0] == "naive"
    assert len(wrong) >= 5
    for slot in one.slots:
        source = (SHIPPED / name / "start" / f"{slot}.py").read_text()
        assert f"def {slot}(" in source
        assert source.partition("\n")[0].startswith('"""')


@pytest.mark.slow
@KINDS
def test_wrong_solutions_are_worse_than_right_ones(name):
    one = task(name)
    result = campaign_of(one, one.solutions, 10)
    right = [statistics(one, result, one_of) for one_of in one.solutions if one_of.is_right]
    bound = 1.25 * np.max(right, axis=0)
    for solution in one.solutions:
        if not solution.is_right:
            assert (statistics(one, result, solution) > bound).any(), solution


@KINDS
def test_the_sheet_has_the_values_and_the_scores(name):
    one = task(name)
    text = one.sheet
    for key, value in one.values.items():
        assert f"| `{key}` | `{value!r}` |" in text
    for score in one.scores:
        assert f"| {score.title} | {score.unit} | {100 * score.share:.0f} % |" in text
    assert "`robsim.reference`" in text
    assert f"robsim tasks try {name} mine" in text
    assert "{" not in text


@KINDS
def test_solutions_are_told_the_values(name):
    told = {}
    exec(module_source(task(name)), told)
    assert dict(task(name).values).items() <= told.items()


def test_a_folder_without_a_reference_is_refused(tmp_path):
    place = tmp_path / "right" / "other"
    place.mkdir(parents=True)
    with pytest.raises(ValueError, match=r"it must have control\.py"):
        solutions_in(tmp_path, ("control",))
    (place / "control.py").write_text("def control(step):\n    return 0, 0\n")
    with pytest.raises(ValueError, match="must have a solution right/reference"):
        solutions_in(tmp_path, ("control",))
    place.rename(tmp_path / "right" / "reference")
    (found,) = solutions_in(tmp_path, ("control",))
    assert (found.name, found.is_right, list(found.files)) == ("reference", True, ["control"])


def test_the_files_of_a_solution_are_as_they_were_read(tmp_path):
    place = tmp_path / "mine"
    place.mkdir()
    (place / "control.py").write_text(
        "from task import GOAL\n\ndef control(step):\n    return 0, 0\n"
    )
    solution = robsim.tasks.Solution.read(place, "control", is_right=True)
    (place / "control.py").write_text("nonsense")
    assert campaign_of(Park(steps=3), [solution], 1)["error"].tolist() == [None]


def test_a_statistic_is_a_geometric_mean_within_floor_and_worst():
    score = Score(name="e", title="error", floor=1, worst=100)
    assert score.statistic([2, 8], [1, 1]) == pytest.approx(4)
    assert score.statistic([0, np.nan], [1, 100]) == pytest.approx(1)
    assert score.statistic([np.nan], [1]) == pytest.approx(100)
    both = Score(name="n", title="nees", kind="consistency", floor=1e-3, worst=1e3)
    assert both.statistic([0.5, 2], [7, 7]) == pytest.approx(1)
    with pytest.raises(ValueError, match="of the same runs, got 2 and 1"):
        score.statistic([1, 2], [1])


def test_points_are_linear_in_the_logarithm_between_the_limits():
    limit = Limit(full=1.2, zero=4.8, low=0.5, low_zero=0.125)
    assert [limit.fraction(s) for s in (0.6, 1.2, 2.4, 4.8, 9)] == pytest.approx([1, 1, 0.5, 0, 0])
    assert [limit.fraction(s) for s in (0.5, 0.25, 0.125, 0.1)] == pytest.approx([1, 0.5, 0, 0])
    assert Limit(full=1.2, zero=1.1).fraction(1.3) == 0


@KINDS
def test_a_run_has_a_figure(name):
    one = task(name, steps=20)
    with one.solutions[0].choice(one).callbacks() as callbacks:
        trace = one.simulation(seed=1, **callbacks).run(one.steps)
    figure = one.figure(trace, trace)
    assert len(figure.axes) >= 2
    assert "reference" in [text.get_text() for text in figure.legends[0].get_texts()]
    with pytest.raises(TypeError, match="reference must be a Trace"):
        one.figure(trace, 3)
    with pytest.raises(ValueError, match="has no steps"):
        one.figure(trace[:0])
