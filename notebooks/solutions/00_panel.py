"""The answers of the notebook 00_panel, and mistakes that students make."""

import numpy as np

from robsim.teach.exercises.exercise import exercise


def limited(turn):
    return max(-0.2, min(0.2, turn))


@exercise(
    cases=lambda rng: (rng.choice((0.0, rng.uniform(-3, 3))),),
    hint="First compute the turn and limit it. Which wheel is faster on the way to the right?",
    mistakes={
        "The robot turns left for a goal on its right: exchange the wheels.": (
            lambda angle: (0.3 - limited(0.2 * angle), 0.3 + limited(0.2 * angle))
        ),
        "The turn has no limit: it is at most 0.2 V, in both directions.": (
            lambda angle: (0.3 + 0.2 * angle, 0.3 - 0.2 * angle)
        ),
        "The limit holds for turns to the left, too: not below -0.2 V.": (
            lambda angle: (0.3 + min(0.2, 0.2 * angle), 0.3 - min(0.2, 0.2 * angle))
        ),
        "Limit the turn, not the angle: the turn is 0.2 V per rad.": (
            lambda angle: (0.3 + limited(angle), 0.3 - limited(angle))
        ),
        "One wheel gets the turn, the other none: one becomes faster, the other slower.": (
            lambda angle: (0.3 + limited(0.2 * angle), 0.3)
        ),
    },
)
def motors(angle):
    """Return the voltages (left, right) for a goal at an angle (rad), positive to the right."""
    turn = max(-0.2, min(0.2, 0.2 * angle))
    return 0.3 + turn, 0.3 - turn


def some_steps(rng):
    """Return few enough steps to be shown; always seen, or not seen at the ends, in some cases."""
    seen = (rng.random(6) > 0.4).astype(int)
    if rng.random() < 0.5:
        seen[: rng.integers(3)] = seen[6 - rng.integers(3) :] = 0
    return (np.ones(6, int) if rng.random() < 0.1 else seen,)


def inner(seen):
    """Return the longest gap that ends before the last step."""
    return max(gaps(np.append(np.trim_zeros(seen, "b"), 1)))


def gaps(seen):
    """Return the lengths of all gaps."""
    texts = "".join(str(int(one)) for one in seen).split("1")
    return [len(text) for text in texts if text] or [0]


@exercise(
    cases=some_steps,
    hint="Count up at each step unseen, and begin again at each step seen. What do you keep?",
    mistakes={
        "This counts all steps unseen: return the longest gap.": (
            lambda seen: int((seen == 0).sum())
        ),
        "This is the last gap: keep the largest count so far.": lambda seen: gaps(seen)[-1],
        "This is the longest row in which it was seen.": lambda seen: max(gaps(1 - seen)),
        "A gap may last to the end: compare it there, too.": inner,
        "This is the number of gaps, not the length of one.": lambda seen: len(gaps(seen)),
        "This is one step too many.": lambda seen: max(gaps(seen)) + 1,
    },
)
def longest_gap(seen):
    """Return the largest number of steps in a row in which the robot was not seen."""
    longest = count = 0
    for one in seen:
        count = 0 if one else count + 1
        longest = max(longest, count)
    return longest
