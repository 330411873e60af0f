"""The memory of simulations: garbage and large images."""

import gc
import subprocess
import sys
import weakref

import numpy as np
import pytest

import robsim
import surroundings

# --- garbage


class Estimator:
    """One of the user's, which knows its simulation."""

    sim = None

    def update(self, phi, y):
        return np.zeros((3, 5))


def plain():
    return robsim.Simulation(measure=True, area=(300, 300), resolution=(75, 75))


def with_a_callback():
    sim = plain()
    sim.control = lambda step: (0 * sim.n_steps, 0.1)
    return sim


def with_an_estimator():
    estimator = Estimator()
    sim = robsim.Simulation(init_parameter_estimator=lambda model: estimator)
    estimator.sim = sim
    return sim


def with_a_world():
    sim = plain()
    sim.evaluate_model = lambda world: world.pose_1 if sim else None
    sim.adjust_background = lambda background: background if sim else None
    return sim


def with_motors():
    motors = Motors()
    motors.sim = robsim.Experiment(
        [robsim.Frame(np.zeros((64, 64, 3), np.uint8))] * 4,
        send=motors,
        frame_timeout=300,
        control=robsim.Spin(),
        area=(64, 64),
    )
    return motors.sim


class Motors:
    """Motors that know their experiment."""

    sim = None

    def __call__(self, u):
        pass


def experiment():
    frames = [robsim.Frame(np.zeros((64, 64, 3), np.uint8))] * 4
    return robsim.Experiment(
        frames, send=lambda u: None, frame_timeout=300, control=robsim.Spin(), area=(64, 64)
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("make", "goes_at_once"),
    [
        (plain, True),
        (experiment, True),
        (with_a_callback, False),
        (with_an_estimator, False),
        (with_a_world, False),
        (with_motors, False),
    ],
)
@pytest.mark.parametrize("steps", [0, 3])
def test_what_is_dropped_goes(make, goes_at_once, steps):
    gc.collect()
    gc.disable()
    try:
        sim = make()
        if steps:
            sim.run(steps)
            assert sim.frame.image.any() == (type(sim) is robsim.Simulation)
        gone = weakref.ref(sim)
        del sim
        assert (gone() is None) == goes_at_once
        gc.collect()
        assert gone() is None
    finally:
        gc.enable()


def test_an_estimator_outlives_its_simulation_in_a_step():
    sim = with_an_estimator()
    step = sim.step()
    estimator = sim.estimator
    del sim
    gc.collect()
    assert step.estimator is estimator


def test_what_is_kept_of_a_step_keeps_its_model():
    kept = []

    def evaluate_model(world):
        kept.append(world)
        return world.pose_1

    sim = robsim.Simulation(evaluate_model=evaluate_model)
    sim.run(2)
    theta = sim.model.theta.copy()
    del sim
    gc.collect()
    np.testing.assert_array_equal(kept[0].model.theta, theta)


# --- large images


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
@pytest.mark.skipif(surroundings.ADDRESS_SANITIZER, reason="the sanitizer ends where memory does")
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
