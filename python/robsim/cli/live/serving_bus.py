"""``robsim serve --firewire``: runs a command that sees the simulated lab on a FireWire bus."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from robsim._base.text import quoted
from robsim.cli import errors

if TYPE_CHECKING:
    from robsim.live import SimulatedLab

_LOOK = 0.2  # s
_PATIENCE = 5.0  # s, in which a program ends that has been told to
_BY_SIGNAL = 128  # a shell adds this to the number of the signal that ended a program


def program_of(arguments: Sequence[str]) -> list[str]:
    """Return what starts a command; ``robsim`` is the one that runs, on the path or not.

    Raises
    ------
    ValueError
        If there is no such program.
    """
    name, *rest = arguments
    if name == "robsim":
        return [sys.executable, "-P", "-m", "robsim", *rest]
    if shutil.which(name) is None:
        raise ValueError(f"COMMAND must begin with a program of this computer, got {quoted(name)}")
    return [name, *rest]


def run_on_bus(program: Sequence[str], lab: SimulatedLab) -> int:
    """Run a program that sees the lab as a FireWire camera; return its exit code."""
    from robsim.live import VirtualBus

    with VirtualBus(lab) as bus:
        _tell(lab)
        return _run(program, bus.environment)


def _tell(lab: SimulatedLab) -> None:
    """Say what there is on stderr: stdout belongs to the program."""
    (width, height), (across, down) = lab.size, lab.area
    errors.print_note(f"camera: firewire://, {width} x {height} px, {1 / lab.dt:g} frames/s")
    errors.print_note(f"motors: udp:{lab.address}, on an area of {across} x {down} px")


def _run(program: Sequence[str], environment: Mapping[str, str]) -> int:
    with _heard() as heard, subprocess.Popen(program, env=environment) as process:
        code = _wait(process, heard)
    return _BY_SIGNAL - code if code < 0 else code


@contextmanager
def _heard() -> Iterator[list[int]]:
    """Collect the signals that end programs.

    None of them raises here: an exception between the end of the program and the reading of its
    exit code would lose that.
    """
    ending = [signal.SIGINT, signal.SIGTERM]
    if sys.platform != "win32":
        ending.append(signal.SIGHUP)
    heard: list[int] = []
    before = {
        number: signal.signal(number, lambda number, _: heard.append(number))
        for number in ending
        if signal.getsignal(number) != signal.SIG_IGN  # as nohup has it
    }
    try:
        yield heard
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _wait(process: subprocess.Popen[bytes], heard: Sequence[int]) -> int:
    """Return the exit code of a program; one that does not end when it is told to, is ended."""
    steps = [process.kill, process.terminate]
    told = None
    while True:
        try:
            return process.wait(_LOOK)
        except subprocess.TimeoutExpired:
            if heard and told is None:
                told = time.monotonic()
                if heard[0] != signal.SIGINT:  # of Ctrl-C the terminal has told it
                    process.send_signal(heard[0])
            elif told is not None and steps and time.monotonic() > told + _PATIENCE:
                told = time.monotonic()
                steps.pop()()
