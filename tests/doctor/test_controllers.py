"""What the doctor says of controllers: right ones are well, and wrong ones hear why."""

import math
import re

import numpy as np
import pytest

import robsim
from robsim.teach import check_controller

pytestmark = pytest.mark.long

CONTROLLERS = "robsim.teach.doctor.callbacks.controllers"
PATIENT = 60.0  # s: how quick they are is no question here


def plain(angle):
    return angle


def regulator(wrap=robsim.wrap_angle, *, turn=1, up=1, swap=False, rate=0.0, rate_wrap=None):
    """Return a maker of controllers to (900, 300), right unless told otherwise."""
    rate_wrap = rate_wrap or robsim.wrap_angle

    def make():
        last = None

        def control(step):
            nonlocal last
            if step.measurement is None:
                return 0.0, 0.0
            x, y, heading = step.measurement.pose
            dx, dy = 900 - x, up * (300 - y)
            error = wrap((math.atan2(dx, dy) if swap else math.atan2(dy, dx)) - heading)
            speed = 0.0 if last is None else rate_wrap(heading - last) / step.dt
            last = heading
            steer = turn * float(np.clip(0.5 * error - rate * speed, -0.5, 0.5))
            drive = min(0.5, 0.01 * math.hypot(dx, dy)) if abs(error) < 1 else 0.0
            return drive + steer, drive - steer

        return control

    return make


def holding(wanted, wrap=robsim.wrap_angle):
    def control(step):
        if step.measurement is None:
            return 0.0, 0.0
        error = wrap(wanted - step.measurement.pose[2])
        return 0.3 + 0.3 * error, 0.3 - 0.3 * error

    return lambda: control


class TurnsThenStops:
    def __init__(self):
        self.state = "turn"

    def __call__(self, step):
        if step.measurement is not None and step.measurement.pose[2] > 1.57:
            self.state = "stop"
        return (0.05, -0.05) if self.state == "turn" else (0, 0)


def pursuit():
    path = np.column_stack((np.linspace(200, 1000, 60), 600 + 200 * np.sin(np.linspace(0, 6, 60))))

    def control(step):
        if step.estimate is None:
            return 0, 0
        x, y, heading = step.estimate.pose
        nearest = int(np.argmin(np.hypot(path[:, 0] - x, path[:, 1] - y)))
        goal = path[min(nearest + 6, len(path) - 1)]
        angle = math.atan2(goal[1] - y, goal[0] - x) - heading
        return np.array((0.4 + 0.4 * math.sin(angle), 0.4 - 0.4 * math.sin(angle)))

    return control


RIGHT = {
    "to a point": lambda: robsim.GoToPoint(300, 900),
    "along a path": lambda: robsim.FollowPath([(400, 400), (800, 400), (800, 800)]),
    "drive around": robsim.DriveAround,
    "replay": lambda: robsim.Replay(np.ones((2000, 2))),
    "proportional": regulator(),
    "with a rate": regulator(rate=0.3),
    "state machine": TurnsThenStops,
    "pure pursuit": pursuit,
    "heading 0 needs no wrapping": holding(0.0, plain),
    "heading 3": holding(3.0),
}


@pytest.fixture
def frames(request, name):
    """Small frames; some controllers get those of the users."""
    if name not in ("to a point", "proportional", "not wrapped", "y up"):
        request.getfixturevalue("small_frames")


@pytest.mark.slow
@pytest.mark.usefixtures("frames")
@pytest.mark.parametrize("name", RIGHT)
def test_right_controllers_are_well(name):
    report = check_controller(RIGHT[name], budget=PATIENT).raise_for_problems()
    swings = name in ("proportional", "with a rate")  # at the goal
    assert ("does not stand still at its goal" in str(report)) == swings


# The controller, the kind, and a word of what to do.
WRONG = {
    "not wrapped": (regulator(plain), "heading not wrapped", "robsim.wrap_angle(wanted"),
    "rate not wrapped": (regulator(rate=0.3, rate_wrap=plain), "heading not wrapped", "new - old"),
    "heading not wrapped": (holding(2.0, plain), "heading not wrapped", "robsim.wrap_angle"),
    "exchanged": (regulator(turn=-1), "turns away", "back"),
    "y up": (regulator(up=-1), "y axis", "down"),
    "x and y": (regulator(swap=True), "swapped arguments", "y first"),
}


@pytest.mark.slow
@pytest.mark.usefixtures("frames")
@pytest.mark.parametrize("name", WRONG)
def test_wrong_steering_is_told(name):
    make, kind, words = WRONG[name]
    (problem,) = check_controller(make, budget=PATIENT).problems
    assert problem.kind == kind
    assert words in problem.sentence
    assert problem.line.function == "control"
    if point := re.search(r"\((\d+), (\d+)\)", problem.sentence):
        assert math.dist([*map(int, point.groups())], (900, 300)) < 15


@pytest.fixture
def hurried(monkeypatch, small_frames):
    """Leave out what takes seconds."""
    starts = {"robot starts in a corner": (200.0, 200.0, 3.1)}
    monkeypatch.setattr(f"{CONTROLLERS}._LONG", 60)
    monkeypatch.setattr(f"{CONTROLLERS}._STARTS", starts)
    monkeypatch.setattr(f"{CONTROLLERS}.steering_findings", lambda *_: ())


def late(step):
    return [(0.1, 0.1)][step.k // 50]


def forgets_none(step):
    return step.measurement.pose[:2] / 1000


def forgets_return(step):
    if step.measurement is not None:
        return 0.1, 0.1
    return None


# The controller, the kind, a word or number of the sentence, and the step.
FAULTS = [
    (lambda step: (0.1,), "output shape", "(0.1,)", 0),
    (lambda step: ("0.5", "0.5"), "output shape", "('0.5', '0.5')", 0),
    (lambda step: (math.nan, 1), "not finite", "(nan, 1) V", 0),
    (lambda step: (255, 255), "input too large", "8-bit", 0),
    (lambda step: (700.5, 650), "input too large", "millivolts", 0),
    (lambda step: (90.5, 30), "input too large", "clip", 0),
    (late, "exception", "IndexError", 50),
    (forgets_none, "not seen yet", "seen", 0),
    (forgets_return, "not seen yet", "None", 0),
    (lambda: (1, 1), "wrong callback", "step", None),
]


def test_faults_are_told_with_their_step(hurried):
    for control, kind, words, k in FAULTS:
        (problem,) = check_controller(lambda one=control: one, budget=PATIENT).problems
        assert (problem.kind, problem.k) == (kind, k)
        assert words in problem.sentence
        assert problem.line is not None


def test_what_is_no_illness_is_a_remark(hurried):
    def control(step):
        print(step.k)
        return 0.1, 0.1

    report = check_controller(lambda: control, budget=PATIENT)
    assert report.ok
    assert ["open loop" in remark for remark in report.remarks] == [True, False]
    assert "it prints, first '0'" in report.remarks[1]


def test_an_estimate_that_is_not_there(hurried):
    def control(step):
        return step.estimate.pose[:2] / 1e4

    check_controller(lambda: control, budget=PATIENT).raise_for_problems()
    (problem,) = check_controller(lambda: control, has_estimate=False).problems
    assert "there is no state estimator" in problem.sentence


def test_a_controller_in_place_of_its_maker():
    (problem,) = check_controller(robsim.GoToPoint(1, 2)).problems
    assert "which is a controller" in problem.sentence
    with pytest.raises(TypeError, match="make"):
        check_controller(5)
