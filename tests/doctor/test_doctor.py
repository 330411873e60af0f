import runpy
import subprocess
import sys
import textwrap
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import robsim
from robsim import reference
from robsim.doctor import (
    CheckReport,
    Problem,
    check_estimator,
    check_parameter_estimator,
)
from robsim.doctor import _slots as slots
from robsim.doctor import _trial as trial
from robsim.doctor._reproducibility import together_problem
from robsim.doctor._situations import turning, weaving

pytestmark = [pytest.mark.kernels, pytest.mark.long]

R = np.diag((0.5**2, 0.5**2, 0.01**2))


class ConstantVelocity:
    """A right one: a Kalman filter that takes the velocities for constant."""

    def __init__(self):
        self.x, self.P = np.zeros(6), np.diag((1e6, 1e6, 10.0, 1e3, 1e3, 1.0))

    def predict(self, dt):
        F = np.eye(6) + dt * np.eye(6, k=3)
        G = np.vstack((np.eye(3) * dt**2 / 2, np.eye(3) * dt))
        self.x = F @ self.x
        self.P = F @ self.P @ F.T + G @ np.diag((30.0**2, 30.0**2, 3.0**2)) @ G.T

    def innovation(self, measurement):
        v = measurement.pose - self.x[:3]
        v[2] = robsim.wrap_angle(v[2])
        return v

    def correct(self, v):
        H = np.eye(3, 6)
        K = np.linalg.solve(H @ self.P @ H.T + R, H @ self.P).T
        self.x = self.x + K @ v
        self.P = (np.eye(6) - K @ H) @ self.P @ (np.eye(6) - K @ H).T + K @ R @ K.T

    def result(self):
        return robsim.Estimate(self.x[:3], self.P[:3, :3], self.x[3:])

    def __call__(self, step):
        if step.k > 0:
            self.predict(step.dt)
        if step.measurement is not None:
            self.correct(self.innovation(step.measurement))
        return self.result()


def complementary():
    """A right one without a matrix: the model's speed is mixed with what is seen."""
    pose, doubt, speed = np.array((0.0, 0.0, 0.0)), 1e6, 0.0

    def estimate(step):
        nonlocal pose, doubt, speed
        # m s' + F s = (torques) / radius of the wheels
        speed += step.dt / 0.3 * (0.05 / 0.03 * step.last_u.sum() - 0.1 * speed)
        way = speed * step.dt * np.array((np.cos(pose[2]), np.sin(pose[2]), 0.0))
        pose, doubt = pose + way, doubt + step.dt
        if step.measurement is not None:
            error = step.measurement.pose - pose
            error[2] = robsim.wrap_angle(error[2])
            pose, doubt = pose + 0.7 * error, 0.5
        return robsim.Estimate(pose, doubt * np.diag((1.0, 1.0, 1e-3)))

    return estimate


def only(report):
    """The one problem of a report: the cause, and nothing that follows from it."""
    assert not report
    assert len(report.problems) == 1, str(report)
    return report.problems[0]


@pytest.mark.parametrize("make", [ConstantVelocity, complementary])
def test_right_state_estimators_are_well(make):
    report = check_estimator(make)
    assert report, str(report)
    assert str(report).startswith(f"{report.name} passed all checks")
    assert report.raise_for_problems() is report


@pytest.mark.parametrize("dt", [1 / 30, 0.5])
def test_right_ones_are_well_at_other_sample_times(dt):
    check_estimator(ConstantVelocity, dt=dt).raise_for_problems()


FILTERS = [
    reference.ConstantVelocityKalmanFilter,
    reference.ExtendedKalmanFilter,
    reference.UnscentedKalmanFilter,
    pytest.param(reference.ParticleFilter, marks=pytest.mark.slow),
]


@pytest.mark.parametrize("make", FILTERS)
def test_the_reference_filters_are_well(make):
    takes_a_model = make is not reference.ConstantVelocityKalmanFilter
    check_estimator(
        partial(make, robsim.RobotModel()) if takes_a_model else make
    ).raise_for_problems()


