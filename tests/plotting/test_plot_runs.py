"""Several runs in one figure."""

import numpy as np
import pytest

import robsim
from robsim.plotting import plot_runs


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
