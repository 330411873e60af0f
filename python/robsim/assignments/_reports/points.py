"""Points as people read them, and as they add up."""

from __future__ import annotations

from robsim.assignments._results import SubmissionResult, TestResult


def points_of(test: TestResult) -> float:
    """Return the points of a test in hundredths: only all are all, and only none are none."""
    if test.points >= test.most:
        return test.most
    points = round(test.points, 2)
    if points >= test.most:
        points = round(points - 0.01, 2)
    elif points <= 0 < test.points:
        points = 0.01
    return min(max(points, 0.0), test.most)


def points_in_all(result: SubmissionResult) -> float:
    """Return the points of a submission: those of its tests, as they are shown, add up to it."""
    return round(sum(map(points_of, result.tests)), 2)


def most_in_all(result: SubmissionResult) -> float:
    """Return how many points there are for a submission."""
    return round(sum(test.most for test in result.tests), 2)


def fraction_of(points: float, most: float) -> float:
    """Return the share of the points, 0 to 1; all of none is all."""
    return 1.0 if points >= most else max(points / most, 0.0)


def number(points: float) -> str:
    """Return points as a number without zeros at its end."""
    return f"{points:.2f}".rstrip("0").rstrip(".")


def of_most(points: float, most: float) -> str:
    """Return points as a text such as ``"2.5 of 4 points"``."""
    return f"{number(points)} of {number(most)} {'point' if most == 1 else 'points'}"
