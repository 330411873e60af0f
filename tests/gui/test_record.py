"""Records of a panel, and the results of Finish."""

import threading

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import FakeBrowser, panel_of

# --- records


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


# --- results


PNG = b"\x89PNG"


def finish(simulation):
    with panel_of(simulation) as (_, browser):
        browser.say("press", button="finish")
        return browser.take("result")


@pytest.mark.long
def test_a_run_gives_table_remarks_and_figure():
    simulation = robsim.Simulation(estimate_parameters=True, seed=1, control=robsim.DriveAround())
    trace = simulation.run(800)
    head, (figure,) = finish(simulation)
    report = robsim.batch_estimate(trace)
    name, true, batch, error, online = head["rows"][1]
    assert name == "a2X"
    assert (true, batch) == (trace.info.theta_true[0][1], report.batch[0, 1])
    assert (error, online) == (report.standard_errors[0, 1], trace.parameters[-1, 0, 1])
    assert "from truth" in head["text"]
    assert head["verdict"]
    assert head["good"] is True
    assert figure[:4] == PNG


@pytest.mark.long
def test_a_run_that_excites_too_little_says_which_parameters_are_lost():
    simulation = robsim.Simulation(seed=1)
    simulation.run(50)
    head, (figure,) = finish(simulation)
    assert "does not determine" in head["text"]
    assert "not excited" in head["verdict"]
    assert head["good"] is False
    assert None in np.ravel(head["rows"])  # not determined
    assert figure[:4] == PNG


def test_too_short_a_run_says_so():
    simulation = robsim.Simulation(seed=1)
    for steps, says in ((0, "nothing"), (4, "5 samples")):
        simulation.run(steps)
        head, figures = finish(simulation)
        assert says in head["text"]
        assert (head["rows"], head["verdict"], figures) == ([], "no estimate", [])


def test_finish_pauses_and_a_new_view_is_told_the_result_too():
    simulation = robsim.Simulation(seed=1)
    with panel_of(simulation) as (_, browser):
        browser.say("press", button="start")
        browser.take("state", state="running")
        browser.say("press", button="finish")
        browser.take("state", state="paused")
        head, _ = browser.take("result", again=False)
        browser.say("hello", width=300)
        assert browser.take("result")[0] == {**head, "again": True}
        browser.say("press", button="step")
        browser.take("state", k=simulation.n_steps)
        browser.say("hello", width=300)
        browser.take("frame")
        assert browser.all_of("result") == []


def test_an_estimate_that_ends_after_reset_is_not_sent(monkeypatch):
    inside, may_go_on = threading.Event(), threading.Event()

    def slow(trace):
        inside.set()
        may_go_on.wait(300)
        return robsim.batch_estimate(trace)

    monkeypatch.setattr("robsim.gui.panels.analysis.result.batch_estimate", slow)
    simulation = robsim.Simulation(seed=1, control=robsim.DriveAround())
    simulation.run(40)
    with panel_of(simulation) as (view, browser):
        browser.press("finish")
        assert inside.wait(300)
        browser.press("reset")
        browser.take("state", k=-1)
        may_go_on.set()
        view.settle()
        assert browser.all_of("result") == []


def test_the_panel_answers_while_it_is_estimated(monkeypatch):
    inside, may_go_on, calls = threading.Event(), threading.Event(), []

    def slow(trace):
        calls.append(len(trace))
        inside.set()
        may_go_on.wait(300)
        raise ValueError(str(len(trace)))

    monkeypatch.setattr("robsim.gui.panels.analysis.result.batch_estimate", slow)
    simulation = robsim.Simulation(seed=1)
    simulation.run(1)
    with panel_of(simulation) as (_, browser):
        for _ in range(20):
            browser.press("finish")
        assert inside.wait(300)
        browser.press("step")
        browser.take("state", k=1)
        browser.press("finish")
        may_go_on.set()
        assert [browser.take("result")[0]["text"] for _ in range(2)] == ["1", "2"]
    # One at a time; those asked for meanwhile are one. The last may have come a moment later.
    assert calls[:2] == [1, 2]
    assert len(calls) <= 3
