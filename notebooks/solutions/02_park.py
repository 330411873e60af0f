"""The answers of the notebook 02_park, and mistakes that students make."""

import math

import robsim
from robsim.teach.exercises.exercise import exercise


def pose_and_goal(rng):
    return rng.uniform((0, 0, -3.1), (1200, 1200, 3.1)), rng.uniform(0, 1200, 2)


def without_wrap(pose, goal):
    return math.atan2(goal[1] - pose[1], goal[0] - pose[0]) - pose[2]


@exercise(
    cases=pose_and_goal,
    hint="Which angle points to the goal, and which one ahead? Then compare both.",
    mistakes={
        "The angle leaves the interval from -pi to pi: wrap it with robsim.wrap_angle.": (
            without_wrap
        ),
        "Left and right are exchanged: in an image, y points down, and angles grow clockwise.": (
            lambda pose, goal: -robsim.wrap_angle(without_wrap(pose, goal))
        ),
        "This points from the goal to the robot: take goal minus position.": (
            lambda pose, goal: robsim.wrap_angle(without_wrap(pose, goal) + math.pi)
        ),
        "math.atan2 takes dy first, then dx.": lambda pose, goal: robsim.wrap_angle(
            math.atan2(goal[0] - pose[0], goal[1] - pose[1]) - pose[2]
        ),
        "y points down in the image already: do not change its sign.": (
            lambda pose, goal: robsim.wrap_angle(
                math.atan2(pose[1] - goal[1], goal[0] - pose[0]) - pose[2]
            )
        ),
        "Angles from -pi to pi, not from 0 to 2 pi.": (
            lambda pose, goal: without_wrap(pose, goal) % (2 * math.pi)
        ),
        "It is in degrees, and must be in radians.": lambda pose, goal: math.degrees(
            robsim.wrap_angle(without_wrap(pose, goal))
        ),
        "This is the direction to the goal in the image: subtract the robot's heading.": (
            lambda pose, goal: math.atan2(goal[1] - pose[1], goal[0] - pose[0])
        ),
    },
)
def to_the_right(pose, goal):
    """Return the angle from the heading to the goal (rad), positive to the right."""
    x, y, heading = pose
    return robsim.wrap_angle(math.atan2(goal[1] - y, goal[0] - x) - heading)


@exercise(
    cases=lambda rng: (rng.uniform(-0.5, 1), rng.uniform(-0.4, 0.4)),
    hint="Which wheel must be faster on the way to the right? Look at the picture of the axes.",
    mistakes={
        "The robot turns left for a positive turn: exchange the wheels.": (
            lambda drive, turn: (drive - turn, drive + turn)
        ),
        "Each wheel gets half of the turn: it must get all of it.": (
            lambda drive, turn: (drive + turn / 2, drive - turn / 2)
        ),
        "One wheel gets the turn, the other none: one becomes faster, the other slower.": (
            lambda drive, turn: (drive + turn, drive)
        ),
        "The drive is the same for both wheels: the turn alone is not enough.": (
            lambda drive, turn: (turn, -turn)
        ),
        "Both wheels get the same voltage, so the robot does not turn.": (
            lambda drive, turn: (drive + turn, drive + turn)
        ),
    },
)
def voltages(drive, turn):
    """Return the voltages (left, right) for a drive ahead and a turn to the right (V)."""
    return drive + turn, drive - turn


@exercise(
    cases=lambda rng: (rng.uniform(0, 400), rng.uniform(-3, 3)),
    hint="Compute the drive without the angle first. Which factor is 1 ahead, 0 aside, -1 behind?",
    mistakes={
        "The drive has no limit: at most 0.5 V.": (
            lambda distance, error: 0.004 * distance * math.cos(error)
        ),
        "The robot drives ahead even if the goal is behind it: multiply by the cosine.": (
            lambda distance, error: min(0.5, 0.004 * distance)
        ),
        "The limit comes last, so that the cosine changes nothing far from the goal: limit first, "
        "then multiply by the cosine.": lambda distance, error: min(
            0.5, 0.004 * distance * math.cos(error)
        ),
        "At most 0.5 V is min, not max.": (
            lambda distance, error: max(0.5, 0.004 * distance) * math.cos(error)
        ),
        "Behind the robot the drive is negative: it drives backwards.": (
            lambda distance, error: min(0.5, 0.004 * distance) * abs(math.cos(error))
        ),
        "The cosine takes radians, and the error is in radians already.": (
            lambda distance, error: min(0.5, 0.004 * distance) * math.cos(math.radians(error))
        ),
    },
)
def drive_ahead(distance, error):
    """Return the drive (V): 0.004 V/px, at most 0.5 V, times the cosine of the heading error."""
    return min(0.5, 0.004 * distance) * math.cos(error)
