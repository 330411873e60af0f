"""`CameraFeatures`: a camera's exposure and colour settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

from robsim.base.checks import check_float
from robsim.base.text import quoted

AUTOMATIC = "auto"
_PAIRS = ("white_balance",)


@dataclass(frozen=True, kw_only=True)
class CameraFeatures:
    """A camera's exposure and colour settings.

    A number sets the value of a feature. ``"auto"`` lets the camera choose continuously, so colours
    may drift. None keeps the camera's current value constant. The available features and their
    limits depend on the camera; the error for an invalid value lists them.

    Parameters
    ----------
    shutter : float, "auto" or None
        Exposure time (s). A short exposure keeps the picture of a moving robot sharp.
    gain : float, "auto" or None
        Amplification (dB). A high gain adds noise.
    white_balance : pair of float, "auto" or None
        Gains of blue and red, in the camera's units.
    brightness, exposure, sharpness, hue, saturation, gamma : float, "auto" or None
        In the camera's units; `exposure` is the target brightness of automatic features.

    Raises
    ------
    TypeError, ValueError
        If a value has another form.

    Examples
    --------
    Pass them to a camera as ``robsim.Camera("firewire://", features=features)``.

    >>> features = robsim.lab.CameraFeatures(shutter=0.005, gain=6)
    >>> features.shutter, features.gain, features.exposure
    (0.005, 6.0, None)
    """

    shutter: float | str | None = None
    gain: float | str | None = None
    white_balance: Sequence[float] | str | None = None
    brightness: float | str | None = None
    exposure: float | str | None = None
    sharpness: float | str | None = None
    hue: float | str | None = None
    saturation: float | str | None = None
    gamma: float | str | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None or _is_automatic(value):
                continue
            object.__setattr__(self, field.name, _checked(field.name, value))

    def _wishes(self) -> list[tuple[str, list[float] | None]]:
        """Return the requests in the cameras' form: None is automatic."""
        wishes: list[tuple[str, list[float] | None]] = []
        for field in fields(self):
            value = getattr(self, field.name)
            if _is_automatic(value):
                wishes.append((field.name, None))
            elif value is not None:
                wishes.append((field.name, list(value) if field.name in _PAIRS else [value]))
        return wishes

    @classmethod
    def _of(cls, states: Sequence[tuple[Any, ...]]) -> Self:
        """Return a camera's report: (name, whether it is automatic, values, ...)."""
        values: dict[str, Any] = {}
        for name, is_automatic, numbers, *_ in states:
            if is_automatic:
                values[name] = AUTOMATIC
            else:
                values[name] = tuple(numbers) if name in _PAIRS else numbers[0]
        return cls(**values)


def _is_automatic(value: Any) -> bool:
    return isinstance(value, str) and value == AUTOMATIC


def _checked(name: str, value: Any) -> float | tuple[float, ...]:
    if name not in _PAIRS:
        if isinstance(value, str):
            raise ValueError(f"{name} must be a number, 'auto' or None, got {quoted(value)}")
        return check_float(name, value)
    try:
        blue, red = value
    except (TypeError, ValueError):
        raise TypeError(
            f"{name} must be two numbers (blue, red), 'auto' or None, got {quoted(value)}"
        ) from None
    return check_float(f"blue of {name}", blue), check_float(f"red of {name}", red)