TEMPLATE = Path(robsim.__file__).with_name("simulation") / "templates" / "estimate_state.py"


def test_the_template_of_a_state_estimator_is_well():
    check_estimator(runpy.run_path(str(TEMPLATE))["LastPose"]).raise_for_problems()


def test_the_template_of_a_state_estimator_examines_itself_as_a_program(capsys):
    runpy.run_path(str(TEMPLATE), run_name="__main__")
    assert capsys.readouterr().out.startswith("LastPose passed all checks\n")


class ReturnsTheState(ConstantVelocity):
    def result(self):
        return self.x


class WholeState(ConstantVelocity):
    def result(self):
        return robsim.Estimate(self.x, self.P)


class Complex(ConstantVelocity):
    def result(self):
        return robsim.Estimate(self.x[:3], np.linalg.eigvals(self.P[:3, :3]) * 1j)


class Asymmetric(ConstantVelocity):
    def result(self):
        return robsim.Estimate(self.x[:3], self.P[:3, :3] + 1e-4 * np.eye(3, k=1))


class WrongSign(ConstantVelocity):
    def correct(self, v):
        super().correct(v)
        self.P = self.P + np.ones((6, 6)) * 2 * self.P[0, 0]

    def result(self):
        return robsim.Estimate(self.x[:3], 2 * np.diag(np.diag(self.P)[:3]) - self.P[:3, :3])


class Certain(ConstantVelocity):
    def result(self):
        return robsim.Estimate(self.x[:3], np.zeros((3, 3)))


class Unwrapped(ConstantVelocity):
    def innovation(self, measurement):
        return measurement.pose - self.x[:3]


class AveragesAngles:
    def __init__(self):
        self.pose, self.P = np.zeros(3), R

    def __call__(self, step):
        self.P = self.P + step.dt * R
        if step.measurement is not None:
            self.pose, self.P = 0.5 * self.pose + 0.5 * step.measurement.pose, R
        return robsim.Estimate(self.pose, self.P)


class ExpectsTheRobot(ConstantVelocity):
    def __call__(self, step):
        self.predict(step.dt)
        self.correct(step.measurement.pose - self.x[:3])
        return self.result()


class MakesNan(ConstantVelocity):
    def __call__(self, step):
        z = np.full(3, np.nan) if step.measurement is None else step.measurement.pose
        self.predict(step.dt)
        self.correct(z - self.x[:3])
        return self.result()


class StartsWhenSeen(ConstantVelocity):
    started = False

    def __call__(self, step):
        if step.measurement is None and not self.started:
            return None
        self.started = True
        return super().__call__(step)


class FixedStep(ConstantVelocity):
    def predict(self, dt):
        super().predict(0.2)


class WritesIntoStep(ConstantVelocity):
    def innovation(self, measurement):
        v = measurement.pose
        v -= self.x[:3]
        return v


class ClassMemory(ConstantVelocity):
    x, P = np.zeros(6), 1e6 * np.eye(6)

    def __init__(self):
        pass

    def correct(self, v):
        super().correct(v)
        ClassMemory.x = self.x


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
            kept["estimate"] = robsim.Estimate((600, 600, 0), 1e4 * np.eye(3))
        if step.measurement is not None:
            kept["estimate"] = robsim.Estimate(step.measurement.pose, R)
        else:
            P = kept["estimate"].covariance
            kept["estimate"] = robsim.Estimate(kept["estimate"].pose, P + step.dt * R)
        return kept["estimate"]

    return estimate


class Unseeded(ConstantVelocity):
    def __init__(self):
        super().__init__()
        self.rng = np.random.default_rng()

    def result(self):
        return robsim.Estimate(self.x[:3] + self.rng.normal(size=3) / 100, self.P[:3, :3])


