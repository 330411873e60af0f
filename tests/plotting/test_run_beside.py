"""The picture of a run: errors, goals, words."""

import io

import numpy as np
import pytest
from PIL import Image

import robsim
from robsim.plotting._runs.beside import as_png, draw_run
from robsim.plotting._runs.errors import RunError, distance, run_errors


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
    errors = run_errors(estimated, None, ("estimate_state",), None)
    off = np.hypot(*(estimated.pose_true[:, :2] - 600.0).T)
    assert [error.unit for error in errors] == ["px", "deg"]
    assert errors[0].yours == pytest.approx(off)
    figure, caption = draw_run(estimated, None, slots=("estimate_state",))
    assert f"at most {off.max():.1f} px, in step {int(off.argmax())}" in caption
    assert len(figure.axes) == 3
    image = Image.open(io.BytesIO(as_png(figure)))
    assert image.size == (900, 370)


@pytest.mark.long
def test_no_error_is_told_of_steps_that_are_not_scored(estimated):
    off = np.array([9.0, 1.0, 2.0, np.nan, 3.0, 2.0])
    assert RunError("off", "px", "estimate", off, None).worst == 0
    assert RunError("off", "px", "estimate", off, None, unscored=2).worst == 4
    ended_before = RunError("off", "px", "estimate", off[:2], None, unscored=2)
    assert ended_before.sentence(0) == "off: at most 9.0 px, in step 0"
    figure, _ = draw_run(estimated, None, slots=("estimate_state",), unscored=5)
    assert "not scored" in [text.get_text() for text in figure.legends[0].get_texts()]
    off = np.hypot(*(estimated.pose_true[:, :2] - 600.0).T)
    assert figure.axes[1].get_ylim() == pytest.approx((0, 1.15 * off[5:].max()))
    early, _ = draw_run(estimated[:4], estimated, slots=("estimate_state",), unscored=5)
    assert as_png(early)  # it has ended before the first step that counts
    assert early.axes[1].get_ylim()[1] > off.max()


def test_measurements_are_compared_with_the_reference(estimated):
    error, _ = run_errors(estimated, estimated, ("measure",), None)
    assert np.array_equal(error.yours, error.reference, equal_nan=True)
    assert np.isnan(error.yours).any()
    figure, caption = draw_run(estimated, estimated, slots=("measure",), asked={"px": 2.0})
    assert "where the reference has" in caption
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"reference", "robot hidden", "asked on average", "this run"} <= set(labels)


def test_a_drive_is_told_by_its_end(driven):
    short, reference, goal = driven
    errors = run_errors(short, reference, ("control",), np.array(goal))
    assert errors[0].yours[-1] == pytest.approx(np.hypot(*(short.pose_true[-1, :2] - goal[:2])))
    assert errors[0].worst == 19
    _, caption = draw_run(short, reference, slots=("control",), goals=goal)
    assert caption.startswith("Distance from the goal: at the end ")
    assert caption.endswith("The run ended at step 19 of 39.")


def test_a_path_is_its_lines(driven):
    short, reference, _ = driven
    path = [(300, 300), (500, 300), (500, 600)]
    figure, caption = draw_run(short, reference, slots=("control",), goals=path)
    assert "Distance from the path: at most" in caption
    assert len(figure.axes) == 2


def test_parameters_are_told_by_their_end():
    trace = robsim.Simulation(
        resolution=(300, 300), control=robsim.DriveAround(), estimate_parameters=True, seed=5
    ).run(40)
    (error,) = run_errors(trace, trace, ("init_parameter_estimator",), None)
    assert error.unit == "%"
    assert error.worst == 39
    assert error.yours[-1] < 1e-3
    assert "at the end 0.0 %" in draw_run(trace, None, slots=("estimate_parameters",))[1]


def test_without_a_goal_there_is_the_path_alone(driven):
    figure, caption = draw_run(driven[0], None, slots=("control",))
    assert caption == "The path."
    assert len(figure.axes) == 2


def test_a_run_without_steps_is_refused(driven):
    with pytest.raises(ValueError, match="must have steps"):
        draw_run(driven[0][:0], None, slots=("control",))


def test_distance_from_a_goal_or_a_path():
    positions = np.array([[0.0, 0.0], [3.0, 4.0]])
    for goals, expected in (
        ([3.0, 4.0], [5.0, 0.0]),
        ([3.0, 4.0, 1.0], [5.0, 0.0]),
        ([[3.0, 4.0]], [5.0, 0.0]),
        ([[0.0, 4.0], [9.0, 4.0]], [4.0, 0.0]),
        ([[1.0, 0.0], [2.0, 0.0], [2.0, 4.0]], [1.0, 1.0]),
        ([[1.0, 0.0], [1.0, 0.0]], [1.0, np.hypot(2, 4)]),
    ):
        assert distance(positions, np.array(goals)) == pytest.approx(expected)
