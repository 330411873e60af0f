"""Colours judged by the mean of a window: what finds the robot in noise."""

import numpy as np
import pytest

import robsim


@pytest.mark.parametrize("window", [0, 2, 4, 17, -3])
def test_other_windows_are_refused(window):
    image = np.zeros((20, 20, 3), np.uint8)
    with pytest.raises(ValueError, match="smoothing must be"):
        robsim.find_blobs(image, robsim.load_colors(), smoothing=window)
    with pytest.raises(ValueError, match="smoothing must"):
        robsim.Simulation(smoothing=window).run(1)


@pytest.mark.parametrize("noise", ["uniform", "gaussian"])
def test_the_robot_is_found_in_noise_of_40_percent(noise):
    # Noise that is clipped at black and white takes contrast away: limits nearer to neutral, 128.
    colors = [robsim.ColorClass("red", v=(156, 255)), robsim.ColorClass("blue", u=(156, 255))]
    sim = robsim.Simulation(
        robot="lab",
        rotation="continuous",
        noise=noise,
        noise_percent=40,
        measure=True,
        smoothing=7,
        colors=colors,
        control=robsim.DriveAround(),
        seed=4,
    )
    tracking = sim.run(200).tracking()
    print(tracking)
    assert tracking.valid >= 199
    assert tracking.false == 0
    assert tracking.rms_xy < 0.7
    assert tracking.rms_heading_deg < 1.3
