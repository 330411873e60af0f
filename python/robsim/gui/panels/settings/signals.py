"""The open-loop signals that drive the robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from robsim._core import Spin
from robsim.control.by_name import OPEN_LOOP

# Steps and frequencies of the defaults suit the sample time of the default robot.
_DT = 0.2  # s
_HIGHEST = 0.4  # of the sampling frequency, below the Nyquist frequency (0.5)
_LEAST_BAND = 10.0  # highest to lowest frequency


def _suited(kind: Callable[[], Any], dt: float) -> Any:
    """Return a signal with the default options, as far as they suit a sample time (s)."""
    default = kind()
    if hasattr(default, "hold"):  # voltages are held for this time
        return type(default)(hold=max(1, round(default.hold * _DT / dt)))
    if hasattr(default, "maximum_frequency"):
        highest = min(default.maximum_frequency, _HIGHEST / dt)
        lowest = min(default.minimum_frequency, highest / _LEAST_BAND)
        return type(default)(minimum_frequency=lowest, maximum_frequency=highest)
    return default


OFF = "off"

#: By the names of the command line; each needs a sample time (s).
SIGNALS: Mapping[str, Callable[[float], Any]] = {
    OFF: lambda dt: Spin(voltage=0.0),  # a robot without new commands drives on
    **{name: partial(_suited, kind) for name, kind in OPEN_LOOP.items()},
}

_PLAIN = {name: make(_DT) for name, make in SIGNALS.items()}

SIGNAL_KINDS = {type(plain): name for name, plain in _PLAIN.items() if name != OFF}


def signal_of(control: object) -> str | None:
    """Return the name of a signal with default options, whether the panel or a user set it."""
    for name, plain in _PLAIN.items():
        if type(control) is type(plain) and control == plain:
            return name
    return None
