"""The set-up of simulations, and new robots in a run."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import robsim
from robsim import Dropout, GaussianNoise, Replay, Scenario, Simulation, WheelNoise
from robsim.gui.panels.record import SavedRecord
from robsim.simulation import Experiment
from robsim.trace import NotRecordedError

# --- scenarios


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


# --- new robots


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
        with pytest.raises(RuntimeError, match="colors cannot be changed during the recording"):
            recorded.colors = recorded.colors


def test_a_saved_run_says_that_its_pictures_show_the_last_one():
    sim = simulation()
    sim.run(3)
    sim.robot = "sheep"
    assert "sheep" in SavedRecord(sim.run(3)).remarks[0]
