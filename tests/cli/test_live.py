"""``robsim live``: a robot under a camera in real time, its end by signals, its messages."""

import json
import os
import re
import signal
import subprocess
import sys

import numpy as np
import pytest

import robsim
import sessions
from commands import command, interruptible
from robsim.cli.lab.driving import StatusLine
from robsim.lab import MotorReceiver
from robsim.trace import Session
from robsim.vision import save_video
from waiting import wait_for

DRIVING = "def control(step):\n    return 0.5, 0.25\n"
REHEARSAL = ("live", "--camera", "simulated", "--frame-timeout", "300")


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """A robot that stands, as a video of 12 frames."""
    file = tmp_path_factory.mktemp("film") / "run.mkv"
    sim = robsim.Simulation(
        robot="lab", area=(400, 400), resolution=(320, 320), start=(200, 150, 0.5),
        control=lambda step: (0, 0), seed=1,
    )  # fmt: skip
    save_video(file, [sim.step().frame for _ in range(12)], fps=30)
    return file


def refused(*arguments):
    """What a command says that ends with status 2 before anything is opened."""
    run = command("live", *arguments)
    assert run.exit_code == 2, run.output
    assert run.stdout == ""
    return run.stderr


def test_wrong_options_are_named():
    assert "--camera" in refused()
    for named, arguments in {
        "nowhere.mkv": ("--camera", "nowhere.mkv"),
        "firewire://0": ("--camera", "firewire:0"),
        "/dev/video98": ("--camera", "98"),
        "udp:192.168.4.1:5005": ("--motors", "192.168.4.1:5005"),
        "serial:/dev/ttyUSB0": ("--motors", "/dev/ttyUSB0"),
        "--motors": ("--motors", "udp:robot"),
        "--dt": ("--dt", "0"),
        "--seconds both": ("--steps", "3", "--seconds", "2"),
        "--seconds must": ("--seconds", "0"),
        "--fps and --dt": ("--fps", "20", "--dt", "0.05"),
        "--area must": ("--area", "0x0"),
        "error: --area must": ("--camera", __file__, "--area", "5x5"),
        "--max-voltage must": ("--max-voltage", "0"),
        "--positions": ("--pixels", "0,0 1,0 1,1 0,1"),
        "'drp'": ("--camera", "drp://drop", "--check"),
        "folder mine": ("mine",),
    }.items():
        camera = () if "--camera" in arguments else ("--camera", "simulated")
        assert named in refused(*camera, *arguments), arguments


def test_motors_that_are_not_there_are_named(film):
    assert "another camera" in refused("--camera", str(film), "--motors", "simulated")
    pytest.importorskip("serial")
    said = refused("--camera", str(film), "--motors", "serial:/dev/ttyNONE@9600")
    assert "/dev/ttyNONE" in said


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_a_rehearsal_leaves_results_and_a_session(tmp_path):
    run = command(*REHEARSAL, "--control", "go-to-point:900,300", "--steps", "8", cwd=tmp_path)
    assert run.exit_code == 0, run.output
    assert "640 x 640 px" in run.stderr
    assert re.search(r"not seen +0\n", run.stdout)
    assert re.search(r"reported error of the position \(px\) +0\.\d+\n", run.stdout)
    out = tmp_path / "robsim-live"
    trace = robsim.Trace.load(out / "trace.npz")
    assert len(trace) == 8
    assert trace.seen.all()
    assert trace.u.any()
    session = Session(out / "session-1")
    assert session.is_complete
    assert np.array_equal(session.trace.u, trace.u)
    again = command(*REHEARSAL, "--steps", "2", "--json", cwd=tmp_path)
    assert "replaced" in again.stderr
    assert json.loads(again.stdout)["timing"]["steps"] == 2
    assert len(Session(out / "session-1")) == 8  # recordings are never replaced
    assert len(Session(out / "session-2")) == 2


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_a_file_is_played_and_measured(film, tmp_path):
    options = ("--area", "400x400", "--robot", "lab", "--out", "played")
    run = command("live", "--camera", str(film), "--motors", "none", *options, cwd=tmp_path)
    assert run.exit_code == 0, run.output
    trace = robsim.Trace.load(tmp_path / "played/trace.npz")
    assert np.abs(trace.pose_measured[trace.seen][:, :2] - (200, 150)).max() < 2
    assert not [*(tmp_path / "played").glob("session*")]


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_an_error_in_a_callback_keeps_the_steps_before_it(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/control.py").write_text(
        "def control(step):\n    return 0.1 / (step.k < 3), 0.1\n"
    )
    run = command(*REHEARSAL, "mine", "--no-record", cwd=tmp_path)
    assert run.exit_code == 1, run.output
    assert "ZeroDivisionError" in run.stderr
    assert 'mine/control.py", line 2' in run.stderr
    assert len(robsim.Trace.load(tmp_path / "robsim-live/trace.npz")) == 3


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_a_camera_is_checked_without_driving(film, tmp_path):
    options = ("--area", "400x400", "--check", "--robot")
    run = command("live", "--camera", str(film), *options, "lab", cwd=tmp_path)
    # A machine that is busy does not see the frames at their rate, which is a problem, too.
    assert run.exit_code in (0, 1), run.output
    assert re.search(r"robot detected \(%\) +100 +good", run.stdout)
    assert (tmp_path / "robsim-live/check.png").is_file()
    other = command("live", "--camera", str(film), *options, "sheep", cwd=tmp_path)
    assert other.exit_code == 1
    assert "robot detected 0 % (bad)" in other.stdout


