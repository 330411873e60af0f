"""``robsim gui``: what it shows, what it says, how it ends."""

import os
import re
import signal
import socket
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
from commands import command, interruptible
from page_client import greeted
from robsim.gui import hosted
from robsim.gui.start.host import Start
from robsim.vision import save_image, save_video

pytestmark = pytest.mark.long

ADDRESS = r"the panel is at (http://127\.0\.0\.1:(\d+)/([\w-]+)/)\n"


@pytest.fixture
def seen(monkeypatch):
    """What there is while the command waits; it ends at once."""
    found = SimpleNamespace(has_browser=True)

    def wait(page, patience):
        found.view = page.view
        found.view.driver.step().result()
        found.state, found.error = found.view.driver.state, found.view.driver.error

    monkeypatch.setattr("robsim.gui.hosts.page.Page.wait", wait)
    monkeypatch.setattr("robsim.gui.hosts.page.Page.open", lambda page: found.has_browser)
    monkeypatch.delenv("SSH_CONNECTION", raising=False)
    return found


def test_without_a_folder_there_is_something_to_play_with(seen):
    run = command("gui", "--seed", "1")
    assert (run.exit_code, run.stderr) == (0, "")
    assert len(re.match(ADDRESS, run.stdout)[3]) == 24
    columns = seen.view.record.columns()
    assert {"pose_measured", "parameters"} <= set(columns)
    assert seen.view.driver.speed == 5
    assert seen.view.driver.state == "closed"


def test_the_callbacks_of_a_folder(seen, tmp_path):
    command("new", "mine", cwd=tmp_path)
    (tmp_path / "mine" / "control.py").write_text("def control(step):\n    return 0.25, 0.5\n")
    assert command("gui", "mine", cwd=tmp_path).exit_code == 0
    assert seen.view.record.columns()["u"].tolist() == [[0.25, 0.5]]


def test_an_error_of_a_callback_is_the_panels_affair(seen, tmp_path):
    (tmp_path / "control.py").write_text("def control(step):\n    return 1 / 0\n")
    assert command("gui", str(tmp_path)).exit_code == 0
    assert seen.state == "failed"
    assert isinstance(seen.error, ZeroDivisionError)


def test_what_was_saved_is_played_back(seen, tmp_path):
    simulation = robsim.Simulation(area=(300, 300), measure=True, seed=1)
    trace = simulation.run(4)
    trace.save(tmp_path / "trace.npz")
    save_video(tmp_path / "film.mkv", [simulation.render_step(k) for k in range(4)], fps=5)
    frames = (simulation.render_step(k) for k in range(4))
    with robsim.Experiment(frames, area=(300, 300), record=tmp_path / "session") as experiment:
        experiment.run()
    for name, steps in {"trace.npz": 4, "session": 4, "film.mkv": 1}.items():
        run = command("gui", name, cwd=tmp_path)
        assert (run.exit_code, run.stderr) == (0, ""), name
        assert seen.view.record.n_steps == steps
    refused = command("gui", "trace.npz", "--seed", "1", cwd=tmp_path)
    assert refused.exit_code == 2
    assert "--seed" in refused.stderr
    trace[2:].save(tmp_path / "late.npz")
    assert command("gui", "late.npz", cwd=tmp_path).exit_code == 2


def test_the_run_is_kept_and_estimated_when_its_last_page_is_closed(seen, user_folder, monkeypatch):
    runs = user_folder / "runs"
    runs.mkdir(parents=True)
    for old in range(10):
        (runs / f"1999-{old}.npz").touch()

    def wait(page, patience):
        page.view.runner.run(60)

    with monkeypatch.context() as patch:
        patch.setattr("robsim.gui.hosts.page.Page.wait", wait)
        told = command("gui", "--seed", "1").stdout
    assert "estimate" in told.partition(".npz")[2]
    *_, kept = kept_runs = sorted(runs.glob("*.npz"))
    assert len(kept_runs) == 10
    assert f"robsim gui {kept}" in told
    run = command("gui", str(kept))
    assert seen.view.record.n_steps == 60
    assert ".npz" not in run.stdout  # a saved run is not kept again


