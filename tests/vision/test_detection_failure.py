"""The sentence on why no frame showed the robot."""

import re

import numpy as np
import pytest

import robsim
from robsim.vision._detection_failure import explain_no_detection

SMALL = {"resolution": (600, 600), "measure": True, "seed": 1}


def reason(**options):
    sim = robsim.Simulation(**SMALL, **options)
    sim.run(3)
    return explain_no_detection(sim.trace, sim.markers)


def test_a_robot_that_was_seen_needs_no_reason():
    assert reason() is None
    assert (
        explain_no_detection(robsim.Simulation().run(2), robsim.load_robot("lab").marker_layout())
        is None
    )


def test_another_robot():
    wanted = r"the markers are 43\.0 px apart, but the red and blue blobs detected 7[01]\.\d px "
    assert re.match(wanted, reason(robot="robot2", markers="lab"))


def test_another_area():
    frames = [robsim.Simulation(**SMALL).frame.image] * 2
    sim = robsim.Experiment([robsim.Frame(image) for image in frames], area=(600, 600))
    sim.run()
    assert "43.0 px apart, but the red and blue blobs detected 21." in explain_no_detection(
        sim.trace, sim.markers
    )


@pytest.mark.parametrize("name", ["red", "blue"])
def test_a_colour_that_nothing_has(name):
    colors = [
        robsim.ColorClass(c.name, y=c.y, u=c.u, v=(250, 255) if c.name == name else c.v)
        for c in robsim.load_colors()
    ]
    assert reason(colors=colors) == (
        f"no {name} blob was detected: check the image and the colours"
    )


def test_never_in_the_same_frame():
    sim = robsim.Simulation(**SMALL)
    image = sim.frame.image
    red, blue = image.copy(), image.copy()
    red[..., 2] = np.minimum(red[..., 2], red[..., 0])
    blue[..., 0] = np.minimum(blue[..., 0], blue[..., 2])
    sim = robsim.Experiment([robsim.Frame(red), robsim.Frame(blue)])
    sim.run()
    assert explain_no_detection(sim.trace, sim.markers) == (
        "red and blue blobs were not detected in the same frame"
    )


def test_markers_of_another_size():
    def measure(step):
        assert step.blobs
        return

    sim = robsim.Simulation(resolution=(600, 600), measure=measure, seed=1)
    sim.run(2)
    assert "px apart were detected, as the markers are, but" in explain_no_detection(
        sim.trace, sim.markers
    )
