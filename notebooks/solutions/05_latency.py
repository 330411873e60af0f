"""The answers of the notebook 05_latency, and mistakes that students make."""

import robsim
from robsim.teach.exercises.exercise import exercise

MODEL = robsim.RobotModel()


def late_inputs(rng):
    return rng.uniform(-1, 1, (12, 2)), 8, rng.integers(0, 4) + rng.uniform(0.1, 0.4)


def mean_of(u, newer, older, part):
    """Return the mean of two inputs, `part` of it the older one."""
    return (1 - part) * u[newer] + part * u[older]


@exercise(
    cases=late_inputs,
    hint="Split the delay into whole steps and the rest. Which two inputs act, and for how long?",
    mistakes={
        "The weights are exchanged: with a delay of 2.4, the older input acts for 0.4 of a step.": (
            lambda u, k, delay: mean_of(
                u, k - int(delay), k - int(delay) - 1, 1 - (delay - int(delay))
            )
        ),
        "This rounds the delay: it need not be whole.": lambda u, k, delay: u[k - round(delay)],
        "The other input is the previous one, not the next.": lambda u, k, delay: mean_of(
            u, k - int(delay), k - int(delay) + 1, delay - int(delay)
        ),
        "This is the plain mean of both inputs: weigh them by their times.": (
            lambda u, k, delay: mean_of(u, k - int(delay), k - int(delay) - 1, 0.5)
        ),
    },
)
def acting_input(u, k, delay):
    """Return the mean input (2,) that acts from step k to k + 1, `delay` steps late."""
    whole = int(delay)
    part = delay - whole
    return (1 - part) * u[k - whole] + part * u[k - whole - 1]


def poses_and_inputs(rng):
    pose = rng.uniform((200, 200, -1), (900, 900, 1))
    return pose, pose - rng.uniform(-1, 1, 3) * (5, 5, 0.1), rng.uniform(-1, 1, (4, 2))


def never_before(pose, pose_before, inputs):
    for u in inputs:
        pose = MODEL.predict(pose, pose_before, u)
    return pose


def overwritten(pose, pose_before, inputs):
    for u in inputs:
        pose = pose_before = MODEL.predict(pose, pose_before, u)
    return pose


def exchanged(pose, pose_before, inputs):
    for u in inputs:
        pose, pose_before = MODEL.predict(pose_before, pose, u), pose
    return pose


def backwards(pose, pose_before, inputs):
    return pose_ahead.right(pose, pose_before, inputs[::-1])


@exercise(
    cases=poses_and_inputs,
    tolerance=1e-6,
    hint="Which pose is the previous one after a step? Both arguments change from step to step.",
    mistakes={
        "The previous pose stays the same in your loop: it must follow.": never_before,
        "The pose is overwritten before it becomes the previous one.": overwritten,
        "The model gets the last pose first, then the previous one.": exchanged,
        "The inputs come in the order in which they act: begin with the first.": backwards,
        "This is one step: repeat it for each of the inputs.": (
            lambda pose, pose_before, inputs: MODEL.predict(pose, pose_before, inputs[0])
        ),
    },
)
def pose_ahead(pose, pose_before, inputs):
    """Return the pose (3,) after all inputs (N, 2); each input acts for one step."""
    for u in inputs:
        pose, pose_before = MODEL.predict(pose, pose_before, u), pose
    return pose
