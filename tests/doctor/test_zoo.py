"""The doctor before right estimators in many styles, and before each usual mistake."""

import pytest

import parameter_estimators as parameters
import state_estimators as states
from robsim.teach import check_estimator, check_parameter_estimator
from size_and_power.families import doctor
from sizes import thorough

pytestmark = [pytest.mark.kernels, pytest.mark.long]
whole_zoo = pytest.mark.slow  # the tests without it look at one of each sort

PATIENT = 60.0  # s: how quick they are is no question here
UPDATES = thorough(10_000, 3000)


def examined(make):
    return check_estimator(make, budget=PATIENT)


def parameters_examined(make):
    return check_parameter_estimator(make, updates=UPDATES, budget=PATIENT)


def some(cases, number):
    """The cases, of which all but the first are tried in the whole zoo only."""
    return [
        pytest.param(*one, marks=whole_zoo if n >= number else ()) for n, one in enumerate(cases)
    ]


def is_told(report, kind):
    if kind.startswith("remark:"):
        return kind.removeprefix("remark:") in " ".join(report.remarks)
    return kind in [problem.kind for problem in report.problems]


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in ("alpha-beta", "unicycle") else whole_zoo)
        for name in states.RIGHT
    ],
)
def test_a_right_state_estimator_is_not_ill(name):
    examined(states.RIGHT[name]).raise_for_problems()


def by_fault(broken):
    """The estimators by name, for each fault that is told of them."""
    names = {}
    for name, (_, kinds) in broken.items():
        names.setdefault(" or ".join(kinds), []).append(name)
    return names


@whole_zoo
@pytest.mark.parametrize("names", by_fault(states.BROKEN).values(), ids=by_fault(states.BROKEN))
def test_a_mistake_in_a_state_estimator_is_told_by_name(names):
    for name in names:
        make, kinds = states.BROKEN[name]
        report = examined(make)
        assert any(is_told(report, kind) for kind in kinds), (name, str(report))
        assert len(report.problems) <= 1, (name, str(report))


@pytest.mark.parametrize(("make", "kinds"), some(states.SEVERAL, 1))
def test_independent_faults_are_all_told(make, kinds):
    assert [problem.kind for problem in examined(make).problems] == kinds


@whole_zoo
def test_what_cannot_be_told_passes():
    for make in states.UNTOLD:
        examined(make).raise_for_problems()


class Swapped(states.Ekf):
    def input(self, step):
        return step.last_u[::-1]


# The line that each of these problems is about.
LINES = [
    (Swapped, "return step.last_u[::-1]"),
    (states.NoTranspose, "return F @ P @ F"),
    (states.GateOfPixels, "z = step.measurement.pose"),
    (states.BROKEN["measurement of the step before, CV"][0], "step.measurement.pose"),
    (states.BROKEN["P not reduced"][0], "self.P = self.reduced(K, self.P)"),
    (states.BROKEN["heading ignored"][0], "step.measurement.pose"),
    (states.BROKEN["one step ahead"][0], "def __call__(self, step):"),
]


@pytest.mark.parametrize(("make", "text"), some(LINES, 3))
def test_a_problem_shows_its_line(make, text):
    report = examined(make)
    assert text in report.problems[0].code
    assert f"> {report.problems[0].code}" in str(report)


@whole_zoo
@pytest.mark.parametrize("name", parameters.RIGHT)
def test_a_right_parameter_estimator_is_not_ill(name):
    parameters_examined(parameters.RIGHT[name]).raise_for_problems()


# What the sentence says of the cause.
REASONS = {
    "one sample": "remembers 1 sample, but 5 parameters",
    "P never updated": "cannot be distinguished",
    "2 x(k-1) - x(k-2)": "neither phi nor y",
    "y of the step before": "phi of a step with y of the previous step",
    "phi of the step before": "y of a step with phi of the previous step",
    "one P": "a displaced x changes the parameters of y",
    "one filter of robsim": "n_filters=3",
    "one row three times": "one list three times",
    "no inputs": "b1 and b2",
    "windup .9 in slots": "P grows",
    "small P": "gain is too small",
}


@pytest.mark.parametrize(
    ("fault", "names"),
    [
        pytest.param(fault, names, marks=() if fault in ("axes mixed", "refused") else whole_zoo)
        for fault, names in by_fault(parameters.BROKEN).items()
    ],
)
def test_a_mistake_in_a_parameter_estimator_is_told_by_name(fault, names):
    for name in names:
        report = parameters_examined(parameters.BROKEN[name][0])
        assert len(report.problems) == 1, (name, str(report))
        (problem,) = report.problems
        assert problem.kind in fault.split(" or "), (name, str(report))
        assert REASONS.get(name, "") in problem.sentence
        assert problem.line is None or problem.code


def test_the_line_that_sets_one_of_several_matrices_is_shown():
    report = check_parameter_estimator(parameters.WindupInSlots, updates=1000)
    assert report.problems[0].code == "self.filters[i] = (P + P.T) / 2"


def test_a_gradient_method_is_slow_and_not_ill():
    report = check_parameter_estimator(parameters.Nlms, updates=1000)
    assert report
    assert "gradient" in report.remarks[0]


@whole_zoo
def test_the_verdicts_do_not_hang_on_the_seed():
    """Other noise, other voltages: no false alarm, and the same faults.

    With all of them, and more seeds: ``./run study statistics --only doctor``.
    """
    every = thorough(3, 12)
    rows = [row for kind in doctor.ESTIMATORS for row in doctor.trials(kind, every).counted(1)]
    assert not [row for row in rows if not row.holds]
