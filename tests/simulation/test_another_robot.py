"""Another robot, or other colours, in the middle of a run."""

from dataclasses import replace

import numpy as np
import pytest

import robsim
from robsim.gui.panels.record import SavedRecord
from robsim.simulation import Experiment


def simulation(**options):
    given = {"robot": "lab", "measure": True, "control": robsim.DriveAround(), "seed": 3}
    return robsim.Simulation(**given | {"resolution": (600, 600)} | options)


def picture(sim, k):
    return sim.render_step(k).image.copy()


@pytest.mark.long
@pytest.mark.parametrize("camera_delay", [0, 2])
def test_the_next_step_shows_the_new_robot_and_earlier_ones_the_old(camera_delay):
    sim = simulation(headings=None, camera_delay=camera_delay, noise=robsim.GaussianNoise(5))
    sim.run(10)
    before = [picture(sim, k) for k in (4, 9)]
    sim.robot = "sheep"
    np.testing.assert_array_equal(picture(sim, 9), before[1])
    sim.run(10)
    for k, image in zip((4, 9), before, strict=True):
        np.testing.assert_array_equal(picture(sim, k), image)
    noise = robsim.GaussianNoise(5)
    sheep = simulation(robot="sheep", headings=None, camera_delay=camera_delay, noise=noise)
    sheep.run(20)
    np.testing.assert_array_equal(picture(sim, 15), picture(sheep, 15))
    sim.robot = "robot2"
    np.testing.assert_array_equal(picture(sim, 15), picture(sheep, 15))
    np.testing.assert_array_equal(picture(sim, 4), before[0])


def test_it_is_measured_by_its_own_markers():
    sim = simulation()
    sim.run(5)
    kept = sim.last_step
    sim.robot = "sheep"
    assert kept.markers == robsim.load_robot("lab").marker_layout()
    assert sim.markers == robsim.load_robot("sheep").marker_layout()
    trace = sim.run(10)
    assert trace.seen.all()
    assert sim.last_step.markers == sim.markers
    assert trace.info.robot == "sheep"
    assert trace.info.changed == ("robot",)
    assert sim.scenario.robot.name == "sheep"


def test_markers_that_were_given_stay():
    mine = robsim.load_robot("robot2").marker_layout()
    sim = simulation(markers=mine)
    sim.robot = "sheep"
    assert sim.markers == mine
    experiment = Experiment([], markers=mine, area=(99, 99))
    experiment.robot = "sheep"
    assert experiment.markers == mine


def test_between_two_stages_the_step_goes_on_with_the_old_one():
    sim = simulation(headings=None)
    sim.run(3)
    while sim.stage != "measure":
        sim.step_stage()
    other = simulation(headings=None)
    other.run(4)
    sim.robot = "sheep"
    sim.run(2)
    np.testing.assert_array_equal(sim.trace.pose_measured[3], other.trace.pose_measured[3])
    np.testing.assert_array_equal(picture(sim, 3), picture(other, 3))


def test_before_the_first_step_and_before_a_reset_it_is_the_robot_of_the_run():
    expected = simulation(robot="sheep").run(5).pose_measured
    sim = simulation()
    for robot in ("robot2", "sheep"):
        sim.robot = robot
        sim.reset()
    for _ in range(2):
        trace = sim.run(5)
        assert trace.info.changed == ()
        np.testing.assert_array_equal(trace.pose_measured, expected)
        sim.robot = "lab"
        sim.robot = "sheep"
        sim.reset()


def test_other_colours_are_looked_for_from_the_next_step_on():
    sim = simulation()
    sim.run(3)
    used = sim.colors
    narrow = robsim.ColorClass("red", y=(0, 1), u=(0, 1), v=(0, 1))
    sim.colors = (narrow, *(color for color in used if color.name != "red"))
    assert not sim.step().measurement
    assert sim.colors[0] == narrow
    sim.colors = used
    assert sim.step().measurement
    assert sim.trace.info.changed == ("colors",)


def test_other_names_of_colours_get_columns_of_their_own():
    sim = simulation()
    sim.run(3)
    green = robsim.ColorClass("green", y=(0, 255), u=(0, 110), v=(0, 110))
    sim.colors = (*sim.colors, green)
    trace = sim.run(3)
    red, blue = trace.blobs["red"], trace.blobs["blue"]
    assert np.isfinite(red[:, 0]).all()
    assert np.isfinite(blue[:, 0]).all()
    assert np.isnan(trace.blobs["green"][:3]).all()
    np.testing.assert_array_equal(red, simulation().run(6).blobs["red"])


def test_a_robot_too_large_to_bounce_is_refused_and_nothing_changes():
    sim = simulation(area=(250, 250))
    sim.run(3)
    image = picture(sim, 2)
    lab = robsim.load_robot("lab")
    large = replace(lab, size=400)
    with pytest.raises(ValueError, match="area"):
        sim.robot = large
    assert sim.robot.name == "lab"
    np.testing.assert_array_equal(picture(sim, 2), image)
    assert sim.run(3).info.changed == ()


def test_an_experiment_looks_for_the_new_robot(tmp_path):
    frames = [simulation(robot="sheep", seed=seed).step().frame for seed in (1, 2)]
    experiment = Experiment(frames, robot="lab")
    experiment.robot = "sheep"
    assert experiment.step().measurement
    recorded = Experiment(frames, robot="sheep", record=tmp_path / "session")
    with recorded:
        recorded.robot = "sheep"
        recorded.step()
        with pytest.raises(RuntimeError, match="colors cannot be changed while a session"):
            recorded.colors = recorded.colors


def test_a_saved_run_says_that_its_pictures_show_the_last_one():
    sim = simulation()
    sim.run(3)
    sim.robot = "sheep"
    assert "sheep" in SavedRecord(sim.run(3)).remarks[0]
