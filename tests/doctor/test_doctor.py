import runpy
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import robsim
from parameter_estimators import LeastSquares
from robsim.estimation import reference
from robsim.teach import CheckReport, Problem, check_estimator, check_parameter_estimator
from state_estimators import ConstantVelocity, Ekf, HandsOn, changed, complementary

pytestmark = [pytest.mark.kernels, pytest.mark.long]


def only(report):
    """The one problem of a report: the cause, and nothing that follows from it."""
    assert not report
    assert len(report.problems) == 1, str(report)
    return report.problems[0]


@pytest.mark.parametrize("dt", [1 / 30, 0.2, 0.5])
def test_a_right_state_estimator_is_well_at_any_sample_time(dt):
    report = check_estimator(ConstantVelocity, dt=dt)
    assert report, str(report)
    assert report.raise_for_problems() is report


TEMPLATE = Path(robsim.__file__).with_name("simulation") / "templates" / "estimate_state.py"


def test_the_template_of_a_state_estimator_examines_itself_and_is_well(capsys):
    runpy.run_path(str(TEMPLATE), run_name="__main__")
    assert capsys.readouterr().out.startswith("LastPose passed all checks, with 2 remarks\n")


def cv(**pieces):
    return changed(ConstantVelocity, **pieces)


def gives(result):
    """A right filter that returns something else of its state and its P of the pose."""
    return cv(result=lambda self: result(self.x, self.P[:3, :3]))


class StartsWhenSeen(ConstantVelocity):
    started = False

    def __call__(self, step):
        self.started = self.started or step.measurement is not None
        return super().__call__(step) if self.started else None


def writes(self, z):
    z -= self.x[:3]
    return z


class ClassMemory(ConstantVelocity):
    x, P = np.zeros(6), np.eye(6)

    def __init__(self):
        pass

    def reduced(self, K, P):
        ClassMemory.x = self.x
        return super().reduced(K, P)


kept = {}


def keeps_the_last_pose_outside():
    """Nobody notices as long as the robot is seen."""

    def estimate(step):
        if step.k == 0:
            kept["filter"] = HandsOn()
        return kept["filter"](step)

    return estimate


class LooksAhead(ConstantVelocity):
    """Climbs up the stack to what will be measured next."""

    def measured(self, step):
        frame = sys._getframe()
        while "_situation" not in getattr(frame.f_locals.get("self"), "__dict__", {}):
            frame = frame.f_back
        last = frame.f_locals["self"]._situation.measurements[step.k :][:2][-1]
        return None if last is None else last.pose


def prints(self, u, dt):
    print("step of", dt, "s")
    ConstantVelocity.move(self, u, dt)


def fails(self, u, dt):
    ConstantVelocity.move(self, u, dt)
    if self.x[0] > 500:
        raise KeyError("x")