class LooksAhead(ConstantVelocity):
    """Climbs up the stack to what will be measured next."""

    def __call__(self, step):
        frame = sys._getframe()
        while "_situation" not in getattr(frame.f_locals.get("self"), "__dict__", {}):
            frame = frame.f_back
        seen = frame.f_locals["self"]._situation.measurements[step.k :][:2]
        self.predict(step.dt)
        if seen[-1] is not None:
            self.correct(self.innovation(seen[-1]))
        return self.result()


class Prints(ConstantVelocity):
    def predict(self, dt):
        print("step of", dt, "s")
        super().predict(dt)


class Raises(ConstantVelocity):
    def predict(self, dt):
        super().predict(dt)
        if self.x[0] > 500:
            raise KeyError("x")


class Exits(ConstantVelocity):
    def predict(self, dt):
        sys.exit("enough")


class Sleeps(ConstantVelocity):
    def predict(self, dt):
        time.sleep(0.03)
        super().predict(dt)


class Grows(ConstantVelocity):
    calls = 0

    def result(self):
        self.calls += 1
        return robsim.Estimate(self.x[:3], self.P[:3, :3], np.zeros(2 + self.calls // 8))


class Deaf(ConstantVelocity):
    def correct(self, v):
        pass


class Degrees(ConstantVelocity):
    def result(self):
        return robsim.Estimate(np.degrees(self.x[:3]) * (0, 0, 1) + self.x[:3], self.P[:3, :3])


class NeverDoubts(ConstantVelocity):
    def result(self):
        return robsim.Estimate(self.x[:3], R)


# The estimator, the kind, words of the sentence, and of the line.
BROKEN = [
    (ReturnsTheState, "no Estimate", "array of shape (6,)", "def __call__"),
    (WholeState, "wrong Estimate", "pose must be", "return robsim.Estimate(self.x, self.P)"),
    (Complex, "wrong Estimate", "covariance must be", "* 1j)"),
    (Asymmetric, "covariance not symmetric", "is not symmetric, P[", "self.P = "),
    (WrongSign, "covariance not positive", "not positive definite", "self.P = "),
    (Certain, "covariance not positive", "the variance 0 for x", "np.zeros((3, 3)))"),
    (Unwrapped, "heading not wrapped", "wrap the innovation", "measurement.pose - self.x"),
    (AveragesAngles, "heading not wrapped", "average no angles", "0.5 * step.measurement.pose"),
    (ExpectsTheRobot, "missing measurement", "AttributeError", "step.measurement.pose"),
    (MakesNan, "missing measurement", "all finite", "return robsim.Estimate"),
    (StartsWhenSeen, "not seen yet", "it returns None", "def __call__"),
    (WritesIntoStep, "writes into step", "work on a copy", "v -= self.x[:3]"),
    (ClassMemory, "remembers earlier run", "remembers the run before", "def __call__"),
    (resets_at_the_start, "shared memory", "influence each other", "def estimate(step):"),
    (keeps_the_last_pose_outside, "shared memory", "global variable", "def estimate(step):"),
    (Unseeded, "not reproducible", "fixed seed", "def __call__"),
    (LooksAhead, "depends on future", "comes later", "def __call__"),
    (Prints, "prints", "'step of 0.2 s'", 'print("step of", dt, "s")'),
    (Raises, "exception", "raises KeyError: 'x'", 'raise KeyError("x")'),
    (Exits, "exception", "raises SystemExit: enough", 'sys.exit("enough")'),
    (Sleeps, "too slow", "budget of 20 ms", "def __call__"),
    (Grows, "state length", "3 numbers after 2", "def __call__"),
    (Deaf, "ignores measurement", "wherever the robot is seen", "measurement.pose"),
    (Degrees, "heading in degrees", "headings are in rad", "measurement"),
    (NeverDoubts, "covariance does not grow", "20 steps without", "return robsim.Estimate"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "kind", "words", "line"), BROKEN)
def test_a_broken_state_estimator_is_told_its_cause_and_nothing_else(
    make, kind, words, line, capsys
):
    problem = only(check_estimator(make))
    assert problem.kind == kind
    assert words in problem.sentence
    assert line in problem.line.text
    assert problem.line.file == __file__
    assert f"test_doctor.py:{problem.line.number} in {problem.line.function}" in str(problem)
    assert capsys.readouterr().out == ""


def test_an_estimator_that_never_comes_back_is_stopped(monkeypatch):
    def make():
        def estimate(step):
            while step.k == 3:
                pass
            return robsim.Estimate((0, 0, 0), R)

        return estimate

    monkeypatch.setattr(slots, "TIME_LIMIT", 0.3)
    problem = only(check_estimator(make))
    assert (problem.kind, problem.k) == ("too slow", 3)
    assert "never ends" in problem.sentence
    assert problem.line.text in ("while step.k == 3:", "pass")


@pytest.mark.parametrize("check", [check_estimator, check_parameter_estimator])
def test_so_is_a_make_that_never_comes_back(check, monkeypatch):
    def make():
        while True:
            pass

    monkeypatch.setattr(trial, "TIME_LIMIT", 0.3)
    problem = only(check(make))
    assert problem.kind == "make fails"
    assert "never ends" in problem.sentence
    assert problem.line.text in ("while True:", "pass")


class NeedsAModel(ConstantVelocity):
    def __init__(self, model):
        super().__init__()


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [(lambda: 3, "not callable", "make() returns 3, which cannot be called as estimate(step)"),
     (lambda: None, "not callable", "make() returns None, which"),
     (lambda: 1 / 0, "make fails", "make() returns no estimator: it raises ZeroDivisionError"),
     (ConstantVelocity(), "make fails", "make takes no argument and returns a fresh estimator"),
     (NeedsAModel, "make fails", "got NeedsAModel(model) (test_doctor.py:"),
     (lambda: lambda: 3, "exception", "takes 0 positional arguments but 1 was given")],
)  # fmt: skip
def test_what_makes_no_estimator_is_told_so(make, kind, words):
    problem = only(check_estimator(make))
    assert problem.kind == kind
    assert words in problem.sentence


def test_a_wrong_argument_is_refused():
    with pytest.raises(TypeError, match=r"make must be callable .* got 3"):
        check_estimator(3)
    with pytest.raises(ValueError, match="dt must lie within"):
        check_estimator(ConstantVelocity, dt=0)
    with pytest.raises(ValueError, match="budget must be finite and above 0"):
        check_parameter_estimator(lambda: None, budget=0)
    with pytest.raises(ValueError, match=r"updates must lie within 1000\.\."):
        check_parameter_estimator(lambda: None, updates=10)


def test_what_an_estimator_makes_no_use_of_is_a_remark():
    assert "never uses step.last_u" in " ".join(check_estimator(ConstantVelocity).remarks)
    assert check_estimator(complementary).remarks == ()

    def of_a_model():
        model = complementary()
        return lambda step: model(SimpleStep(step))

    class SimpleStep:
        def __init__(self, step):
            self.k, self.dt, self.measurement = step.k, 0.2, step.measurement
            self.last_u = step.last_u

    report = check_estimator(of_a_model)
    assert report
    assert "never uses step.dt" in " ".join(report.remarks)
    assert check_estimator(FixedStep, dt=0.2)


def test_a_sample_time_of_ones_own_is_the_one_that_is_tried():
    seen = set()

    class Notes(ConstantVelocity):
        def predict(self, dt):
            seen.add(dt)
            super().predict(dt)

    assert check_estimator(Notes, dt=0.125)
    assert seen == {0.125}


def test_independent_findings_are_all_told():
    class Both(Prints):
        def innovation(self, measurement):
            return measurement.pose - self.x[:3]

    kinds = [problem.kind for problem in check_estimator(Both).problems]
    assert kinds == ["heading not wrapped", "prints"]


def test_a_constant_dt_is_a_remark():
    report = check_estimator(FixedStep)
    assert report  # one with speeds per step, which is right for every dt, estimates the same
    assert any("never uses step.dt" in remark for remark in report.remarks)


class LeastSquares:
    """A right one: recursive least squares in numpy, three axes at once, P kept symmetric."""

    forgetting = 0.99

    def __init__(self):
        self.theta, self.P = np.zeros((3, 5)), np.tile(1e6 * np.eye(5), (3, 1, 1))

    def reduced(self, K, Pphi):
        P = (self.P - K[:, :, np.newaxis] * Pphi[:, np.newaxis]) / self.forgetting
        return (P + P.transpose(0, 2, 1)) / 2

    def update(self, phi, y):
        Pphi = (self.P @ phi[:, :, np.newaxis])[:, :, 0]
        K = Pphi / (self.forgetting + (phi * Pphi).sum(axis=1, keepdims=True))
        self.theta = self.theta + K * (y - (phi * self.theta).sum(axis=1))[:, np.newaxis]
        self.P = self.reduced(K, Pphi)
        return self.theta


def as_callback():
    estimator = robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.99)

    def estimate(step):
        return None if step.sample is None else estimator.update(step.sample.phi, step.sample.y)

    return estimate


