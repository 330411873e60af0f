"""What the doctor says of measurements, models and backgrounds."""

import math

import numpy as np
import pytest

import robsim
from robsim.teach import check_background, check_measurement, check_model, check_motion

pytestmark = pytest.mark.long


def located(step):
    return robsim.locate(step.blobs, step.markers, step.frame.plane_map)


def pose_of(red, blue, markers):
    right = np.subtract(red, blue) / np.linalg.norm(np.subtract(red, blue))
    forward = np.array((right[1], -right[0]))
    x, y = np.add(red, blue) / 2 + markers.offset * forward
    return robsim.Measurement((x, y, math.atan2(forward[1], forward[0])))


def pairs(step, to_world):
    for red in step.blobs["red"]:
        for blue in step.blobs["blue"]:
            one, other = to_world(red.centroid), to_world(blue.centroid)
            off = np.linalg.norm(np.subtract(one, other)) / step.markers.distance - 1
            if abs(off) < 0.12:
                return pose_of(one, other, step.markers)
    return None


def by_blobs(step):
    return pairs(step, step.frame.plane_map.to_world)


class Tracker:
    """Looks near the last pose first, and everywhere if it is not there."""

    def __init__(self):
        self.last = None

    def __call__(self, step):
        near = {
            name: [b for b in found if self.last is None or math.dist(b.centroid, self.last) < 90]
            for name, found in step.blobs.items()
        }
        seen = robsim.locate(near, step.markers, step.frame.plane_map) or located(step)
        self.last = None if seen is None else step.frame.plane_map.to_pixel(seen.pose[:2])
        return seen


RIGHT = {
    "robsim's own": lambda: located,
    "blobs": lambda: by_blobs,
    "near the last pose": Tracker,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", RIGHT)
def test_right_measurements_are_well(name):
    report = check_measurement(RIGHT[name], budget=60).raise_for_problems()
    errors = report.to_dict()["errors"]
    assert errors["turned"]["seen"] == errors["turned"]["frames"]
    assert errors["turned"]["distance"] < 1.0


def changed(change, unseen=None):
    def measure(step):
        seen = located(step)
        return unseen if seen is None else robsim.Measurement(change(*seen.pose))

    return lambda: measure


def keeps_last():
    last = None

    def measure(step):
        nonlocal last
        last = located(step) or last
        return last

    return measure


def largest(step):
    return pose_of(step.blobs["red"][0].centroid, step.blobs["blue"][0].centroid, step.markers)


def in_pixels(step):
    scale = step.frame.image.shape[1] / 1200
    near = pairs(step, lambda centroid: np.divide(centroid, scale))
    return near and (near.pose[0] * scale, near.pose[1] * scale, near.pose[2])


# The measurement and the kinds of its problems.
WRONG = [
    (changed(lambda x, y, h: (x, y, math.degrees(h))), ["heading in degrees"]),
    (changed(lambda x, y, h: (x, 1199 - y, -h)), ["y axis", "heading anticlockwise"]),
    (changed(lambda x, y, h: (x, y, math.atan(math.tan(h)))), ["heading reversed at times"]),
    (changed(lambda x, y, h: (x + 50, y, h)), ["false poses"]),
    (changed(lambda x, y, h: (x, y, h + math.pi)), ["heading reversed"]),
    (changed(lambda x, y, h: (x, y, h - math.pi / 2)), ["heading turned"]),
    (changed(lambda x, y, h: (x, y, math.pi / 2 - h)), ["swapped arguments"]),
    (changed(lambda x, y, h: (x, y, 0.3)), ["heading constant"]),
    (changed(lambda x, y, h: (y, x, h)), ["x and y exchanged"]),
    (changed(lambda x, y, h: (1199 - x, y, h)), ["x axis"]),
    (keeps_last, ["last pose"]),
    (lambda: largest, ["fails unseen", "red square", "pixels of the frame"]),
    (lambda: in_pixels, ["pixels of the frame"]),
    (lambda: lambda step: None, ["not seen"]),
    (changed(lambda x, y, h: (x, y, h), (math.nan,) * 3), ["fails unseen"]),
]


@pytest.mark.slow
@pytest.mark.parametrize(("make", "kinds"), WRONG)
def test_wrong_measurements_are_told(make, kinds, request):
    if "pixels of the frame" not in kinds:
        request.getfixturevalue("small_frames")
    assert [problem.kind for problem in check_measurement(make, budget=60).problems] == kinds


def stating(change, every=1):
    """robsim's own measurement with another covariance; None in the other steps."""

    def measure(step):
        seen = robsim.locate(step.blobs, step.markers, image=step.frame)
        if seen is None or step.k % every:
            return seen and robsim.Measurement(seen.pose)
        return robsim.Measurement(seen.pose, covariance=change(seen.covariance))

    return lambda: measure


def singular(covariance):
    deviation = np.sqrt(np.diag(covariance))
    return np.outer(deviation, deviation)


def in_degrees(covariance):
    unit = np.array((1, 1, np.rad2deg(1)))
    return covariance * np.outer(unit, unit)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "verdict", "kinds", "remark"),
    [
        (lambda P: P, "consistent", [], None),
        (lambda P: P / 3, "optimistic", [], "1.7 times"),
        (lambda P: P / 16, "optimistic", ["optimistic"], None),
        (lambda P: 9 * P, "conservative", [], "0.32 times"),
        (in_degrees, "consistent", [], "heading"),
        (singular, None, ["covariance not positive"], None),
    ],
)
def test_covariances_are_judged_by_the_errors(change, verdict, kinds, remark):
    report = check_measurement(stating(change), budget=60)
    assert [problem.kind for problem in report.problems] == kinds
    assert [remark in text for text in report.remarks] == ([] if remark is None else [True])
    if verdict is not None:
        row = report.to_dict()["covariances"]["noise"]
        assert (row["count"], row["verdict"]) == (30, verdict)