class Grows(ConstantVelocity):
    calls = 0

    def result(self):
        self.calls += 1
        return robsim.Estimate(self.x[:3], self.P[:3, :3], np.zeros(2 + self.calls // 8))


# The kind, the estimator, a word or number of the sentence, and some of the line.
BROKEN = [
    ("no Estimate", gives(lambda x, P: x), "(6,)", "def __call__"),
    (
        "wrong Estimate",
        cv(result=lambda self: robsim.Estimate(self.x, self.P)),
        "pose",
        "robsim.Estimate(self.x, self.P)",
    ),
    (
        "covariance not positive",
        gives(lambda x, P: robsim.Estimate(x[:3], P + 2 * P[0, 0] * (np.ones(3) - np.eye(3)))),
        "definite",
        "self.P = ",
    ),
    (
        "covariance not positive",
        gives(lambda x, P: robsim.Estimate(x[:3], 0 * P)),
        "0 for x",
        "self.P = ",
    ),
    (
        "missing measurement",
        cv(measured=lambda self, step: step.measurement.pose),
        "AttributeError",
        "step.measurement.pose",
    ),
    ("not seen yet", StartsWhenSeen, "None", "def __call__"),
    ("writes into step", cv(innovation=writes), "copy", "z -= self.x[:3]"),
    ("remembers earlier run", ClassMemory, "previous run", "def __call__"),
    ("shared memory", keeps_the_last_pose_outside, "global", "def estimate(step):"),
    (
        "not reproducible",
        gives(lambda x, P: robsim.Estimate(x[:3] + np.random.default_rng().normal(0, 0.01, 3), P)),
        "seed",
        "def __call__",
    ),
    ("depends on future", LooksAhead, "later", "def __call__"),
    ("prints", cv(move=prints), "'step of 0.2 s'", 'print("step of", dt, "s")'),
    ("exception", cv(move=fails), "KeyError: 'x'", 'raise KeyError("x")'),
    ("exception", cv(gain=lambda *_: sys.exit("enough")), "SystemExit: enough", "sys.exit"),
    ("state length", Grows, "3 numbers after 2", "def __call__"),
]


@pytest.mark.parametrize(("kind", "make", "words", "line"), BROKEN)
def test_a_broken_state_estimator_is_told_its_cause_and_nothing_else(
    kind, make, words, line, capsys
):
    problem = only(check_estimator(make))
    assert problem.kind == kind
    assert words in problem.sentence
    assert line in problem.line.text
    place = Path(problem.line.file).name
    assert place in ("test_doctor.py", "state_estimators.py")
    assert f"{place}:{problem.line.number} in {problem.line.function}" in str(problem)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("check", "base", "piece"),
    [
        (check_estimator, ConstantVelocity, "move"),
        (check_parameter_estimator, LeastSquares, "used"),
    ],
)
def test_a_call_that_takes_longer_than_its_budget_is_told(check, base, piece):
    def slow(self, *arguments):
        time.sleep(0.03)
        return getattr(base, piece)(self, *arguments)

    problem = only(check(changed(base, **{piece: slow}), budget=0.005))
    assert problem.kind == "too slow"
    assert "budget of 5 ms" in problem.sentence


@pytest.mark.parametrize("check", [check_estimator, check_parameter_estimator])
def test_what_never_comes_back_is_stopped(check, monkeypatch):
    def make():
        def estimate(step):
            while step.k == 3:
                pass

        return estimate

    def hangs():
        while True:
            pass

    monkeypatch.setattr("robsim.teach.doctor._slots.TIME_LIMIT", 0.5)
    monkeypatch.setattr("robsim.teach.doctor._trial.TIME_LIMIT", 0.1)
    problem = only(check(hangs))
    assert problem.kind == "make fails"
    assert problem.line.text in ("while True:", "pass")
    if check is check_parameter_estimator:
        problem = only(check(make))
        assert (problem.kind, problem.k) == ("too slow", 3)


def test_a_call_that_hangs_beside_another_estimator_is_no_shared_memory(monkeypatch):
    """On a busy machine a call may come too late at any time."""
    last = None

    class Hangs(ConstantVelocity):
        def __call__(self, step):
            nonlocal last
            before, last = last, self
            while step.k == 8 and before is not self:
                pass
            return super().__call__(step)

    monkeypatch.setattr("robsim.teach.doctor._slots.TIME_LIMIT", 0.5)
    problem = only(check_estimator(Hangs))
    assert (problem.kind, problem.k) == ("too slow", 8)


def test_a_call_that_is_slow_beside_another_estimator_is_no_shared_memory():
    last = None

    class Slow(ConstantVelocity):
        def __call__(self, step):
            nonlocal last
            before, last = last, self
            if before is not self:
                time.sleep(0.2)
            return super().__call__(step)

    problem = only(check_estimator(Slow, budget=0.1))
    assert problem.kind == "too slow"


def test_a_window_is_never_shown(monkeypatch):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    shown = []
    monkeypatch.setattr(pyplot, "show", lambda: shown.append(1))

    def shows(self):
        pyplot.show()
        return ConstantVelocity.result(self)

    report = check_estimator(cv(result=shows))
    assert report
    assert not shown
    assert "plt.show" in " ".join(report.remarks)


class Swapped(Ekf):
    def input(self, step):
        return step.last_u[::-1]


class SwappedWithMemory(Swapped):
    """A filter that begins with the state of the previous run."""

    last = np.zeros(6)

    def __init__(self):
        super().__init__()
        self.x, self.P = SwappedWithMemory.last, 0.1 * self.P

    def result(self):
        SwappedWithMemory.last = self.x
        return super().result()


def swapped_outside():
    def estimate(step):
        if step.k == 0:
            kept["filter"] = Swapped()
        return kept["filter"](step)

    return estimate


@pytest.mark.parametrize(
    ("make", "kinds"),
    [
        (SwappedWithMemory, ["remembers earlier run", "inputs swapped"]),
        (swapped_outside, ["inputs swapped", "shared memory"]),
    ],
)
def test_memory_hides_no_other_fault(make, kinds):
    assert [problem.kind for problem in check_estimator(make).problems] == kinds


class NeedsAModel(ConstantVelocity):
    def __init__(self, model):
        super().__init__()


def stateless(step):
    return robsim.Estimate(step.measurement.pose, np.eye(3))


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [
        (lambda: 3, "not callable", "returns 3"),
        (lambda: None, "not callable", "returns None"),
        (lambda: 1 / 0, "make fails", "ZeroDivisionError"),
        (ConstantVelocity(), "make fails", "which is an estimator"),
        (NeedsAModel, "make fails", "write lambda: NeedsAModel(...)"),
        (stateless, "make fails", "write lambda: stateless"),
        (lambda: lambda: 3, "exception", "takes 0 positional arguments"),
    ],
)
def test_what_makes_no_estimator_is_told_what_to_write(make, kind, words):
    problem = only(check_estimator(make))
    assert problem.kind == kind
    assert words in problem.sentence


