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
from commands import command, interruptible
from robsim.imaging import save_video
from robsim.motors import MotorReceiver
from robsim.sessions import Session
from robsim.simulation._folders.callback_folder import new_folder

DRIVING = "def control(step):\n    return 0.5, 0.25\n"
REHEARSAL = ("live", "--camera", "simulated", "--frame-timeout", "30")


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


def test_a_camera_must_be_named():
    said = refused()
    assert "--camera is missing: 0 (the number of a camera), an address such as" in said
    assert "simulated, for a rehearsal; robsim cameras lists what there is" in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--camera", "nowhere.mkv"), "--camera must be 0 .*; there is no file 'nowhere.mkv'"),
        (("--camera", "firewire:0"), "no file 'firewire:0'; did you mean firewire://0"),
        (("--camera", "/dev/video2"), "did you mean 2"),
        (("--camera", "Simulate"), "did you mean simulated"),
        (("--motors", "192.168.4.1:5005"), "did you mean udp:192.168.4.1:5005"),
        (("--motors", "/dev/ttyUSB0"), "did you mean serial:/dev/ttyUSB0"),
        (("--motors", "usb:0"), "--motors must be udp:HOST:PORT, serial:PORT, .*, got 'usb:0'"),
        (("--motors", "udp:robot"), "--motors must be udp:HOST:PORT, .*, got 'udp:robot'"),
        (("--steps", "3", "--seconds", "2"), "--steps and --seconds both end the run"),
        (("--seconds", "0"), "--seconds must be > 0, got 0"),
        (("--steps", "-1"), "--steps must lie within 0.*, got -1"),
        (("--fps", "20", "--dt", "0.05"), "--fps and --dt say the same: give one of them"),
        (("--dt", "0"), "--dt must lie within .*, got 0"),
        (("--max-voltage", "0"), "--max-voltage: voltage must be .*, got 0"),
        (("--slew-rate", "-1"), "--slew-rate.* must be .*, got -1"),
        (("--control", "spinn"), "--control must be one of .*, got 'spinn'"),
        (("--pixels", "0,0 1,0 1,1 0,1"), "--pixels and --positions belong together"),
        (("--area", "big"), "--area must be a size such as 640x480, got 'big'"),
        (("mine",), "there is no folder mine: robsim new mine writes one"),
        (("--robot", "r2d2"), "r2d2"),
    ],
)
def test_wrong_options_are_named(arguments, words):
    camera = () if "--camera" in arguments else ("--camera", "simulated")
    assert re.search(words, refused(*camera, *arguments))


def test_the_motors_of_the_lab_belong_to_its_camera(film):
    said = refused("--camera", str(film), "--motors", "simulated")
    assert "with another camera, give udp:HOST:PORT, serial:PORT or none" in said


def test_a_port_that_is_not_there_is_named(film):
    pytest.importorskip("serial")
    said = refused("--camera", str(film), "--motors", "serial:/dev/ttyNONE@9600")
    assert "serial line /dev/ttyNONE cannot be opened" in said


