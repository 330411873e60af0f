"""Both sides of the comparison draw the same robot, in a new place at each call."""

import numpy as np
import pytest

from robsim.bench import _render as render

cv2 = pytest.importorskip("cv2")


@pytest.mark.long
def test_both_draw_the_same_moving_robot():
    calls = render.render_calls(cv2, 480)
    assert set(calls) == {"ours", "opencv"}
    ours = [calls["ours"]().astype(int).copy() for _ in range(3)]
    theirs = [calls["opencv"]().astype(int).copy() for _ in range(3)]
    for mine, other in zip(ours, theirs, strict=True):
        assert mine.shape == (480, 480, 3)
        assert np.abs(mine - other).max() <= render.MAXIMUM_DIFFERENCE
    assert np.abs(ours[0] - ours[1]).max() > 50
    assert np.abs(ours[1] - ours[2]).max() > 50


def test_robots_that_differ_are_no_comparison(monkeypatch):
    turn = render._rotation_matrix

    def turned_too_far(angle, centre, place):
        return turn(angle + 0.1, centre, place)

    monkeypatch.setattr(render, "_rotation_matrix", turned_too_far)
    with pytest.raises(RuntimeError, match="same robot"):
        render.render_calls(cv2, 480)
