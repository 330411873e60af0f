"""Simulations from scenarios, again and again: what is rebuilt and reset."""

import pickle

import numpy as np
import pytest

import robsim
from robsim import Dropout, GaussianNoise, Replay, Scenario, Simulation, WheelNoise
from robsim.trace import NotRecordedError

NOISY = Scenario(
    measure=True,
    estimate_parameters=True,
    control=robsim.DriveAround(),
    resolution=(240, 240),
    noise=GaussianNoise(5),
    dropout=Dropout(0.2, steps=2),
    process_noise=WheelNoise(0.02),
    mismatch=robsim.ParameterMismatch(0.05),
    start="random",
    seed=8,
)


def same(one, other):
    """Whether two traces have the same bytes."""
    return one.names == other.names and all(
        one[name].tobytes() == other[name].tobytes() for name in one.names
    )


def test_keywords_and_a_scenario_are_the_same_thing():
    given = {"measure": True, "noise": GaussianNoise(5), "resolution": (240, 240), "seed": 3}
    by_keywords = Simulation(**given)
    by_scenario = Simulation(Scenario(**given))
    assert by_keywords.scenario == by_scenario.scenario == Scenario(**given)
    assert same(by_keywords.run(5), by_scenario.run(5))
    mixed = Simulation(Scenario(**given), noise=None, seed=4)
    assert mixed.scenario == Scenario(measure=True, resolution=(240, 240), seed=4)


def test_a_trace_rebuilds_its_run_alone(tmp_path):
    trace = Simulation(NOISY).run(12)
    trace.save(tmp_path / "trace.npz")
    again = Scenario.of(robsim.Trace.load(tmp_path / "trace.npz"))
    assert again == NOISY == Scenario.of(trace)
    assert same(Simulation(again).run(12), trace)
    assert same(Simulation(pickle.loads(pickle.dumps(again))).run(12), trace)


def test_an_unpredictable_seed_is_known_afterwards():
    trace = Simulation(NOISY, seed=None).run(5)
    assert same(Simulation(Scenario.of(trace)).run(5), trace)
    assert not same(Simulation(NOISY, seed=None).run(5), trace)


def test_the_inputs_of_a_controller_in_python_are_replayed():
    sim = Simulation(NOISY, control=lambda step: (0.3, 0.2 + 0.01 * step.k))
    trace = sim.run(10)
    scenario = Scenario.of(trace)
    assert scenario == NOISY.replace(control=Replay(trace.u))
    assert same(Simulation(scenario).run(10), trace)
    with pytest.raises(ValueError, match="step 3"):
        Scenario.of(trace[3:])


def test_a_trace_of_an_experiment_has_no_scenario():
    frames = [Simulation(NOISY).step().frame]
    with pytest.raises(NotRecordedError) as caught:
        Scenario.of(robsim.Experiment(frames).run())
    assert caught.value.columns == ("scenario",)


def test_a_new_seed_gives_the_run_of_a_new_simulation():
    sim = Simulation(NOISY)
    first = sim.run(6)
    sim.reset(seed=21)
    second = sim.run(6)
    assert same(second, Simulation(NOISY, seed=21).run(6))
    assert Scenario.of(second) == NOISY.replace(seed=21)
    sim.reset()
    assert same(sim.run(6), second)
    sim.reset(seed=8)
    assert same(sim.run(6), first)


def test_a_reset_forgets_nothing_that_was_taken_out_before():
    sim = Simulation(NOISY)
    trace = sim.run(6)
    kept = {name: trace[name].copy() for name in trace.names}
    sim.reset(seed=1)
    sim.run(6)
    for name, values in kept.items():
        np.testing.assert_array_equal(trace[name], values)


def test_the_trace_knows_what_was_changed_after_it_was_looked_at():
    sim = Simulation(NOISY)
    sim.run(3)
    assert sim.trace.info.callbacks == sim.trace.info.changed == ()
    sim.noise = GaussianNoise(9)
    sim.measure = lambda step: None
    trace = sim.run(3)
    assert trace.info.callbacks == ("measure",)
    assert trace.info.changed == ("noise",)
    with (
        pytest.warns(UserWarning, match=r"\bnoise\b"),
        pytest.warns(UserWarning, match=r"\bmeasure\b"),
    ):
        scenario = Scenario.of(trace)
    assert scenario.noise == GaussianNoise(9)
    sim.reset()
    assert sim.run(1).info.changed == ()


def test_the_world_cannot_be_exchanged_during_a_run():
    sim = Simulation()

    @sim.control
    def control(step):
        sim.evaluate_model = robsim.Unicycle()
        return 0, 0

    with pytest.raises(RuntimeError, match="during a run"):
        sim.run(3)
