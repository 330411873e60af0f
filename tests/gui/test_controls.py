"""What can be set in a panel while its run goes on."""

import json
from pathlib import Path

import numpy as np
import pytest

import robsim
from robsim.estimation.reference import ExtendedKalmanFilter
from waiting import wait_for

pytestmark = pytest.mark.long

SIZE = (240, 240)


def small(**options):
    return robsim.Simulation(resolution=SIZE, seed=1, **options)


def setting(watcher, name, value):
    """Set a control; return its value then."""
    watcher.say("set", name=name, value=value)
    watcher.settle()
    return values(watcher)[name]


def values(watcher):
    return watcher.newest("state")["values"]


def control(watcher, name):
    return next(c for c in watcher.newest("setup")["controls"] if c["name"] == name)


def why_disabled(watcher, name, value):
    choices = control(watcher, name)["choices"]
    return next(choice["disabled"] for choice in choices if choice["value"] == value)


def stand_still(step):
    return 0.0, 0.0


def measured_as_true(step):
    return robsim.locate(step.blobs, step.markers, step.frame.plane_map)


def test_each_choice_can_be_made_and_stepped(watch):
    sim = small(measure=measured_as_true, control=stand_still)
    watcher = watch(sim)
    made = 0
    for described in watcher.newest("setup")["controls"]:
        for choice in described.get("choices", ()):
            if choice["disabled"] is None:
                assert setting(watcher, described["name"], choice["value"]) == choice["value"]
                watcher.press("step")
                assert watcher.newest("state")["state"] == "paused"
                made += 1
    assert sim.n_steps == made == 22


def test_each_control_has_a_label_and_is_in_the_protocol(watch):
    gui = Path(robsim.gui.__file__).parent
    texts = json.loads((gui / "static/texts.json").read_text("utf-8"))
    protocol = (gui / "PROTOCOL.md").read_text("utf-8")
    for described in watch(small()).newest("setup")["controls"]:
        assert described["label"] or f"control.{described['name']}" in texts
        assert described["label"] or f"`{described['name']}`" in protocol


def test_ranges_reach_the_world(watch):
    sim = small()
    watcher = watch(sim)
    for name, value in {"noise_level": 30.0, "dropout": 0.25, "disturbance_level": 0.5}.items():
        assert setting(watcher, name, value) == value
    assert sim.noise == robsim.GaussianNoise(30.0)
    assert sim.dropout == robsim.Dropout(0.25)
    np.testing.assert_allclose(sim.process_noise.sigma, (0.5, 0.5, 0.025))
    assert setting(watcher, "disturbance", "wheels") == "wheels"
    described = control(watcher, "disturbance_level")
    assert (described["unit"], described["value"]) == ("V", sim.process_noise.sigma[0])
    setting(watcher, "noise", "none")
    assert sim.noise is None
    setting(watcher, "noise", "uniform")
    assert sim.noise == robsim.UniformNoise(30.0)


def test_the_speed(watch):
    watcher = watch(small(), speed=7)
    assert values(watcher)["speed"] == 7
    assert setting(watcher, "speed", 0) == 0
    assert watcher.view.driver.speed == np.inf
    assert setting(watcher, "speed", 0.2) == 0.2
    assert setting(watcher, "speed", 0.1) == 0.2
    assert "speed" in watcher.notes()[-1]


def test_what_cannot_be_set_changes_nothing(watch):
    watcher = watch(small())
    before = values(watcher)
    refused = {"dropout": (1.1, "much"), "noise": ("pink", 1.0), "tracking": ("mine", True)}
    for name, wrong in {**refused, "state": ("mine",), "nothing": (1.0,)}.items():
        for value in wrong:
            said = len(watcher.of("note"))
            watcher.say("set", name=name, value=value)
            watcher.settle()
            assert [note["level"] for note in watcher.of("note")[said:]] == ["error"]
            assert values(watcher) == before