def test_the_run_of_a_card_is_kept_too(seen, user_folder, monkeypatch):
    def wait(page, patience):
        start = next(one for one in hosted.opened if isinstance(one, Start))
        start._open_card("drive")
        start.panel.pause()
        start.panel.step()
        start._open_card("task")
        start.panel.step()

    monkeypatch.setattr("robsim.gui.hosts.page.Page.wait", wait)
    told = command("gui").stdout
    kept = [*(user_folder / "runs").glob("*.npz")]
    assert len(kept) == 2
    assert all(f"robsim gui {file}" in told for file in kept)


def test_the_options_of_a_run(seen, tmp_path):
    options = ("--noise", "gaussian:5", "--dropout", "0.3:2", "--area", "400x300", "--seed", "4")
    options += ("--control", "go-to-point:200,100", "--speed", "max", "--robot", "lab")
    options += ("--boundary", "unlimited", "--headings", "continuous", "--motor-delay", "0.5")
    assert command("gui", *options).exit_code == 0
    simulation = seen.view.runner
    assert simulation.area == (400, 300)
    assert simulation.noise.percent == 5
    assert (simulation.boundary, simulation.scenario.motor_delay) == ("unlimited", 0.5)
    assert simulation.dropout.probability == 0.3
    assert seen.view.driver.speed == float("inf")
    simulation.scenario.save(tmp_path / "task.toml")
    assert command("gui", "--scenario", str(tmp_path / "task.toml")).exit_code == 0
    assert seen.view.runner.scenario == simulation.scenario


def test_ctrl_c_is_a_good_end(seen, monkeypatch):
    def interrupted(page, patience):
        raise KeyboardInterrupt

    monkeypatch.setattr("robsim.gui.hosts.page.Page.wait", interrupted)
    assert command("gui", "--seed", "1").exit_code == 0
    assert command("gui").exit_code == 0


def test_no_browser(seen, monkeypatch):
    seen.has_browser = False
    assert "no browser" in command("gui", "--seed", "1").stderr
    monkeypatch.setenv("SSH_CONNECTION", "10.0.0.1 5 10.0.0.2 22")
    run = command("gui", "--no-browser", "--seed", "1")
    port = re.match(ADDRESS, run.stdout)[2]
    assert f"ssh -N -L {port}:127.0.0.1:{port} " in run.stderr
    assert "no browser" not in run.stderr


def test_a_mistake_is_told_before_anything_opens(tmp_path):
    command("new", "mine", cwd=tmp_path)
    for named, arguments in {
        "nowhere": ("nowhere",),
        "mine/control.py": ("mine/control.py",),  # a single callback is not its folder
        "nowhere.mkv": ("nowhere.mkv",),
        "--speed": ("--speed", "0"),
        "max": ("--speed", "fast"),
        "port": ("--port", "70000"),
        "'prak'": ("--task", "prak"),
        "--task": ("--task", "park", "--scenario", "a.toml"),
        "--train": ("--task", "park", "--train"),
        "--robots and --train": ("--robots", "--train"),
        "--robot cannot be used with --calibrate": ("--calibrate", "--robot", "lab"),
        "--calibration": ("--calibration", "mine.toml"),
        # Where nothing runs.
        "--seed": ("--train", "--seed", "1"),
    }.items():
        run = command("gui", *arguments, cwd=tmp_path)
        assert (run.exit_code, run.stdout) == (2, ""), arguments
        assert named in run.stderr, arguments


def test_a_file_with_a_mistake_is_shown_with_its_line(tmp_path):
    (tmp_path / "control.py").write_text("def control(step):\n    return 0 0\n")
    run = command("gui", str(tmp_path))
    assert run.exit_code == 1
    assert re.search(r"control\.py.*line 2", run.stderr, re.DOTALL)


