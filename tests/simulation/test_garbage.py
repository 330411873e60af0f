"""Dropped simulations go, also those that something of theirs refers to."""

import gc
import weakref

import numpy as np
import pytest

import robsim


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


@pytest.mark.long
@pytest.mark.parametrize("make", [plain, with_a_callback, with_an_estimator, with_a_world])
@pytest.mark.parametrize("steps", [0, 3])
def test_a_dropped_simulation_goes(make, steps):
    gc.disable()
    try:
        sim = make()
        if steps:
            sim.run(steps)
        gone = weakref.ref(sim)
        del sim
        assert (gone() is None) == (make is plain)  # one without a cycle goes at once
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