@pytest.mark.slow
def test_missing_covariances_are_told():
    (remark,) = check_measurement(stating(lambda P: P, every=2)).remarks
    assert "15 of its 30 measurements" in remark


def writes(step):
    step.frame.image[:10] = 0


def test_faults_of_the_first_frame():
    for measure, words in (
        (lambda step: (1, 2), "(1, 2)"),
        (lambda step: step.frame.image.mean(), "pose"),
        (lambda step: step.blob, "a Step has blobs"),
        (writes, "read-only"),
    ):
        (problem,) = check_measurement(lambda one=measure: one, budget=60).problems
        assert words in problem.sentence
        assert problem.k == 0


def check_kinds(check, cases):
    for callback, kinds in cases:
        report = check(lambda one=callback: one)
        assert [problem.kind for problem in report.problems] == kinds


MODELS = [
    (lambda: robsim.RobotModel(robsim.RobotParameters()), []),
    (lambda: robsim.RobotParameters(), ["output type"]),
    (lambda: None, ["output type"]),
    (
        lambda: robsim.RobotModel(robsim.RobotParameters(motor_gain=(-0.05, -0.05))),
        ["drives backwards", "left and right exchanged"],
    ),
    (
        lambda: robsim.RobotModel(
            robsim.RobotParameters(mass=np.random.default_rng().uniform(0.2, 0.4))
        ),
        ["not reproducible"],
    ),
]


def test_models():
    check_kinds(check_model, MODELS)


def test_a_model_of_implausible_units_is_worth_a_remark():
    model = robsim.RobotModel(robsim.RobotParameters(mass=300.0))
    (remark,) = check_model(lambda: lambda: model).remarks
    assert "px/s" in remark


def unicycle(sign_y=1, sign_turn=1):
    def move(world):
        x, y, heading = world.pose_1
        left, right = world.last_u
        way = 10 * (left + right) * world.dt
        turn = 0.2 * sign_turn * (left - right)
        return x + way * math.cos(heading), y + sign_y * way * math.sin(heading), heading + turn

    return move


MOTIONS = [
    (lambda world: world.model.predict(world.pose_1, world.pose_2, world.last_u), []),
    (robsim.Unicycle(), []),
    (unicycle(), []),
    (unicycle(sign_y=-1), ["drives another way"]),
    (unicycle(sign_turn=-1), ["left and right exchanged"]),
    (lambda world: world.pose_1[:2], ["output shape"]),
    (lambda world: world.pose_1 * math.inf, ["not finite"]),
    (lambda world: world.pose1, ["exception"]),
    (lambda world, u: world.pose_1, ["wrong callback"]),
]


def test_motions():
    check_kinds(check_motion, MOTIONS)


BACKGROUNDS = [
    (lambda background: background, []),
    (lambda background: None, ["output type"]),
    (lambda background: background / 255, ["output type"]),
    (lambda background: background[::2], ["output shape"]),
]


def test_backgrounds():
    check_kinds(check_background, BACKGROUNDS)