@pytest.mark.parametrize(
    "make",
    [LeastSquares,
     as_callback,
     pytest.param(lambda: robsim.RecursiveLeastSquares(5, n_filters=3), marks=pytest.mark.slow),
     lambda: robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.99),
     pytest.param(
         lambda: robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.95),
         marks=pytest.mark.slow,
     )],
    ids=["numpy", "callback", "1", "0.99", "0.95"],
)  # fmt: skip
def test_right_parameter_estimators_are_well(make):
    check_parameter_estimator(make).raise_for_problems()


class Diverges(LeastSquares):
    def reduced(self, K, Pphi):
        return (self.P - K[:, :, np.newaxis] * Pphi[:, np.newaxis]) / self.forgetting


@pytest.mark.slow
def test_slow_forgetting_diverges_in_a_longer_run():
    class Slowly(Diverges):
        forgetting = 0.999

    assert check_parameter_estimator(Slowly)
    problem = only(check_parameter_estimator(Slowly, updates=30_000))
    assert problem.kind == "diverges"
    assert problem.k > 10_000


class Wrapped:
    """A right one to be spoiled, faster than numpy."""

    def __init__(self):
        self.filters = robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.99)

    def update(self, phi, y):
        return self.filters.update(phi, y)


class OneRow(Wrapped):
    def update(self, phi, y):
        return super().update(phi, y)[0]