def test_a_port_that_is_in_use():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        run = command("gui", "--port", str(port))
    assert run.exit_code == 2
    assert f"port {port}" in run.stderr


@pytest.fixture
def process():
    """`robsim gui`, as a program."""
    process = subprocess.Popen(
        interruptible("gui", "--no-browser", "--seed", "1"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={k: v for k, v in os.environ.items() if k != "SSH_CONNECTION"},
    )
    yield process
    process.kill()
    process.communicate()


@pytest.mark.slow
@pytest.mark.parametrize("ends_by", ["page", "signal"])
def test_it_ends_with_its_last_page_or_by_a_signal(process, ends_by):
    _, port, secret = re.match(ADDRESS, process.stdout.readline()).groups()
    with greeted(SimpleNamespace(port=int(port), secret=secret)) as client:
        client.say(type="press", button="start")
        while client.hear("frame")[0]["k"] < 20:
            pass
        if ends_by == "signal":
            process.send_signal(signal.SIGINT)
            assert client.is_closed()
    printed, _ = process.communicate(timeout=300)
    assert process.returncode == 0
    assert "\n  parameter " in printed  # the table of the estimate


@pytest.mark.parametrize(
    ("tool", "given", "kind"),
    [
        ("--train", ("--robot", "sheep"), "colors"),
        ("--robots", ("--robot", "sheep"), "robots"),
        ("--calibrate", ("--calibration", "mine.toml"), "floor"),
    ],
)
def test_a_tool_works_on_a_picture_and_on_an_example(
    tool, given, kind, seen, tmp_path, monkeypatch
):
    save_image(tmp_path / "photo.png", np.full((60, 80, 3), 120, np.uint8))
    shown = []
    monkeypatch.setattr(
        "robsim.gui.hosts.page.Page.wait",
        lambda page, _: shown.append((page.view.kind, page.view.source.title)),
    )
    assert command("gui", "photo.png", tool, cwd=tmp_path).exit_code == 0
    assert command("gui", tool, *given, cwd=tmp_path).exit_code == 0
    (first, title), (second, other) = shown
    assert first == second == kind
    assert title == "photo.png" != other


def test_a_task_has_its_world_and_its_goal(seen, tmp_path):
    task = robsim.teach.ParkTask()
    task.begin(tmp_path / "mine")
    run = command("gui", str(tmp_path / "mine"), "--task", "park", "--seed", "1")
    assert run.exit_code == 0, run.stderr
    runner = seen.view.runner
    assert runner.scenario.replace(seed=None, control=None) == task.scenario
    assert seen.error is None
    assert np.array_equal(seen.view.goals, task.goals)
    assert "1 of the 150 steps" in run.stdout
    assert command("gui", "--task", "follow").exit_code == 0
    assert seen.view.goals.shape == (3, 2)
    short = robsim.teach.ParkTask(steps=3)
    short.simulation(seed=1).run(3).save(tmp_path / "trace.npz")
    assert command("gui", "trace.npz", "--task", "park", cwd=tmp_path).exit_code == 0
    assert np.array_equal(seen.view.goals, short.goals)


def test_the_scores_of_a_whole_run_of_a_task_are_told(seen, tmp_path, monkeypatch):
    task = robsim.teach.ParkTask(steps=20)
    monkeypatch.setattr("robsim.teach.tasks.task", lambda name: task)

    def wait(page, patience):
        for _ in range(25):
            page.view.driver.step().result()
        seen.view = page.view

    monkeypatch.setattr("robsim.gui.hosts.page.Page.wait", wait)
    for voltage, told in {0.1: "first 20 steps", 2: "2 V at"}.items():
        (tmp_path / "control.py").write_text(f"def control(step):\n    return {voltage}, 0\n")
        run = command("gui", str(tmp_path), "--task", "park", "--seed", "1")
        assert told in run.stdout, run.stderr
        assert seen.view.record.n_steps == 25
    run = command("gui", str(tmp_path), "--task", "park", "--boundary", "unlimited")
    assert "has another boundary" in run.stdout
