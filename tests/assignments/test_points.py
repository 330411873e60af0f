"""Points: they add up as they are shown, and only all are all."""

import pytest

from graded_results import graded, submission
from robsim.assignments._reports.points import (
    fraction_of,
    most_in_all,
    number,
    of_most,
    points_in_all,
    points_of,
)


@pytest.mark.parametrize(
    ("points", "most", "shown"),
    [
        (4.0, 4.0, 4.0),
        (0.0, 4.0, 0.0),
        (3.9999, 4.0, 3.99),
        (0.0001, 4.0, 0.01),
        (10 / 3, 4.0, 3.33),
        (2.675, 4.0, 2.67),
        (1 / 3, 1 / 3, 1 / 3),
    ],
)
def test_only_all_are_all_and_only_none_are_none(points, most, shown):
    assert points_of(graded(points=points, most=most)) == pytest.approx(shown, abs=1e-12)


def test_what_is_shown_adds_up():
    thirds = [graded(str(i), points=4 / 3, most=2.0) for i in range(3)]
    result = submission(tests=thirds)
    assert [points_of(test) for test in thirds] == [1.33] * 3
    assert points_in_all(result) == 3.99
    assert most_in_all(result) == 6.0


def test_points_are_read_without_zeros_at_the_end():
    assert [number(x) for x in (4.0, 2.5, 0.05, 10.0, 0.0)] == ["4", "2.5", "0.05", "10", "0"]
    assert of_most(0.5, 1.0) == "0.5 of 1 point"
    assert of_most(2.0, 4.0) == "2 of 4 points"
    assert [fraction_of(1, 4), fraction_of(4, 4), fraction_of(0, 0)] == [0.25, 1.0, 1.0]