def test_a_wrong_argument_is_refused():
    for check in (check_estimator, check_parameter_estimator):
        with pytest.raises(TypeError, match="make"):
            check(3)
        with pytest.raises(ValueError, match="budget"):
            check(ConstantVelocity, budget=0)
    with pytest.raises(TypeError, match="slot estimate_"):
        check_estimator(robsim.Simulation().estimate_state)
    with pytest.raises(ValueError, match="dt"):
        check_estimator(ConstantVelocity, dt=0)
    with pytest.raises(ValueError, match="updates"):
        check_parameter_estimator(LeastSquares, updates=999)


def test_what_an_estimator_makes_no_use_of_is_a_remark():
    assert "never uses step.last_u" in " ".join(check_estimator(ConstantVelocity).remarks)
    assert check_estimator(complementary).remarks == ()


def test_a_sample_time_of_ones_own_is_the_one_that_is_tried():
    times = set()

    def notes(self, u, dt):
        times.add(dt)
        ConstantVelocity.move(self, u, dt)

    assert check_estimator(cv(move=notes), dt=0.125)
    assert times == {0.125}


class Filter:
    """A right one to be spoiled, faster than numpy."""

    def __init__(self):
        self.filters = robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.99)

    def update(self, phi, y):
        return self.result(self.filters.update(phi, y))

    def result(self, theta):
        return theta


def returns(result):
    return changed(Filter, result=lambda self, theta: result(theta))


class Subtracts(Filter):
    def update(self, phi, y):
        y -= y.mean()
        return super().update(phi, y)


class StopsLearning(LeastSquares):
    forgetting = 0.99
    factor = 0.5

    def used(self, phi, y):
        if phi[2, 2] == 0.0:  # no voltage
            self.P = self.P * self.factor
        return phi, y


