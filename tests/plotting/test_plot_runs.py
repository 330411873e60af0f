"""Figures of runs and campaigns."""

import io

import numpy as np
import pytest
from PIL import Image

import robsim
from robsim.campaigns import campaign
from robsim.plotting import plot_campaign, plot_runs
from robsim.plotting.beside import as_png, draw_run

# --- several runs


@pytest.fixture(scope="module")
def driven():
    """A run to a goal, and a shorter one to elsewhere."""
    options = {"resolution": (300, 300), "measure": True, "start": (300, 300, 0.0), "seed": 5}
    near = robsim.Simulation(control=robsim.GoToPoint(500, 400), **options).run(30)
    return {"near": near, "far": robsim.Simulation(control=robsim.Spin(), **options).run(20)}


def labels(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def line(axes, label):
    (found,) = [one for one in axes.get_lines() if one.get_label() == label]
    return np.array(found.get_data())


def test_paths_and_distances_from_a_pose(driven):
    figure = plot_runs(driven, goals=(500, 400, 1.0))
    plan, distance, heading = figure.axes
    assert labels(figure) == ["goal", "near", "far"]
    assert np.array_equal(line(plan, "near"), driven["near"].pose_true[:, :2].T)
    k, off = line(distance, "far")
    assert np.array_equal(k, driven["far"].k)
    assert off == pytest.approx(np.hypot(*(driven["far"].pose_true[:, :2] - (500, 400)).T))
    assert distance.get_xlim() == (-0.5, 29.5)
    assert line(heading, "far")[1][0] == pytest.approx(np.rad2deg(1))


def test_a_path_begins_where_the_robot_stands(driven):
    figure = plot_runs(driven, goals=[(600, 300), (600, 600)])
    assert "waypoints" in labels(figure)
    off = line(figure.axes[1], "near")[1]
    assert off == pytest.approx(np.abs(driven["near"].pose_true[:, 1] - 300), abs=1e-9)


def test_without_goals_it_is_what_was_recorded(driven):
    figure = plot_runs(driven)
    assert figure.axes[1].get_title(loc="left") == "error of the measured position (px)"
    assert labels(figure) == ["true path", "near", "far"]
    figure = plot_runs({"one": driven["near"]}, slots="estimate_state")
    assert figure.axes[1].get_title(loc="left") == "error of the estimated position (px)"
    bare = robsim.Simulation(resolution=(300, 300), seed=1).run(5)
    (plan,) = plot_runs({"bare": bare}).axes
    assert plan.get_title() == "paths (circle: start)"


def test_traces_in_mm_are_drawn_in_px(driven):
    metric = driven["near"].in_unit("mm", mm_per_px=2.0)
    figure = plot_runs({"near": metric}, goals=(500, 400))
    assert line(figure.axes[0], "near") == pytest.approx(driven["near"].pose_true[:, :2].T)


def test_what_is_wrong_is_named(driven):
    eight = dict.fromkeys("abcdefgh", driven["near"])
    for runs, options, name in (
        ({}, {}, "runs"),
        (eight, {}, "runs"),
        (driven, {"goals": (1, 2, 3, 4)}, "goals"),
        (driven, {"goals": (1, np.nan)}, "goals"),
        (driven, {"slots": "contrl"}, "contrl"),
    ):
        with pytest.raises((TypeError, ValueError), match=name):
            plot_runs(runs, **options)


# --- a run beside its frame


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
def driven_to_goals():
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


def test_a_drive_is_told_by_its_end_or_its_distance_from_the_path(driven_to_goals):
    short, reference, goal = driven_to_goals
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


# --- campaigns


@pytest.fixture(scope="module")
def result():
    return campaign(
        robsim.Scenario(area=(300, 300), start="random"),
        vary={
            "motor_delay": {3: 3, 0: 0, 1.5: 1.5},
            "control": {"$fast": robsim.Spin(0.9), "slow": robsim.Spin(0.1)},
        },
        metrics={"x": lambda trace: trace.pose_true[-1, 2]},
        runs=8,
        steps=20,
        seed=1,
        progress=False,
    )


@pytest.mark.long
def test_bands_are_means_over_an_option_with_their_intervals(result):
    ax = plot_campaign(result, "x", over="motor_delay")
    table = result["x"].reshape(3, 2, 8)[[1, 2, 0]]  # by rising delay
    assert len(ax.lines) == 2
    for control, line in enumerate(ax.lines):
        assert line.get_xdata().tolist() == [0, 1.5, 3]
        np.testing.assert_allclose(line.get_ydata(), table[:, control].mean(axis=1))
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [r"\$fast", "slow"]
    half = result.summary(("motor_delay", "control")).half_width[2, 0]
    heights = np.ptp(ax.collections[0].get_paths()[0].vertices[:, 1])
    assert heights >= 2 * half
    ax.figure.canvas.draw()


def test_boxes_have_the_quartiles_of_each_case(result):
    ax = plot_campaign(result, "x")
    medians = [line for line in ax.lines if line.get_color() == "#1f5fe0"]
    expected = np.median(result["x"].reshape(6, 8), axis=1)
    np.testing.assert_allclose([line.get_ydata()[0] for line in medians], expected)
    assert [text.get_text() for text in ax.get_xticklabels()][1] == "3\nslow"
    ax.figure.canvas.draw()


def test_long_labels_do_not_cover_each_other():
    noise = [robsim.GaussianNoise(percent) for percent in (1, 2, 5, 10, 20)]
    result = campaign(
        robsim.Scenario(area=(300, 300), start="random"),
        vary={"noise": noise},
        metrics={"x": lambda trace: trace.pose_true[-1, 0]},
        runs=2,
        steps=2,
        progress=False,
    )
    labels = plot_campaign(result, "x").get_xticklabels()
    assert {label.get_rotation() for label in labels} == {30}


def test_failed_runs_leave_gaps():
    def fails(trace):
        raise ValueError

    nothing = campaign(metrics={"x": fails}, runs=2, steps=2, progress=False)
    with pytest.raises(ValueError, match="no numbers to draw: all runs failed"):
        plot_campaign(nothing, "x")


def test_what_cannot_be_drawn_is_refused(result):
    with pytest.raises(ValueError, match=r"\bmetric\b"):
        plot_campaign(result, "y")
    with pytest.raises(ValueError, match="control"):  # its values are no numbers
        plot_campaign(result, "x", over="control")
