"""What is told of the estimated parameters."""

import numpy as np

import robsim
from browsers import panel_of


def parameters_of(simulation):
    with panel_of(simulation) as (_, browser):
        return browser.take("parameters")[0]


def run_of(steps=100, **options):
    simulation = robsim.Simulation(estimate_parameters=True, seed=1, **options)
    simulation.run(steps)
    return simulation


def test_a_robot_that_spins_excites_few_parameters():
    simulation = run_of()
    found = parameters_of(simulation)
    judged = robsim.identifiability(simulation.trace)
    assert found["values"] == simulation.trace.parameters[-1].ravel().tolist()
    assert found["errors"] == judged.standard_errors.ravel().tolist()
    assert found["excitation"]["good"] is False
    assert {"b1X", "b2X"} < {*found["excitation"]["weak"]}
    n = len(judged.names("not excited"))
    assert str(n) in found["excitation"]["text"]


def test_one_that_drives_around_excites_all():
    found = parameters_of(run_of(800, control=robsim.DriveAround()))
    assert (found["excitation"]["good"], found["excitation"]["weak"]) == (True, [])


def test_an_estimator_that_knows_no_errors_is_judged_by_its_samples():
    class Constant:
        theta = np.ones((3, 5))

        def update(self, phi, y):
            return self.theta

    found = parameters_of(run_of(init_parameter_estimator=lambda model: Constant()))
    assert found["values"] == [1.0] * 15
    assert found["excitation"]["good"] is False
    assert parameters_of(run_of(1))["excitation"]["good"] in (None, False)


def test_without_an_estimator_there_are_no_values():
    simulation = robsim.Simulation(seed=1)
    simulation.run(5)
    found = parameters_of(simulation)
    assert found["values"] is None
    assert found["excitation"] == {"text": "", "good": None, "weak": []}
    assert found["names"][:2] == ("a1X", "a2X")
