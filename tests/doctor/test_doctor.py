import runpy
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import robsim
from parameter_estimators import LeastSquares
from robsim import reference
from robsim.doctor import CheckReport, Problem, check_estimator, check_parameter_estimator
from state_estimators import ConstantVelocity, HandsOn, R, changed, complementary

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
    assert capsys.readouterr().out.startswith("LastPose passed all checks\n")


def cv(**pieces):
    return changed(ConstantVelocity, **pieces)


def gives(result):
    """A right filter that returns something else of its state and its P of the pose."""
    return cv(result=lambda self: result(self.x, self.P[:3, :3]))


class Certain(ConstantVelocity):
    def result(self):
        return robsim.Estimate(self.x[:3], np.zeros((3, 3)))


class AveragesAngles(HandsOn):
    def __call__(self, step):
        self.P = self.P + step.dt * R
        if step.measurement is not None:
            self.pose, self.P = 0.5 * self.pose + 0.5 * step.measurement.pose, R
        return robsim.Estimate(self.pose, self.P)


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


SHARED = ConstantVelocity()


def resets_at_the_start():
    def estimate(step):
        if step.k == 0:
            SHARED.__init__()
        return SHARED(step)

    return estimate


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


def exits(self, u, dt):
    sys.exit("enough")


class Grows(ConstantVelocity):
    calls = 0

    def result(self):
        self.calls += 1
        return robsim.Estimate(self.x[:3], self.P[:3, :3], np.zeros(2 + self.calls // 8))


def nan_if_unseen(self, step):
    return np.full(3, np.nan) if step.measurement is None else step.measurement.pose


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
        "wrong Estimate",
        gives(lambda x, P: robsim.Estimate(x[:3], np.linalg.eigvals(P) * 1j)),
        "covariance",
        "* 1j)",
    ),
    (
        "covariance not symmetric",
        gives(lambda x, P: robsim.Estimate(x[:3], P + 1e-4 * np.eye(3, k=1))),
        "P[",
        "self.P = ",
    ),
    (
        "covariance not positive",
        gives(lambda x, P: robsim.Estimate(x[:3], P + 2 * P[0, 0] * (np.ones(3) - np.eye(3)))),
        "definite",
        "self.P = ",
    ),
    (
        "covariance not positive",
        Certain,
        "0 for x",
        "np.zeros((3, 3)))",
    ),
    ("heading not wrapped", AveragesAngles, "angles", "0.5 * step.measurement.pose"),
    (
        "missing measurement",
        cv(measured=lambda self, step: step.measurement.pose),
        "AttributeError",
        "step.measurement.pose",
    ),
    ("missing measurement", cv(measured=nan_if_unseen), "finite", "return robsim.Estimate"),
    ("not seen yet", StartsWhenSeen, "None", "def __call__"),
    ("writes into step", cv(innovation=writes), "copy", "z -= self.x[:3]"),
    ("remembers earlier run", ClassMemory, "run before", "def __call__"),
    ("shared memory", resets_at_the_start, "global", "def estimate(step):"),
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
    ("exception", cv(move=exits), "SystemExit: enough", 'sys.exit("enough")'),
    ("state length", Grows, "3 numbers after 2", "def __call__"),
    (
        "ignores measurement",
        cv(gain=lambda self, P: np.zeros((6, 3))),
        "seen",
        "step.measurement.pose",
    ),
    (
        "heading in degrees",
        gives(lambda x, P: robsim.Estimate((*x[:2], x[2] + np.degrees(x[2])), P)),
        "rad",
        "measurement",
    ),
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


def test_an_estimator_that_never_comes_back_is_stopped(monkeypatch):
    def make():
        def estimate(step):
            while step.k == 3:
                pass
            return robsim.Estimate((0, 0, 0), R)

        return estimate

    monkeypatch.setattr("robsim.doctor._slots.TIME_LIMIT", 0.5)
    problem = only(check_estimator(make))
    assert (problem.kind, problem.k) == ("too slow", 3)
    assert problem.line.text in ("while step.k == 3:", "pass")


@pytest.mark.parametrize("check", [check_estimator, check_parameter_estimator])
def test_so_is_a_make_that_never_comes_back(check, monkeypatch):
    def make():
        while True:
            pass

    monkeypatch.setattr("robsim.doctor._trial.TIME_LIMIT", 0.1)
    problem = only(check(make))
    assert problem.kind == "make fails"
    assert problem.line.text in ("while True:", "pass")


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

    monkeypatch.setattr("robsim.doctor._slots.TIME_LIMIT", 0.5)
    problem = only(check_estimator(Hangs))
    assert (problem.kind, problem.k) == ("too slow", 8)


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
        (ConstantVelocity(), "make fails", "it is an estimator already"),
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


def test_independent_findings_are_all_told():
    make = cv(move=prints, innovation=lambda self, z: z - self.x[:3])
    kinds = [problem.kind for problem in check_estimator(make).problems]
    assert kinds == ["heading not wrapped", "prints"]


def as_callback():
    estimator = robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.99)

    def estimate(step):
        return None if step.sample is None else estimator.update(step.sample.phi, step.sample.y)

    return estimate


