"""The picture of a run: errors, goals, words."""

import io

import numpy as np
import pytest
from PIL import Image

import robsim
from robsim.plotting.beside import as_png, draw_run


def lost(step):
    """Estimate a pose of before, by a callback without a memory: the robot stays at its start."""
    return robsim.Estimate(np.array([600.0, 600.0, 0.0]), np.eye(3))


@pytest.fixture(scope="module")
def estimated():
    """A run of a bad estimator, and of what was measured."""
    options = {
        "resolution": (300, 300),
        "control": robsim.DriveAround(),
        "measure": True,
        "dropout": robsim.Dropout(0.3, steps=3),
        "seed": 5,
    }
    return robsim.Simulation(estimate_state=lost, **options).run(30)


@pytest.fixture(scope="module")
def driven():
    """A run to another place than the goal, one to the goal, and the goal."""
    options = {"resolution": (300, 300), "measure": True, "start": (300, 300, 0.0), "seed": 5}
    goal = (600.0, 500.0, 1.0)
    short = robsim.Simulation(control=robsim.GoToPoint(400, 700), **options).run(20)
    return short, robsim.Simulation(control=robsim.GoToPoint(600, 500), **options).run(40), goal


@pytest.mark.long
def test_the_error_of_an_estimate_is_drawn_and_told(estimated):
    off = np.hypot(*(estimated.pose_true[:, :2] - 600.0).T)
    figure, caption = draw_run(estimated, None, slots=("estimate_state",))
    assert f"at most {off.max():.1f} px, in step {int(off.argmax())}" in caption
    assert len(figure.axes) == 3
    assert Image.open(io.BytesIO(as_png(figure))).size == (900, 370)


@pytest.mark.long
def test_no_error_is_told_of_steps_that_are_not_scored(estimated):
    off = np.hypot(*(estimated.pose_true[:, :2] - 600.0).T)
    figure, caption = draw_run(estimated, None, slots=("estimate_state",), unscored=29)
    assert f"at most {off[29]:.1f} px, in step 29" in caption
    assert figure.axes[1].get_ylim() == pytest.approx((0, 1.15 * off[29]))
    early, _ = draw_run(estimated[:4], estimated, slots=("estimate_state",), unscored=5)
    assert as_png(early)  # it has ended before the first step that counts


def test_measurements_are_compared_with_the_reference(estimated):
    figure, caption = draw_run(estimated, estimated, slots=("measure",), asked={"px": 2.0})
    assert "where the reference has" in caption
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"reference", "robot hidden", "asked on average", "this run"} <= set(labels)


def test_a_drive_is_told_by_its_end_or_its_distance_from_the_path(driven):
    short, reference, goal = driven
    off = np.hypot(*(short.pose_true[-1, :2] - goal[:2]))
    _, caption = draw_run(short, reference, slots=("control",), goals=goal)
    assert caption.startswith(f"Distance from the goal: at the end {off:.1f} px")
    assert caption.endswith("The run ended at step 19 of 39.")
    for path, distances in (
        ([(300, 100), (300, 500)], np.abs(short.pose_true[:, 0] - 300)),
        ([(200, 300), (1100, 300), (1100, 900)], np.abs(short.pose_true[:, 1] - 300)),
    ):
        figure, caption = draw_run(short, reference, slots=("control",), goals=path)
        assert f"Distance from the path: at most {distances.max():.1f} px" in caption
    figure, caption = draw_run(short, None, slots=("control",))
    assert caption == "The path."
    assert len(figure.axes) == 2
    with pytest.raises(ValueError, match="must have steps"):
        draw_run(short[:0], None, slots=("control",))


def test_parameters_are_told_by_their_end():
    trace = robsim.Simulation(
        resolution=(300, 300), control=robsim.DriveAround(), estimate_parameters=True, seed=5
    ).run(40)
    assert "at the end 0.0 %" in draw_run(trace, None, slots=("estimate_parameters",))[1]
