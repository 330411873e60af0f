"""What the panel shows: runs, traces, sessions, recordings."""

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import FakeBrowser, panel_of


@pytest.fixture(scope="module")
def simulation():
    """A run of ten steps, with noise that was changed in its middle."""
    simulation = robsim.Simulation(
        measure=True,
        estimate_parameters=True,
        seed=2,
        control=robsim.DriveAround(),
        area=(400, 300),
    )
    simulation.run(5)
    simulation.noise = robsim.UniformNoise(20)
    simulation.run(5)
    return simulation


@pytest.fixture
def saved(simulation, tmp_path):
    simulation.trace.save(tmp_path / "run.npz")
    return robsim.Trace.load(tmp_path / "run.npz")


def setup_of(shown):
    with panel_of(shown) as (_, browser):
        head, _ = browser.take("setup")
    return head


def test_a_simulation_says_what_it_is_and_an_experiment_has_no_truth(simulation):
    setup = setup_of(simulation)
    assert (setup["source"], setup["title"]) == ("simulation", "Simulation, robot lab")
    assert setup["dt"] == simulation.model.dt
    assert setup["has_truth"]
    assert setup["theta_true"] == simulation.true_model.theta.ravel().tolist()
    assert setup["colors"] == [
        {"name": "red", "css": "#e5484d"},
        {"name": "blue", "css": "#3b82f6"},
    ]
    groups = {group["name"]: group for group in setup["columns"]}
    assert groups["u"] == {"name": "u", "fields": ["u1", "u2"], "units": ["V", "V"]}
    assert groups["blobs_red"]["units"] == ["px"] * 4
    assert "pose_estimated" in groups  # it has none yet, but can get it
    frames = [simulation.render_step(k) for k in range(2)]
    lawn = robsim.ColorClass("lawn", u=(0, 100), v=(0, 100))  # is drawn like its range
    setup = setup_of(robsim.Experiment(frames, area=(400, 300), colors=[lawn], measure=False))
    assert setup["colors"] == [{"name": "lawn", "css": "#13d300"}]
    assert (setup["source"], setup["has_truth"], setup["theta_true"]) == ("experiment", False, None)


def test_setup_comes_again_if_the_start_changes_it():
    models = [robsim.RobotModel(robsim.RobotParameters(mass=mass)) for mass in (0.7, 0.5)]
    wanted = [model.theta.ravel().tolist() for model in reversed(models)]
    simulation = robsim.Simulation(seed=1, define_model=models.pop)
    with panel_of(simulation) as (_, browser):
        browser.take("setup", theta_true=wanted[0])
        browser.say("press", button="reset")
        browser.take("setup", theta_true=wanted[1])


def test_a_trace_is_played_back_from_its_frames(simulation, saved):
    with panel_of(saved, speed=float("inf")) as (_, browser):
        setup, _ = browser.take("setup")
        assert setup["source"] == "trace"
        assert {group["name"] for group in setup["columns"]} == {*saved._groups}
        head, _ = browser.take("frame")
        assert (head["k"], head["past"]) == (9, False)
        browser.say("press", button="start")
        browser.take("state", state="ended")
        for k in range(2):
            browser.say("press", button="step")
            head, _ = browser.take("frame", k=k)
            assert head["measured"] == simulation.trace.pose_measured[k].tolist()
            assert head["past"]


def test_a_trace_goes_on_from_where_one_looks_with_the_frames_of_the_run(simulation, saved):
    with panel_of(saved) as (view, browser):
        browser.say("look", k=6)
        browser.take("frame", k=6, past=True)
        browser.press("start")
        browser.take("state", state="running")
        assert browser.take("frame")[0]["k"] in (7, 8, 9)  # it may have gone on
        browser.press("pause")
        for k in range(10):
            again = view.driver.call(lambda k=k: view.record.frame(k)).result(300)
            assert np.array_equal(again.image, simulation.render_step(k).image)