class Words(Wrapped):
    def update(self, phi, y):
        return "done"


class Forgets(Wrapped):
    def update(self, phi, y):
        super().update(phi, y)


class Constant(Wrapped):
    def update(self, phi, y):
        return np.ones((3, 5))


class Negative(Wrapped):
    def update(self, phi, y):
        return -super().update(phi, y)


class Divides(Wrapped):
    def update(self, phi, y):
        return super().update(phi, y) / 0.0


class Subtracts(Wrapped):
    def update(self, phi, y):
        y -= y.mean()
        return super().update(phi, y)


class OneForAll(Wrapped):
    filters = robsim.RecursiveLeastSquares(5, n_filters=3)

    def __init__(self):
        pass


ONE = Wrapped()


class ResetsOneForAll:
    def __init__(self):
        ONE.__init__()

    def update(self, phi, y):
        return ONE.update(phi, y)


class Chatty(Wrapped):
    def update(self, phi, y):
        print("theta")
        return super().update(phi, y)


class Unlucky(Wrapped):
    updates = 0

    def update(self, phi, y):
        self.updates += 1
        return super().update(phi, y) if self.updates < 12 else {}["theta"]


class FullMemory(Wrapped):
    updates = 0

    def update(self, phi, y):
        self.updates += 1
        if self.updates > 2000:
            raise MemoryError("no room for more samples")
        return super().update(phi, y)


