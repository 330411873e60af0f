"""``robsim serve``: the simulated lab as a GigE Vision camera for other programs."""

import re
import subprocess
import sys

import pytest

import robsim
from commands import cli, command, interruptible
from gige_cameras import ADDRESS, URL, measured, program, wait_for_camera
from needs import needs_program
from robsim.motors import UdpMotors

pytestmark = pytest.mark.long


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "--gige or --firewire COMMAND is missing"),
        (["--gige", "--firewire"], "--gige and --firewire exclude each other"),
        (["--gige", "ls"], "with --gige, start ls by itself"),
        (["--gige", "--motor-port", "0"], "--motor-port must be from 1 to 65535, got 0"),
    ],
)
def test_it_must_be_said_as_what(arguments, words):
    result = command("serve", *arguments)
    assert result.exit_code == 2
    assert words in result.stderr


@pytest.mark.slow
def test_the_tool_of_aravis_reads_it():
    tool = needs_program("arv-camera-test-0.8", "aravis-tools")
    serve = (sys.executable, "-m", "robsim", "serve", "--gige", "--fps", "30")
    with program(*serve, until="motors: "):
        wait_for_camera()
        said = subprocess.run(
            # A frame rate of another one's choice: that of the world stays.
            [tool, "--duration=3", "-f", "10", "--no-packet-socket", "-n", ADDRESS, "-a"],
            capture_output=True,
            text=True,
            timeout=60,
        ).stdout
    assert re.search(r"image width\s*= 640\n", said)
    completed = int(re.search(r"n_completed_buffers\s*= (\d+)\n", said)[1])
    assert 45 <= completed <= 95


@pytest.mark.slow
def test_another_program_sees_the_robot_and_drives_it():
    with program(*interruptible("serve", "--gige", "--fps", "50"), until="camera: ") as process:
        motors = re.search(r"udp:(\S+)", process.stdout.readline())[1]
        with robsim.Camera(URL, area=robsim.Scenario.area) as camera, UdpMotors(motors) as drive:
            poses = []
            for _ in range(60):
                poses.append(measured(camera.read(), robsim.Scenario())[:2])
                drive((6.0, 6.0))
        process.send_signal(2)
        rest = process.stdout.read()
        assert process.wait(20) == 0
    assert abs(poses[-1] - poses[0]).max() > 20
    assert re.search(r"\d+ frames were sent", rest)


@pytest.mark.slow
def test_live_reads_what_is_served(tmp_path):
    serve = (sys.executable, "-m", "robsim", "serve", "--gige", "--fps", "20")
    with program(*serve, until="camera: ") as process:
        motors = process.stdout.readline().split()[1]
        done = cli(
            *("live", "--camera", URL, "--motors", motors, "--fps", "20", "--area", "1200x1200"),
            *("--control", "go-to-point:600,450", "--steps", "40", "--no-record"),
            *("--out", str(tmp_path)),
        )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "trace.npz").exists()


@pytest.mark.slow
def test_a_second_one_is_refused():
    serve = (sys.executable, "-m", "robsim", "serve", "--gige")
    with program(*serve, until="motors: "):
        done = cli("serve", "--gige", "--seconds", "1")
    assert done.returncode == 2
    assert "port 3956 of 127.0.0.1 is taken" in done.stderr