def test_state_estimation_brings_tracking_and_goes_with_it(watch):
    sim = small(process_noise=robsim.PoseNoise.from_sigma(0.4, 0.4, 0.02))
    watcher = watch(sim)
    setting(watcher, "state", "default")
    assert len(watcher.notes()) == 1
    assert values(watcher)["tracking"] == "default"
    estimator = sim.estimate_state.callback
    assert isinstance(estimator, ExtendedKalmanFilter)
    np.testing.assert_allclose(estimator.Q, sim.process_noise.Q)
    setting(watcher, "disturbance_level", 0.8)  # the filter is told
    np.testing.assert_allclose(estimator.Q, sim.process_noise.Q)
    setting(watcher, "tracking", "off")
    assert len(watcher.notes()) == 2
    assert values(watcher)["state"] == "off"


def test_the_default_estimator_is_consistent(watch):
    sim = small(
        process_noise=robsim.PoseNoise.from_sigma(0.1, 0.1, 0.005),
        boundary="unlimited",
        control=robsim.DriveAround(),
    )
    watcher = watch(sim)
    setting(watcher, "state", "default")
    watcher.view.close()
    trace = sim.run(300)
    errors = (trace.pose_estimated - trace.pose_true)[50:, :2]
    sigma = np.sqrt(trace.covariance[50:, :2, :2].diagonal(axis1=1, axis2=2))
    assert 0.5 < np.sqrt(np.mean((errors / sigma) ** 2)) < 1.5


@pytest.mark.parametrize(
    ("source", "needed"), [("measurement", ["tracking"]), ("estimate", ["state", "tracking"])]
)
def test_parameter_estimation_brings_what_it_learns_from(watch, source, needed):
    watcher = watch(small(identify_from=source))
    setting(watcher, "parameters", "default")
    assert all(values(watcher)[name] == "default" for name in needed)
    assert len(watcher.notes()) == len(needed)
    watcher.press("step")
    assert watcher.newest("state")["state"] == "paused"
    setting(watcher, "tracking", "off")
    assert values(watcher)["parameters"] == "off"
    watcher.press("step")
    assert watcher.newest("state")["state"] == "paused"


def test_a_choice_that_the_run_could_not_go_on_with_is_taken_back(watch):
    grey = robsim.ColorClass("green", y=(0, 255), u=(0, 100), v=(0, 100))
    sim = small(colors=[grey], measure=lambda step: None, estimate_state=estimate)
    watcher = watch(sim)
    before = values(watcher)
    setting(watcher, "tracking", "default")
    assert "colors" in watcher.notes()[-1]
    assert values(watcher) == before
    watcher.press("step")
    assert watcher.newest("state")["state"] == "paused"


def estimate(step):
    return robsim.Estimate((0, 0, 0), np.eye(3))


estimate.needs = "measurement"


def test_a_callback_of_a_cell_is_noticed(watch):
    sim = small()
    watcher = watch(sim)
    assert why_disabled(watcher, "tracking", "mine")
    sim.measure = measured_as_true
    sim.dropout = robsim.Dropout(0.5)
    wait_for(lambda: values(watcher)["tracking"] == "mine")
    assert values(watcher)["dropout"] == 0.5
    assert why_disabled(watcher, "tracking", "mine") is None
    for value in ("default", "off"):
        assert setting(watcher, "tracking", value) == value
    setting(watcher, "state", "default")  # it prefers the user's own
    assert values(watcher)["tracking"] == "mine"
    assert sim.measure.callback is measured_as_true


def test_the_users_own_controller_can_be_chosen_again(watch):
    mine = robsim.GoToPoint(30, 40)
    sim = small(measure=True, control=mine)
    watcher = watch(sim)
    assert values(watcher)["control"] == "mine"
    assert watcher.newest("state")["goal"] == [30, 40]
    assert setting(watcher, "control", "chirp") == "chirp"
    assert watcher.newest("state")["goal"] is None
    assert setting(watcher, "control", "mine") == "mine"
    assert sim.control.callback is mine


