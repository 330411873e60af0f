"""``robsim serve --firewire``: the simulated lab as a FireWire camera for another program."""

import os
import re
import signal
import subprocess
import sys

import pytest

import robsim
from commands import cli, command, interruptible
from needs import needs_extension
from robsim.cli.live import serving_bus

pytestmark = pytest.mark.long

SERVE = ("serve", "--firewire")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "COMMAND"),
        (["--seconds", "3", "ls"], "--seconds .*--gige"),
        (["--address", "127.0.0.1", "ls"], "--address .*--gige"),
        (["--fps", "30", "no-such-program"], "no-such-program"),
    ],
)
def test_wrong_input_is_named(arguments, words):
    result = command(*SERVE, *arguments)
    assert result.exit_code == 2
    assert re.search(words, result.stderr)


def test_without_the_bus_it_is_said_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr("robsim.live._virtual_bus._LIBRARY", tmp_path / "virtual_bus.so")
    result = command(*SERVE, "robsim", "cameras")
    assert result.exit_code == 2
    assert "apt-get install libdc1394-dev" in result.stderr


@pytest.mark.slow
def test_the_command_sees_the_camera():
    needs_extension("firewire")
    # An area whose frames would not have a size of FireWire's.
    done = cli(*SERVE, "--area", "1000x703", "robsim", "cameras")
    assert done.returncode == 0, done.stderr
    assert "Simulated camera" in done.stdout
    assert "motors: " not in done.stdout


@pytest.mark.slow
def test_live_drives_the_robot(tmp_path):
    needs_extension("firewire")
    # Its exit code is returned, and its port of another lab given back.
    first = cli(*SERVE, sys.executable, "-c", "import sys; sys.exit(7)")
    assert first.returncode == 7
    port = re.search(r"motors: udp:127\.0\.0\.1:(\d+)", first.stderr)[1]
    live = ("robsim", "live", "--camera", "firewire://", "--motors", f"udp:127.0.0.1:{port}")
    live += ("--area", "1200x1200", "--steps", "60", "--control", "go-to-point:900,600")
    live += ("--max-voltage", "6", "--slew-rate", "100", "--frame-timeout", "100", "--no-record")
    done = cli(*SERVE, "--motor-port", port, *live, "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    track = robsim.Trace.load(tmp_path / "trace.npz").pose_measured
    assert abs(track[-1, :2] - track[0, :2]).max() > 10


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_nothing_is_left_behind(number):
    needs_extension("firewire")
    program = "import os, sys; print(os.getpid(), flush=True); sys.stdin.read()"
    hearing = "import signal; signal.signal(signal.SIGINT, signal.SIG_DFL); "
    serve = interruptible(*SERVE, sys.executable, "-c", hearing + program)
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(serve, start_new_session=True, **pipes) as process:
        child = int(process.stdout.readline())
        if number == signal.SIGINT:  # a terminal tells all
            os.killpg(process.pid, number)
        else:
            process.send_signal(number)
        assert process.wait(300) == 128 + number
    with pytest.raises(ProcessLookupError):
        os.kill(child, 0)


def test_a_program_that_does_not_end_is_ended(monkeypatch):
    monkeypatch.setattr(serving_bus, "_PATIENCE", 0.1)
    code = (
        "import signal, sys\n"
        "for number in (signal.SIGINT, signal.SIGTERM): signal.signal(number, signal.SIG_IGN)\n"
        "print('deaf', flush=True)\n"
        "sys.stdin.read()\n"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-S", "-c", code], **pipes) as process:
        assert process.stdout.readline()
        assert serving_bus._wait(process, [signal.SIGINT]) == -signal.SIGKILL
