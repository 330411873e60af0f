"""The open-loop signals that drive the robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from robsim._core import DriveAround, Spin
from robsim.control import Chirp, MultiSine, PseudoRandomBinary

# Steps and frequencies of the defaults suit the sample time of the default robot.
_DT = 0.2  # s
_HIGHEST = 0.4  # of the sampling frequency: half of it is too much
_LEAST_BAND = 10.0  # highest to lowest frequency


def _steps(kind: type, dt: float) -> Any:
    """Return a signal that holds its voltages as long as the default does."""
    return kind(hold=max(1, round(kind().hold * _DT / dt)))


def _band(kind: type, dt: float) -> Any:
    """Return a signal of sines that a sample time allows."""
    default = kind()
    highest = min(default.maximum_frequency, _HIGHEST / dt)
    lowest = min(default.minimum_frequency, highest / _LEAST_BAND)
    return kind(minimum_frequency=lowest, maximum_frequency=highest)


OFF = "off"

#: By the names of the command line; each is made for a sample time (s).
SIGNALS: Mapping[str, Callable[[float], Any]] = {
    OFF: lambda dt: Spin(voltage=0.0),  # a robot that is told nothing more drives on
    "spin": lambda dt: Spin(),
    "drive-around": lambda dt: _steps(DriveAround, dt),
    "pseudo-random-binary": lambda dt: _steps(PseudoRandomBinary, dt),
    "multi-sine": lambda dt: _band(MultiSine, dt),
    "chirp": lambda dt: _band(Chirp, dt),
}

_PLAIN = {name: make(_DT) for name, make in SIGNALS.items()}

SIGNAL_KINDS = {type(plain): name for name, plain in _PLAIN.items() if name != OFF}


def signal_of(control: object) -> str | None:
    """Return the name of a signal with its default options, which anybody may have chosen."""
    for name, plain in _PLAIN.items():
        if type(control) is type(plain) and control == plain:
            return name
    return None