# The kind, the estimator, a word or number of the sentence, and some of the line.
BROKEN_PARAMETERS = [
    ("output shape", returns(lambda theta: theta[0]), "(5,)", "def update"),
    ("output shape", returns(lambda theta: "done"), "'done'", "def update"),
    ("no adaptation", returns(lambda theta: None), "None", "def update"),
    ("no adaptation", returns(lambda theta: np.ones((3, 5))), "never change", "def update"),
    ("not finite", returns(lambda theta: theta / 0.0), "inf", "def update"),
    ("writes into step", Subtracts, "copy", "y -= y.mean()"),
    ("prints", returns(lambda theta: print("theta") or theta), "'theta'", 'print("theta")'),
    ("exception", returns(lambda theta: {}["theta"]), "KeyError: 'theta'", "theta"),
    ("adaptation stops", StopsLearning, "1000 steps", "def update"),
    ("windup", changed(StopsLearning, factor=3.0), "bound", "self.P = self.reduced(K, phi)"),
    ("not callable", lambda: [1, 2], "update(phi, y)", None),
    (
        "missing sample",
        lambda: lambda step: LeastSquares().update(step.sample.phi, step.sample.y),
        "step.sample is None",
        "lambda step",
    ),
]


@pytest.mark.parametrize(("kind", "make", "words", "line"), BROKEN_PARAMETERS)
def test_a_broken_parameter_estimator_is_told_its_cause_and_nothing_else(
    kind, make, words, line, capsys
):
    problem = only(check_parameter_estimator(make, updates=3000))
    assert problem.kind == kind
    assert words in problem.sentence
    assert line is None or line in problem.line.text
    assert capsys.readouterr().out == ""


def test_a_report_as_text_html_and_data():
    problem = Problem(kind="a", sentence="it is < 0", situation="robot turns", k=7)
    report = CheckReport(name="<filter>", problems=(problem,), remarks=("what about u & dt?",))
    assert not report
    assert "it is < 0" in str(report)
    html = report._repr_html_()
    assert "&lt;filter&gt;" in html
    assert "it is &lt; 0<br><small>step 7, robot turns</small>" in html
    assert "what about u &amp; dt?" in html
    content = report.to_dict()
    assert content["verdict"] == "failed"
    first = {"kind": "a", "sentence": "it is < 0", "situation": "robot turns", "k": 7}
    assert content["problems"][0] == first | {"line": None, "code": None}
    assert report.to_pandas()["kind"].tolist() == ["a"]
    with pytest.raises(AssertionError, match="it is < 0"):
        report.raise_for_problems()


ESTIMATE_STATE = """
import numpy as np
import robsim


class LastPose:
    def __call__(self, step):
        return robsim.Estimate(step.measurement.pose, np.eye(3))


estimate_state = LastPose()
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "estimate_state.py").write_text(ESTIMATE_STATE)
    return tmp_path


def test_a_slot_a_file_and_its_folder_can_be_checked(folder):
    from_slot = check_estimator(lambda: robsim.Simulation.from_folder(folder).estimate_state)
    assert from_slot.name == "LastPose"
    for make in (folder, str(folder), folder / "estimate_state.py"):
        report = check_estimator(make)
        assert only(report).kind == only(from_slot).kind == "missing measurement"
        assert report.problems[0].line.file == str(folder / "estimate_state.py")


def test_a_file_that_has_no_estimator_is_told(folder):
    with pytest.raises(ValueError, match=r"make .* estimate_state\.py"):
        check_estimator(folder / "control.py")
    with pytest.raises(FileNotFoundError):
        check_estimator(folder / "nowhere")
    (folder / "estimate_state.py").write_text(f"ENABLED = False\n{ESTIMATE_STATE}")
    with pytest.raises(ValueError, match=r"estimate_state\.py is switched off"):
        check_estimator(folder)


def test_a_line_of_robsim_is_never_blamed():
    filters = partial(robsim.RecursiveLeastSquares, 5)
    for report in (
        check_estimator(lambda: reference.ConstantVelocityKalmanFilter),
        check_estimator(lambda: robsim.Simulation().control),
        check_parameter_estimator(lambda: lambda step: filters().update(step.sample.phi, 1)),
    ):
        assert report.problems
        for problem in report.problems:
            assert problem.line is None or problem.line.is_users
