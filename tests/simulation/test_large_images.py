"""Images that would take too much memory, and what happens where there is none left."""

import subprocess
import sys

import numpy as np
import pytest

import robsim
import sanitizers


def test_a_robot_that_is_too_large_for_the_camera():
    for area, resolution in (
        ((16, 16), (2048, 2048)),
        ((200, 200), (8192, 8192)),
        ((16, 4000), (1000, 16)),
        ((16, 16), (16384, 16)),
    ):
        with pytest.raises(ValueError, match=r"resolution .* area"):
            robsim.Simulation(area=area, resolution=resolution, boundary="unlimited")


def test_a_robot_too_large_to_be_kept_in_all_headings_looks_the_same():
    """Its rows are made in each frame; those of few headings are kept."""
    options = {"area": (300, 300), "resolution": (900, 900), "boundary": "unlimited", "seed": 1}
    drawn = [
        robsim.Simulation(headings=n, start=(150, 150, angle), **options).frame.image
        for n in (4, 360)
        for angle in (0, np.pi / 2)
    ]
    np.testing.assert_array_equal(drawn[0], drawn[2])
    np.testing.assert_array_equal(drawn[1], drawn[3])


@pytest.mark.long
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs a limit of memory")
@pytest.mark.skipif(sanitizers.ADDRESS, reason="the sanitizer ends where memory does")
def test_memory_that_is_used_up_is_told_in_words():
    code = """
import resource, robsim
sim = robsim.Simulation(measure=True, resolution=(64, 64))
sim.run(2)
now = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (now + 2**26, now + 2**26))
try:
    robsim.RecursiveLeastSquares(1000, n_filters=50)
except MemoryError as error:
    print(error)
print(len(sim.run(3)))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "there is not enough memory" in done.stdout
    assert done.stdout.endswith("5\n")