@pytest.mark.slow
def test_the_files_of_robsim_new_run_as_they_are(tmp_path):
    assert command("new", "mine", cwd=tmp_path).exit_code == 0
    run = command(*REHEARSAL, "mine", "--steps", "3", cwd=tmp_path)
    assert run.exit_code == 0, run.output
    for name in ("camera.jpg", "traces.png", "trace.npz"):
        assert (tmp_path / "robsim-live" / name).stat().st_size > 1000
    trace = robsim.Trace.load(tmp_path / "robsim-live/trace.npz")
    # 0.2 s is dt of define_model.py; a machine that is busy takes later frames, never earlier ones.
    assert np.diff(trace.t).min() > 0.1


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_the_robot_and_keeps_the_results(number, film, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/control.py").write_text(DRIVING)
    frames = [robsim.Frame(one.image) for one in robsim.Recording(film)] * 20
    save_video(tmp_path / "long.mkv", frames, fps=2)
    with MotorReceiver() as receiver:
        run = subprocess.Popen(
            interruptible("live", "mine", "--camera", "long.mkv", "--area", "400x400",
                          "--robot", "lab", "--frame-timeout", "300",
                          "--motors", f"udp:127.0.0.1:{receiver.port}"),
            cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=os.environ,
        )  # fmt: skip
        wait_for(lambda: run.poll() is not None or receiver.input.any())
        run.send_signal(number)
        _, said = run.communicate(timeout=300)
        assert run.returncode == 0, said
        assert re.search(r"stopped after \d+ steps", said)
        assert not receiver.input.any()
        assert receiver.events[-1].kind == "stop"
    trace = robsim.Trace.load(tmp_path / "robsim-live/trace.npz")
    assert trace.u.any()


@pytest.mark.filterwarnings("ignore:.*cannot be written", "ignore:.*the first error was")
def test_the_status_line_says_what_is_not_recorded(film, tmp_path, monkeypatch):
    record = tmp_path / "s"
    with (
        robsim.Camera(str(film), area=(400, 400)) as camera,
        robsim.Experiment(camera, record=record, frame_timeout=300, robot="lab") as experiment,
    ):
        line = StatusLine(experiment, camera, None)
        assert "NOT RECORDED" not in line.text(experiment.run(1))
        sessions.fill_disk(monkeypatch)
        trace = experiment.run(1)
        wait_for(lambda: "NOT RECORDED" in line.text(trace))


@pytest.mark.slow
def test_the_status_line_is_for_terminals_alone(tmp_path):
    pty, termios = pytest.importorskip("pty"), pytest.importorskip("termios")
    inner, outer = pty.openpty()
    termios.tcsetwinsize(outer, (30, 90))
    arguments = (*REHEARSAL, "--no-record", "--steps", "30", "--control", "spin")
    subprocess.run(
        [sys.executable, "-m", "robsim", *arguments], cwd=tmp_path, check=True, timeout=300,
        stdout=subprocess.DEVNULL, stderr=outer, env=os.environ | {"COLUMNS": "150"},
    )  # fmt: skip
    os.close(outer)
    shown = os.read(inner, 100_000).decode()
    os.close(inner)
    assert re.search(r"\r +\d+\.\d s .* x +\d+ y +\d+", shown)
    assert re.search(r"[+-]\d\.\d\d [+-]\d\.\d\d V", shown)
