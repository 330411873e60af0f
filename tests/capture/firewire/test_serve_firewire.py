"""``robsim serve --firewire``: the simulated lab as a FireWire camera for another program."""

import os
import re
import signal
import subprocess
import sys

import pytest

import robsim
from commands import cli, command, interruptible
from needs import needs_extension, needs_program
from robsim.cli.live import serving_bus

pytestmark = pytest.mark.long

SERVE = ("serve", "--firewire")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "COMMAND is missing"),
        (["--seconds", "3", "ls"], "--seconds is for --gige"),
        (["--address", "127.0.0.1", "ls"], "--address is for --gige"),
        (["--fps", "30", "no-such-program"], "got 'no-such-program'"),
    ],
)
def test_wrong_input_is_named(arguments, words):
    result = command(*SERVE, *arguments)
    assert result.exit_code == 2
    assert words in result.stderr


def test_without_the_bus_it_is_said_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr("robsim.live._virtual_bus._LIBRARY", tmp_path / "virtual_bus.so")
    result = command(*SERVE, "robsim", "cameras")
    assert result.exit_code == 2
    assert "apt-get install libdc1394-dev" in result.stderr


@pytest.mark.slow
def test_the_command_sees_the_camera_and_its_exit_code_is_returned():
    needs_extension("firewire")
    # An area whose frames would not have a size of FireWire's.
    done = cli(*SERVE, "--area", "1000x703", "robsim", "cameras")
    assert done.returncode == 0, done.stderr
    assert "Simulated camera" in done.stdout
    assert "motors: " not in done.stdout
    done = cli(*SERVE, sys.executable, "-c", "import sys; sys.exit(7)")
    assert done.returncode == 7


@pytest.mark.slow
def test_a_program_that_is_not_of_robsim_sees_it():
    needs_extension("firewire")
    program = needs_program("dc1394_reset_bus", "libdc1394-utils")
    done = cli(*SERVE, program)
    assert done.returncode == 0, done.stderr
    assert "b05a0000000001" in done.stdout


@pytest.mark.slow
def test_live_drives_the_robot(tmp_path):
    needs_extension("firewire")
    # The port of another lab, which has given it back.
    noted = cli(*SERVE, sys.executable, "-c", "").stderr
    port = re.search(r"motors: udp:127\.0\.0\.1:(\d+)", noted)[1]
    live = ("robsim", "live", "--camera", "firewire://", "--motors", f"udp:127.0.0.1:{port}")
    done = cli(
        *(*SERVE, "--motor-port", port, *live, "--area", "1200x1200", "--steps", "90"),
        *(
            "--control",
            "go-to-point:900,600",
            "--max-voltage",
            "6",
            "--slew-rate",
            "100",
            "--frame-timeout",  # a busy machine is no fault
            "10",
            "--no-record",
            "--out",
            str(tmp_path),
        ),
    )
    assert done.returncode == 0, done.stderr
    track = robsim.Trace.load(tmp_path / "trace.npz").pose_measured
    assert abs(track[-1, :2] - track[0, :2]).max() > 10


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_nothing_is_left_behind(number):
    needs_extension("firewire")
    program = "import os, time; print(os.getpid(), flush=True); time.sleep(60)"
    hearing = "import signal; signal.signal(signal.SIGINT, signal.SIG_DFL); "
    serve = interruptible(*SERVE, sys.executable, "-c", hearing + program)
    with subprocess.Popen(
        serve, stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        child = int(process.stdout.readline())
        if number == signal.SIGINT:  # a terminal tells all
            os.killpg(process.pid, number)
        else:
            process.send_signal(number)
        assert process.wait(20) == 128 + number
    with pytest.raises(ProcessLookupError):
        os.kill(child, 0)


def test_a_program_that_does_not_end_is_ended(monkeypatch):
    monkeypatch.setattr(serving_bus, "_PATIENCE", 0.1)
    code = (
        "import signal, time\n"
        "for number in (signal.SIGINT, signal.SIGTERM): signal.signal(number, signal.SIG_IGN)\n"
        "print('deaf', flush=True)\n"
        "time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-S", "-c", code], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline()
        assert serving_bus._wait(process, [signal.SIGINT]) == -signal.SIGKILL