def test_a_camera_that_is_not_there_is_named():
    assert "/dev/video98" in refused("--camera", "98")


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_a_rehearsal_leaves_results_and_a_session(tmp_path):
    run = command(*REHEARSAL, "--control", "go-to-point:900,300", "--steps", "8", cwd=tmp_path)
    assert run.exit_code == 0, run.output
    assert "camera simulated: 640 x 640 px, 20 frames/s" in run.stderr
    assert "at most 1.5 V, and 10 V/s (--max-voltage, --slew-rate)" in run.stderr
    assert "replaced by a newer one" in run.stdout
    assert "from exposure to input" in run.stdout
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
    assert "robsim.Experiment(robsim.sessions.Session('robsim-live/session-1')" in run.stderr
    again = command(*REHEARSAL, "--steps", "2", "--json", cwd=tmp_path)
    assert "no controller, so nothing is sent" in again.stderr
    assert "the earlier run in robsim-live is replaced" in again.stderr
    assert json.loads(again.stdout)["timing"]["steps"] == 2
    assert len(Session(out / "session-1")) == 8  # recordings are never replaced
    assert len(Session(out / "session-2")) == 2


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_a_file_is_played_and_measured(film, tmp_path):
    options = ("--area", "400x400", "--robot", "lab", "--out", "played")
    run = command("live", "--camera", str(film), "--motors", "none", *options, cwd=tmp_path)
    assert run.exit_code == 0, run.output
    assert "nothing is sent: --motors none" in run.stderr
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
    assert "the 3 steps until the error are kept" in run.stderr
    assert "ZeroDivisionError" in run.stderr
    assert 'mine/control.py", line 2' in run.stderr
    assert len(robsim.Trace.load(tmp_path / "robsim-live/trace.npz")) == 3


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_a_camera_is_checked_without_driving(film, tmp_path):
    options = ("--area", "400x400", "--robot", "lab", "--check")
    run = command("live", "--camera", str(film), *options, cwd=tmp_path)
    assert run.exit_code == 0, run.output
    assert "nothing drives it" in run.stderr
    assert re.search(r"robot detected \(%\) +100 +good", run.stdout)
    assert "written: robsim-live/check.png" in run.stdout
    other = command("live", "--camera", str(film), *options, "--robot", "sheep", cwd=tmp_path)
    assert other.exit_code == 1
    assert "robot detected 0 % (bad): in" in other.stdout


@pytest.mark.slow
@pytest.mark.long
def test_the_files_of_robsim_new_run_as_they_are(tmp_path):
    new_folder(tmp_path / "mine")
    run = command(*REHEARSAL, "mine", "--steps", "5", cwd=tmp_path)
    assert run.exit_code == 0, run.output
    for name in ("camera.jpg", "traces.png", "trace.npz"):
        assert (tmp_path / "robsim-live" / name).stat().st_size > 1000
    assert "robsim.Experiment.from_folder('mine', frames=" in run.stderr
    trace = robsim.Trace.load(tmp_path / "robsim-live/trace.npz")
    steps = np.diff(trace.t) / 0.2  # dt of define_model.py
    # A machine that is busy may miss the frame of a step, and take a later one.
    assert np.median(steps) == pytest.approx(1, abs=1e-3)
    assert steps.min() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_the_robot_and_keeps_the_results(number, film, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/control.py").write_text(DRIVING)
    frames = [robsim.Frame(one.image) for one in robsim.Recording(film)] * 20
    save_video(tmp_path / "long.mkv", frames, fps=5)
    with MotorReceiver() as receiver:
        run = subprocess.Popen(
            interruptible("live", "mine", "--camera", "long.mkv", "--area", "400x400",
                          "--robot", "lab", "--frame-timeout", "30",
                          "--motors", f"udp:127.0.0.1:{receiver.port}"),
            cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=os.environ,
        )  # fmt: skip
        while not receiver.input.any():
            assert run.poll() is None, run.communicate()
        run.send_signal(number)
        out, said = run.communicate(timeout=60)
        assert run.returncode == 0, said
        assert re.search(r"stopped after \d+ steps", said)
        assert not receiver.input.any()
        assert receiver.events[-1].kind == "stop"
    trace = robsim.Trace.load(tmp_path / "robsim-live/trace.npz")
    assert trace.u.any()
    assert "written to robsim-live" in out


@pytest.mark.slow
def test_the_status_line_is_for_terminals_alone(tmp_path):
    pty, termios = pytest.importorskip("pty"), pytest.importorskip("termios")
    inner, outer = pty.openpty()
    termios.tcsetwinsize(outer, (30, 90))
    arguments = (*REHEARSAL, "--no-record", "--seconds", "2", "--control", "spin")
    subprocess.run(
        [sys.executable, "-m", "robsim", *arguments], cwd=tmp_path, check=True, timeout=100,
        stdout=subprocess.DEVNULL, stderr=outer, env=os.environ | {"COLUMNS": "150"},
    )  # fmt: skip
    os.close(outer)
    shown = os.read(inner, 100_000).decode()
    os.close(inner)
    assert re.search(r"\r +\d+\.\d s +\d+\.\d/s  age +\d+ ms  dropped \d+  x +\d+ y +\d+", shown)
    assert re.search(r"[+-]\d+ deg  [+-]\d\.\d\d [+-]\d\.\d\d V", shown)