def test_a_trace_without_frames_shows_the_poses_on_the_bare_area(simulation):
    frames = [simulation.render_step(k) for k in range(3)]
    trace = robsim.Experiment(frames, area=(400, 300)).run()
    with panel_of(trace) as (_, browser):
        browser.say("look", k=1)
        head, (picture,) = browser.take("frame", k=1, past=True)
        assert picture == b""
        assert head["size"] == [400, 300]
        assert head["measured"] == trace.pose_measured[1].tolist()
        assert browser.take("past")[0]["reason"]


@pytest.mark.long
def test_a_session_shows_its_video(simulation, tmp_path):
    pytest.importorskip("cv2")
    frames = (simulation.render_step(k) for k in range(4))
    with robsim.Experiment(frames, area=(400, 300), record=tmp_path / "monday") as experiment:
        experiment.run()
    with panel_of(robsim.trace.Session(tmp_path / "monday")) as (view, browser):
        setup, _ = browser.take("setup")
        assert (setup["source"], setup["title"]) == ("trace", "Session monday, robot lab")
        head, (picture,) = browser.take("frame", k=3)
        assert picture
        assert head["measured"] == experiment.trace.pose_measured[3].tolist()
        again = view.driver.call(lambda: view.record.frame(2)).result(300)
        assert np.abs(again.image.astype(float) - simulation.render_step(2).image).mean() < 5


@pytest.mark.long
def test_a_recording_becomes_an_experiment(simulation, tmp_path):
    for k in range(3):
        Image.fromarray(simulation.render_step(k).image).save(tmp_path / f"{k}.png")
    with panel_of(robsim.Recording(tmp_path)) as (_, browser):
        setup, _ = browser.take("setup")
        assert setup["source"] == "experiment"
        for _ in range(3):
            browser.say("press", button="step")
        browser.take("frame", k=2)
        browser.say("look", k=1)
        head, (picture,) = browser.take("frame", k=1, past=True)
        assert head["measured"] is not None
        assert picture


@pytest.mark.long
def test_a_long_record_comes_in_parts(saved, monkeypatch):
    monkeypatch.setattr("robsim.gui.panels.analysis.rows._MOST_BYTES", 100)
    wanted = {"pose_true": saved.pose_true, "u": saved.u}
    got = {name: np.empty((0, rows.shape[1]), "<f4") for name, rows in wanted.items()}
    with panel_of(saved) as (_, browser):
        browser.say("columns", names=[*wanted])
        while any(len(got[name]) < 10 for name in wanted):
            head, buffers = browser.take_rows()
            blocks = buffers[-len(head["rows"]) :]
            assert sum(map(len, blocks)) <= 100
            for entry, block in zip(head["rows"], blocks, strict=True):
                rows = np.frombuffer(block, "<f4").reshape(-1, entry["width"])
                before = got[entry["column"]]
                assert entry["first"] == len(before)
                got[entry["column"]] = np.concatenate([before, rows])
    for name, rows in wanted.items():
        np.testing.assert_array_equal(got[name], rows.astype("<f4"))


@pytest.mark.long
def test_a_line_that_is_behind_gets_its_rows_later(saved, monkeypatch):
    with panel_of(saved) as (_, browser):
        monkeypatch.setattr(FakeBrowser, "is_behind", True)
        browser.say("columns", names=["u"])
        browser.say("inspect", k=None, path=[])
        browser.take("tree")
        assert browser.rows == {"u": 0}
        monkeypatch.setattr(FakeBrowser, "is_behind", False)
        head, _ = browser.take_rows()
    assert [entry["first"] for entry in head["rows"]] == [0]


def test_a_trace_must_be_whole_and_have_a_step(simulation):
    with pytest.raises(ValueError, match="step 3"):
        robsim.panel(simulation.trace[3:])
    with pytest.raises(ValueError, match="steps"):
        robsim.panel(simulation.trace[:0])
    with pytest.raises(TypeError, match="what"):
        robsim.panel(3)
