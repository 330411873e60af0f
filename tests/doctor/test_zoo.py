"""The doctor before right estimators in many styles, and before each usual mistake."""

import pytest

import parameter_estimators as parameters
import state_estimators as states
from robsim.doctor import check_estimator, check_parameter_estimator
from size_and_power.families import doctor

pytestmark = [pytest.mark.kernels, pytest.mark.long]
whole_zoo = pytest.mark.slow  # some 20 s; the tests without it look at one of each sort


def by_name(cases):
    return [pytest.param(*one, id=name) for name, one in cases.items()]


def some(cases, number):
    """The cases, of which all but the first are tried in the whole zoo only."""
    return [
        pytest.param(
            *((one,) if isinstance(one, str) else one), marks=whole_zoo if n >= number else ()
        )
        for n, one in enumerate(cases)
    ]


def is_told(report, kind):
    if kind.startswith("remark:"):
        return kind.removeprefix("remark:") in " ".join(report.remarks)
    return kind in [problem.kind for problem in report.problems]


@whole_zoo
@pytest.mark.parametrize("name", states.RIGHT)
def test_a_right_state_estimator_is_not_ill(name):
    check_estimator(states.RIGHT[name]).raise_for_problems()


@whole_zoo
@pytest.mark.parametrize(("make", "kinds"), by_name(states.BROKEN))
def test_a_mistake_in_a_state_estimator_is_told_by_name(make, kinds):
    report = check_estimator(make)
    assert any(is_told(report, kind) for kind in kinds), str(report)
    assert len(report.problems) <= 1, str(report)


@pytest.mark.parametrize("name", some(["alpha-beta", "unicycle", "low-pass", "line fit"], 2))
def test_a_filter_of_fixed_gain_or_unusual_style_is_not_ill(name):
    check_estimator(states.RIGHT[name]).raise_for_problems()


@pytest.mark.parametrize(
    ("make", "kinds"),
    [one if n == 0 else pytest.param(*one, marks=whole_zoo)
     for n, one in enumerate(states.SEVERAL.items())],
)  # fmt: skip
def test_independent_faults_are_all_told(make, kinds):
    assert [problem.kind for problem in check_estimator(make).problems] == kinds


@whole_zoo
@pytest.mark.parametrize("name", states.UNTOLD)
def test_what_cannot_be_told_passes(name):
    check_estimator(states.UNTOLD[name]).raise_for_problems()


# The line that each of these problems is about.
LINES = {
    "inputs swapped": "return step.last_u[::-1]",
    "F P F": "return F @ P @ F",
    "gate that never opens": "z = step.measurement.pose",
    "measurement of the step before": "step.measurement.pose",
    "P not reduced": "self.P = self.reduced(K, self.P)",
    "heading ignored": "step.measurement.pose",
    "one step ahead": "def __call__(self, step):",
}


@pytest.mark.parametrize(("name", "text"), some(LINES.items(), 3))
def test_a_problem_shows_its_line(name, text):
    report = check_estimator(states.BROKEN[name][0])
    assert text in report.problems[0].code
    assert f"> {report.problems[0].code}" in str(report)


@whole_zoo
@pytest.mark.parametrize("name", parameters.RIGHT)
def test_a_right_parameter_estimator_is_not_ill(name):
    check_parameter_estimator(parameters.RIGHT[name]).raise_for_problems()


@whole_zoo
@pytest.mark.parametrize(("make", "kinds"), by_name(parameters.BROKEN))
def test_a_mistake_in_a_parameter_estimator_is_told_by_name(make, kinds):
    report = check_parameter_estimator(make)
    assert report.problems, str(report)
    assert report.problems[0].kind in kinds, str(report)
    assert len(report.problems) == 1, str(report)


FAULTS = {
    "one sample": "it remembers 1 sample, but 5 parameters need more",
    "P never updated": "these cannot be told apart",
    "2 x(k-1) - x(k-2)": "neither phi nor y changes them",
    "y of the step before": "it uses phi of a step with y of the step before",
    "phi of the step before, robsim": "it uses y of a step with phi of the step before",
    "one P": "a displaced x changes the parameters of y",
    "one filter of robsim": "needs n_filters=3",
    "whole numbers": "make it of floats",
    "one row three times": "one list three times",
    "no inputs": "b1 and b2 never change",
    "windup .9 in slots": "P grows",
    "windup .9 in lists": "P grows",
    "small P": "its gain is too small",
}


@pytest.mark.parametrize(("name", "words"), some(FAULTS.items(), 10))
def test_a_parameter_estimator_is_told_why(name, words):
    make, kinds = parameters.BROKEN[name]
    report = check_parameter_estimator(make, updates=1000)
    assert [problem.kind for problem in report.problems] == kinds
    assert words in report.sentences[0]
    assert report.problems[0].line is None or report.problems[0].code


def test_the_line_that_sets_one_of_several_matrices_is_shown():
    report = check_parameter_estimator(parameters.WindupInSlots, updates=1000)
    assert report.problems[0].code == "self.filters[i] = (P + P.T) / 2"


def test_a_gradient_method_is_slow_and_not_ill():
    report = check_parameter_estimator(parameters.Nlms, updates=1000)
    assert report
    assert "as a gradient method (LMS, NLMS) does" in report.remarks[0]


@whole_zoo
def test_the_verdicts_do_not_hang_on_the_seed():
    """Other noise, other voltages: no false alarm, and the same faults.

    With all of them, and more seeds: ``./run statistics --only doctor``.
    """
    rows = [row for kind in doctor.ESTIMATORS for row in doctor.trials(kind, every=3).counted(1)]
    assert not [row for row in rows if not row.holds]