class Slow(Wrapped):
    def update(self, phi, y):
        time.sleep(0.03)
        return super().update(phi, y)


class StopsLearning(LeastSquares):
    factor = 0.5

    def update(self, phi, y):
        if phi[2, 2] == 0.0:  # no voltage
            self.P = self.P * self.factor
        return super().update(phi, y)


class WindsUp(StopsLearning):
    factor = 3.0


def hasty_callback():
    return lambda step: LeastSquares().update(step.sample.phi, step.sample.y)


BROKEN_PARAMETERS = [
    (Diverges, "diverges", "P = (P + P.T) / 2", "self.P = self.reduced(K, Pphi)"),
    (OneRow, "output shape", "array of shape (5,)", "def update"),
    (Words, "output shape", "it returns 'done', not the parameters", "def update"),
    (Forgets, "no adaptation", "None at every step", "def update"),
    (Constant, "no adaptation", "never change", "def update"),
    (Negative, "wrong sign", "with the opposite sign they are right", "def update"),
    (Divides, "not finite", "NaN or inf", "def update"),
    (Subtracts, "writes into step", "work on a copy", "y -= y.mean()"),
    (OneForAll, "remembers earlier run", "not in a global variable", "def update"),
    (ResetsOneForAll, "shared memory", "global variable", "def update"),
    (Chatty, "prints", "'theta'", 'print("theta")'),
    (Unlucky, "exception", "raises KeyError: 'theta'", '{}["theta"]'),
    (FullMemory, "exception", "no room for more samples", "raise MemoryError"),
    (Slow, "too slow", "budget of 20 ms", "def update"),
    (StopsLearning, "adaptation stops", "1000 steps of constant input", "def update"),
    (WindsUp, "windup", "must not grow without bound", "self.P = self.reduced(K, Pphi)"),
    (hasty_callback, "missing sample", "step.sample is None", "lambda step"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "kind", "words", "line"), BROKEN_PARAMETERS)
def test_a_broken_parameter_estimator_is_told_its_cause_and_nothing_else(
    make, kind, words, line, capsys
):
    problem = only(check_parameter_estimator(make, updates=3000))
    assert problem.kind == kind
    assert words in problem.sentence
    assert line in problem.line.text
    assert capsys.readouterr().out == ""


def test_what_has_no_update_is_told_so():
    problem = only(check_parameter_estimator(lambda: [1, 2]))
    assert problem.kind == "not callable"
    assert "make() returns [1, 2], which has no method update(phi, y)" in problem.sentence


def test_the_report_as_text_and_as_html():
    report = CheckReport(
        name="<filter>",
        problems=(
            Problem(kind="a", sentence="it is < 0", situation="robot turns", k=7),
            Problem(kind="b", sentence="it is late"),
        ),
        remarks=("what about u & dt?",),
    )
    assert not report
    assert str(report) == textwrap.dedent("""\
        <filter> failed 2 checks
          1. it is < 0
             step 7, robot turns
          2. it is late
          - what about u & dt?""")
    assert report._repr_html_() == (
        "<div><p><b>&lt;filter&gt; failed 2 checks</b></p>"
        "<ol><li>it is &lt; 0<br><small>step 7, robot turns</small></li>"
        "<li>it is late</li></ol>"
        "<ul><li>what about u &amp; dt?</li></ul></div>"
    )
    numbers = report.to_dict()
    assert (numbers["title"], numbers["verdict"]) == ("Check of <filter>", "failed")
    assert numbers["problems"][0] == {
        "kind": "a",
        "sentence": "it is < 0",
        "situation": "robot turns",
        "k": 7,
        "line": None,
        "code": None,
    }
    assert CheckReport(name="it").to_dict()["problems"] == []
    assert report.to_pandas()["kind"].tolist() == ["a", "b"]
    with pytest.raises(AssertionError) as caught:
        report.raise_for_problems()
    assert str(caught.value) == str(report)


