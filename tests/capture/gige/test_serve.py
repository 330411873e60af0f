"""``robsim serve``: the simulated lab as a GigE Vision camera for other programs."""

import re
import signal
import subprocess

import pytest

import robsim
from commands import command, interruptible
from gige_cameras import ADDRESS, URL, measured, opened, program, wait_for_camera
from needs import needs_program
from robsim.motors import UdpMotors
from waiting import wait_for

pytestmark = pytest.mark.long


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "--gige or --firewire COMMAND"),
        (["--gige", "--firewire"], "--gige and --firewire"),
        (["--gige", "ls"], "--gige.* ls "),
        (["--gige", "--motor-port", "0"], "--motor-port .*65535"),
    ],
)
def test_it_must_be_said_as_what(arguments, words):
    result = command("serve", *arguments)
    assert result.exit_code == 2
    assert re.search(words, result.stderr)


@pytest.mark.slow
def test_the_tool_of_aravis_reads_it(server):
    tool = needs_program("arv-camera-test-0.8", "aravis-tools")
    wait_for_camera()
    words = [tool, "--duration=1", "--no-packet-socket", "-n", ADDRESS, "-a"]

    def n_completed():
        said = subprocess.run(words, capture_output=True, text=True, timeout=300).stdout
        assert re.search(r"image width\s*= 320\n", said)
        return int(re.search(r"n_completed_buffers\s*= (\d+)\n", said)[1])

    wait_for(n_completed)


@pytest.mark.slow
def test_other_programs_see_the_robot_and_drive_it(tmp_path):
    serve = interruptible("serve", "--gige", "--fps", "50")
    with program(*serve, until="camera: ") as process:
        motors = re.search(r"udp:(\S+)", process.stdout.readline())[1]
        with opened(area=robsim.Scenario.area) as camera, UdpMotors(motors) as drive:
            start = measured(camera.read(), robsim.Scenario())
            drive((6.0, 6.0))
            wait_for(
                lambda: (
                    drive((6.0, 6.0))
                    and abs(measured(camera.read(), robsim.Scenario()) - start)[:2].max() > 20
                )
            )
        words = ("live", "--camera", URL, "--motors", f"udp:{motors}", "--area", "1200x1200")
        words += ("--control", "go-to-point:600,450", "--steps", "20", "--no-record")
        words += ("--frame-timeout", "100", "--out", str(tmp_path))
        wait_for(lambda: command(*words).exit_code == 0)  # it may not be reached at once
        process.send_signal(signal.SIGINT)
        rest = process.stdout.read()
        assert process.wait(300) == 0
    assert (tmp_path / "trace.npz").exists()
    assert re.search(r"\d+ frames", rest)