def test_right_parameter_estimators_are_well():
    check_parameter_estimator(as_callback).raise_for_problems()
    symmetric = changed(LeastSquares, forgetting=0.99)
    check_parameter_estimator(symmetric, updates=3000).raise_for_problems()


@pytest.mark.slow
def test_slow_forgetting_diverges_in_a_longer_run():
    slowly = changed(LeastSquares, forgetting=0.999, reduced=LeastSquares.shrunk)
    assert check_parameter_estimator(slowly)
    problem = only(check_parameter_estimator(slowly, updates=30_000))
    assert problem.kind == "diverges"
    assert problem.k > 10_000


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


class OneForAll(Filter):
    filters = robsim.RecursiveLeastSquares(5, n_filters=3)

    def __init__(self):
        pass


ONE = Filter()


class ResetsOneForAll:
    def __init__(self):
        ONE.__init__()

    def update(self, phi, y):
        return ONE.update(phi, y)


class Fails(Filter):
    updates = 0
    last, error = 11, KeyError("theta")

    def update(self, phi, y):
        self.updates += 1
        if self.updates > self.last:
            raise self.error
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
    (
        "diverges",
        changed(LeastSquares, forgetting=0.99, reduced=LeastSquares.shrunk),
        "(P + P.T) / 2",
        "self.P = self.reduced(K, phi)",
    ),
    ("output shape", returns(lambda theta: theta[0]), "(5,)", "def update"),
    ("output shape", returns(lambda theta: "done"), "'done'", "def update"),
    ("no adaptation", returns(lambda theta: None), "None", "def update"),
    ("no adaptation", returns(lambda theta: np.ones((3, 5))), "never change", "def update"),
    ("not finite", returns(lambda theta: theta / 0.0), "inf", "def update"),
    ("writes into step", Subtracts, "copy", "y -= y.mean()"),
    ("remembers earlier run", OneForAll, "global", "def update"),
    ("shared memory", ResetsOneForAll, "global", "def update"),
    ("prints", returns(lambda theta: print("theta") or theta), "'theta'", 'print("theta")'),
    ("exception", Fails, "KeyError: 'theta'", "raise self.error"),
    ("exception", changed(Fails, last=2000, error=MemoryError("no room")), "no room", "raise"),
    ("adaptation stops", StopsLearning, "1000 steps", "def update"),
    ("windup", changed(StopsLearning, factor=3.0), "bound", "self.P = self.reduced(K, phi)"),
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
    assert line in problem.line.text
    assert capsys.readouterr().out == ""


def test_what_has_no_update_is_told_so():
    problem = only(check_parameter_estimator(lambda: [1, 2]))
    assert problem.kind == "not callable"
    assert "update(phi, y)" in problem.sentence


def test_a_report_as_text_html_and_data():
    report = CheckReport(
        name="<filter>",
        problems=(
            Problem(kind="a", sentence="it is < 0", situation="robot turns", k=7),
            Problem(kind="b", sentence="it is late"),
        ),
        remarks=("what about u & dt?",),
    )
    assert not report
    lines = [line.strip() for line in str(report).splitlines()]
    assert lines[1:] == ["1. it is < 0", "step 7, robot turns", "2. it is late",
                         "- what about u & dt?"]  # fmt: skip
    html = report._repr_html_()
    assert "&lt;filter&gt;" in html
    assert "<li>it is &lt; 0<br><small>step 7, robot turns</small></li>" in html
    assert "<li>what about u &amp; dt?</li>" in html
    content = report.to_dict()
    assert content["verdict"] == "failed"
    first = {"kind": "a", "sentence": "it is < 0", "situation": "robot turns", "k": 7}
    assert content["problems"][0] == first | {"line": None, "code": None}
    assert CheckReport(name="it").to_dict()["problems"] == []
    assert report.to_pandas()["kind"].tolist() == ["a", "b"]
    with pytest.raises(AssertionError) as caught:
        report.raise_for_problems()
    assert str(caught.value) == str(report)
    assert "it is late" in repr(report)  # what `assert report` shows in a test of a grader


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


def test_the_file_of_a_parameter_estimator_can_be_checked(tmp_path):
    (tmp_path / "init_parameter_estimator.py").write_text(
        "import robsim\n\n\ndef init_parameter_estimator(model):\n"
        "    return robsim.RecursiveLeastSquares(5, n_filters=3)\n"
    )
    check_parameter_estimator(tmp_path, updates=1000).raise_for_problems()


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