GRADING = """
import numpy as np
import robsim
from robsim.doctor import check_estimator


def make():
    def estimate(step):
        return robsim.Estimate(step.measurement.pose, np.zeros((3, 3)))

    return estimate


def test_plain():
    assert check_estimator(make)


def test_thorough():
    check_estimator(make).raise_for_problems()
"""


def test_a_grader_sees_the_sentences(tmp_path):
    (tmp_path / "test_grading.py").write_text(GRADING)
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    plain, thorough = run.stdout.split("_ test_thorough _")
    assert "assert <its covariance has the variance 0 for x: a variance must be above 0" in plain
    assert "1. its covariance has the variance 0 for x" in thorough
    assert "2. step.measurement is None where the robot is not seen: then it raises" in thorough
    assert "> return robsim.Estimate(step.measurement.pose, np.zeros((3, 3)))" in thorough


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


def test_the_estimator_in_a_slot_of_a_folder_is_checked_and_not_the_slot(folder):
    report = check_estimator(lambda: robsim.Simulation.from_folder(folder).estimate_state)
    assert report.name == "LastPose"
    assert [problem.kind for problem in report.problems] == ["missing measurement"]
    assert report.problems[0].line.file == str(folder / "estimate_state.py")


@pytest.mark.parametrize("path", [".", "estimate_state.py"])
def test_a_file_or_its_folder_can_be_checked(folder, path):
    report = check_estimator(folder / path)
    assert only(report).kind == "missing measurement"
    assert str(check_estimator(str(folder / path))) == str(report)


def test_the_file_of_a_parameter_estimator_can_be_checked(tmp_path):
    (tmp_path / "init_parameter_estimator.py").write_text(
        "import robsim\n\n\ndef init_parameter_estimator(model):\n"
        "    return robsim.RecursiveLeastSquares(5, n_filters=3)\n"
    )
    check_parameter_estimator(tmp_path, updates=1000).raise_for_problems()


def test_a_file_that_has_no_estimator_is_told(folder, tmp_path):
    with pytest.raises(ValueError, match=r"make must be a file estimate_state\.py, or a folder"):
        check_estimator(folder / "control.py")
    with pytest.raises(FileNotFoundError, match="no folder"):
        check_estimator(folder / "nowhere")
    (folder / "estimate_state.py").write_text(f"ENABLED = False\n{ESTIMATE_STATE}")
    with pytest.raises(ValueError, match=r"estimate_state\.py is switched off: set ENABLED = True"):
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


def stateless(step):
    return robsim.Estimate(step.measurement.pose, np.eye(3))


@pytest.mark.parametrize(
    ("make", "name", "words"),
    [(NeedsAModel, "NeedsAModel", "write lambda: NeedsAModel(...)"),
     (ConstantVelocity(), "ConstantVelocity", "it is an estimator already; give its class, or"),
     (stateless, "stateless", "if that is the estimator itself, write lambda: stateless")],
)  # fmt: skip
def test_what_makes_no_estimator_says_what_to_write(make, name, words):
    report = robsim.check_estimator(make)
    assert report.name == name
    assert words in report.problems[0].sentence


def test_a_slot_is_no_maker_of_estimators():
    with pytest.raises(TypeError, match=r"such as its class, or lambda: .*, got <slot estimate_"):
        robsim.check_estimator(robsim.Simulation().estimate_state)


def test_a_slow_call_beside_another_estimator_is_no_shared_memory(monkeypatch):
    """On a busy machine a call may come too late at any time."""
    estimator = trial.EstimatorUnderTest(ConstantVelocity, slots.STATE, budget=0.02)
    alone = estimator.try_in(weaving(0.2))
    late = replace(alone, outputs=alone.outputs[:8], error=TimeoutError("too late"))
    monkeypatch.setattr(estimator, "try_together", lambda *_: late)
    problem = together_problem(estimator, alone, turning(0.2))
    assert (problem.kind, problem.k) == ("too slow", 8)