def test_a_click_drives_the_robot_there(watch):
    sim = small(start=(600, 600, 0))
    watcher = watch(sim, speed=float("inf"))
    watcher.say("go_to", x=700, y=600)
    watcher.settle()
    assert len(watcher.notes()) == 1
    assert values(watcher)["control"] == "go-to-point"
    assert watcher.newest("state")["goal"] == [700, 600]
    watcher.press("start")
    wait_for(lambda: sim.n_steps > 150)
    watcher.press("pause")
    assert np.hypot(*(sim.trace.pose_true[-1, :2] - (700, 600))) < 15
    setting(watcher, "tracking", "off")
    assert len(watcher.notes()) == 2
    assert values(watcher)["control"] == "off"
    watcher.press("step")
    assert tuple(sim.trace.u[-1]) == (0, 0)


def test_a_goal_lies_where_the_robot_can_be(watch):
    sim = small()
    watcher = watch(sim)
    watcher.say("go_to", x=1200, y=1)
    watcher.settle()
    radius = sim.robot.radius
    np.testing.assert_allclose(watcher.newest("state")["goal"], (1200 - radius, radius))
    watcher.say("go_to", x=1201, y=1)
    watcher.settle()
    assert "outside" in watcher.notes()[-1]


def test_without_a_goal_the_robot_stays(watch):
    watcher = watch(small(start=(300, 500, 0)))
    setting(watcher, "control", "go-to-point")
    np.testing.assert_allclose(watcher.newest("state")["goal"], (300, 500), atol=5)
    setting(watcher, "control", "follow-path")
    np.testing.assert_allclose(watcher.newest("state")["path"], [(300, 500)], atol=5)
    watcher.say("go_to", x=400, y=400)
    setting(watcher, "control", "spin")
    setting(watcher, "control", "go-to-point")
    assert watcher.newest("state")["goal"] == [400, 400]  # the last one


def test_a_path_is_drawn_by_hand(watch):
    watcher = watch(small())
    by_hand = [[200 + 2 * i, 300 + (i % 2)] for i in range(200)]
    watcher.say("path", points=[[200, 300], *by_hand, [598, 301], [598, -80]])
    watcher.settle()
    path = np.array(watcher.newest("state")["path"])
    assert values(watcher)["control"] == "follow-path"
    assert len(path) < 30
    assert path[0].tolist() == [200, 300]
    assert path[-1, 0] == 598
    assert path[-1, 1] > 0
    for points in ([], [[300, 300]], [[300, 300]] * 9):
        watcher.say("path", points=points)
        watcher.settle()
        assert "too short" in watcher.notes()[-1]
        assert len(watcher.newest("state")["path"]) == len(path)


@pytest.mark.parametrize("dt", [0.02, 3.0])
def test_signals_suit_the_sample_time(watch, dt):
    sim = small(model=robsim.RobotParameters(dt=dt))
    watcher = watch(sim)
    for name in ("multi-sine", "chirp", "pseudo-random-binary", "drive-around"):
        setting(watcher, "control", name)
        watcher.press("step")
        assert watcher.newest("state")["state"] == "paused"
    assert sim.control.callback.hold == max(1, round(2.0 / dt))


def test_an_experiment_has_what_applies(watch):
    watcher = watch(robsim.Experiment([small().frame] * 5, measure=False))
    names = [described["name"] for described in watcher.newest("setup")["controls"]]
    assert names == ["tracking", "parameters", "state", "control", "speed"]
    assert values(watcher)["control"] == "off"
    assert "without send" in why_disabled(watcher, "control", "spin")
    watcher.say("go_to", x=100, y=100)
    watcher.settle()
    assert "without send" in watcher.notes()[-1]
    setting(watcher, "parameters", "default")
    assert "controller" in watcher.notes()[-1]
    assert values(watcher)["parameters"] == "off"


