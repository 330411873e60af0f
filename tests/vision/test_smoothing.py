"""Colours judged by the mean of a window: what finds the robot in noise."""

import dataclasses

import pytest

import robsim
from sizes import thorough

# share of frames in which the robot is found; rms of the place (px) and the heading (degrees)
ASKED = {1200: (0.995, 0.7, 1.3), 480: (0.95, 2.0, 4.0)}


def check_the_default_measurement(noise, camera, *, steps, seed):
    sim = robsim.Simulation(
        robot="lab",
        resolution=(camera, camera),
        headings=None,
        noise=noise,
        measure=True,
        control=robsim.DriveAround(),
        seed=seed,
    )
    tracking = sim.run(steps).tracking()
    share, rmse_xy, rmse_heading_deg = ASKED[camera]
    assert tracking.seen >= share * steps
    assert tracking.false_poses == 0
    assert tracking.rmse_xy < rmse_xy
    assert tracking.rmse_heading_deg < rmse_heading_deg


@pytest.mark.long
@pytest.mark.parametrize("noise", [robsim.UniformNoise(40), robsim.GaussianNoise(40)])
@pytest.mark.parametrize("camera", ASKED)
def test_the_robot_is_found_in_noise_of_40_percent(noise, camera):
    # Of 1000 frames, a share of 0.5 % is known to 0.2 %.
    check_the_default_measurement(noise, camera, steps=thorough(1000, 150), seed=11)


@pytest.mark.long
@pytest.mark.parametrize("name", ["robot2", "sheep"])
def test_other_robots_are_found_in_strong_noise(name):
    options = {"headings": None, "noise": robsim.GaussianNoise(30)}
    sim = robsim.Simulation(robot=name, measure=True, seed=5, **options)
    tracking = sim.run(20).tracking()
    assert (tracking.seen, tracking.false_poses) == (20, 0)


def options_of(sim):
    sim.step()
    return sim._core.minimum_area, sim._core.maximum_count, sim._core.smoothing


def test_what_is_looked_for_comes_from_the_robot():
    # Markers of 531 px of the area: 23 px wide, at 480 px 9.2; an eighth of their area.
    lab = robsim.load_robot("lab")
    assert options_of(robsim.Simulation(robot=lab, measure=True)) == (66, 64, 7)
    assert options_of(robsim.Simulation(robot=lab, measure=True, resolution=(480, 480))) == (
        11,
        64,
        3,
    )
    few = dataclasses.replace(lab, maximum_blobs=3)
    assert options_of(robsim.Simulation(robot=few, measure=True, smoothing=1)) == (66, 3, 1)
    bare = robsim.vision.MarkerLayout(43, 14)  # knows no areas
    assert options_of(robsim.Simulation(markers=bare, measure=True)) == (12, 64, 1)


def test_find_blobs_takes_them_from_markers_too():
    sim = robsim.Simulation(robot="lab", resolution=(480, 480), noise=robsim.GaussianNoise(40))
    markers = robsim.load_robot("lab").marker_layout()
    found = robsim.find_blobs(sim.frame, sim.colors, markers=markers)
    assert found == robsim.find_blobs(sim.frame, sim.colors, minimum_area=11, smoothing=3)
    assert found == sim.find_blobs(sim.frame)
    # of an array nobody knows the scale: a pixel counts as one of the area
    plain = robsim.find_blobs(sim.frame.image, sim.colors, markers=markers)
    assert all(blob.area >= 66 for blob in plain["red"])