def test_an_experiment_drives_its_robot(watch):
    sent, sim = [], small()
    frames = [sim.step().frame for _ in range(5)]
    options = {"send": lambda u: sent.append(tuple(u)), "control": stand_still}
    watcher = watch(robsim.Experiment(frames, **options))
    for name in ("spin", "off", "mine"):
        assert setting(watcher, "control", name) == name
    setting(watcher, "control", "spin")
    watcher.press("step")
    assert (0.05, -0.05) in sent
    setting(watcher, "parameters", "default")
    assert values(watcher)["parameters"] == "default"
    setting(watcher, "control", "off")  # a robot that is told nothing would drive on
    watcher.press("step")
    assert watcher.newest("state")["error"] is None
    assert sent[-1] == (0, 0)


def test_a_changed_file_leaves_what_the_panel_has_chosen(watch, folder):
    (folder / "estimate_state.py").unlink()
    sim = robsim.Simulation.from_folder(folder, resolution=SIZE, seed=1)
    watcher = watch(sim)
    assert "ENABLED = False" in why_disabled(watcher, "tracking", "mine")
    assert "estimate_state.py" in why_disabled(watcher, "state", "mine")
    setting(watcher, "tracking", "default")
    setting(watcher, "control", "chirp")
    (folder / "control.py").write_text("def control(step):\n    return 0.5, 0.25\n")
    watcher.press("step")
    assert (values(watcher)["tracking"], values(watcher)["control"]) == ("default", "chirp")
    assert setting(watcher, "control", "mine") == "mine"
    watcher.press("step")
    assert tuple(sim.trace.u[-1]) == (0.5, 0.25)
    (folder / "control.py").write_text("def control(step):\n    return 0.25, 0.5\n")
    watcher.press("step")
    assert tuple(sim.trace.u[-1]) == (0.25, 0.5)


def test_another_panel_knows_what_the_last_one_has_made(watch):
    sim = small()
    watcher = watch(sim)
    setting(watcher, "state", "default")
    setting(watcher, "control", "go-to-point")
    watcher.view.close()
    again = watch(sim)
    assert (values(again)["state"], values(again)["control"]) == ("default", "go-to-point")
    assert why_disabled(again, "state", "mine") is not None


def test_a_record_has_its_speed_alone(watch):
    sim = small()
    watcher = watch(sim.run(3))
    assert [described["name"] for described in watcher.newest("setup")["controls"]] == ["speed"]
    watcher.say("go_to", x=100, y=100)
    watcher.settle()
    assert len(watcher.notes()) == 1
    assert setting(watcher, "speed", 3.0) == 3.0


def test_where_the_robot_is_to_go_is_drawn_whoever_drives(watch):
    path = [[100, 200], [300, 400]]
    watcher = watch(small(control=stand_still, measure=True), goals=np.array(path))
    state = watcher.newest("state")
    assert (state["values"]["control"], state["goal"], state["path"]) == ("mine", None, path)
    watcher = watch(small(measure=True).run(3), goals=np.array([100, 200, 1.5]))
    assert watcher.newest("state")["goal"] == [100, 200, 1.5]
    watcher = watch(small(measure=True), goals=np.array([100, 200, 1.5]))
    assert setting(watcher, "control", "go-to-point") == "go-to-point"
    assert watcher.newest("state")["goal"] == [100, 200, 1.5]  # with its heading
    watcher.say("go_to", x=150, y=150)
    watcher.settle()
    assert watcher.newest("state")["goal"] == [150, 150]
    assert setting(watcher, "control", "spin") == "spin"
    assert watcher.newest("state")["goal"] == [100, 200, 1.5]
    with pytest.raises(ValueError, match="goals"):
        robsim.panel(small(), goals=(1, 2, 3, 4))
