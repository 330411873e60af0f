"""The options of a simulation, checked and in their normal form: immutable and comparable."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import (
    ColorClass,
    DriveAround,
    Limits,
    MarkerLayout,
    Replay,
    RobotModel,
    RobotParameters,
    Spin,
    Unicycle,
    classify,
    wrap_angle,
)
from robsim.base.checks import as_float_array, check_int, check_size, is_int
from robsim.base.text import quoted
from robsim.base.values import FileVersion
from robsim.simulation.world.disturbances import Dropout, ParameterMismatch, PoseNoise, WheelNoise
from robsim.simulation.world.scene import Floor, as_floor
from robsim.trace.timing import MAXIMUM_DELAY, check_delay
from robsim.vision.imaging.images import Pixels, load_image
from robsim.vision.imaging.noise import GaussianNoise, UniformNoise
from robsim.vision.markers.color_files import as_colors
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot

#: What some of the options take.
Background = Pixels | Floor | str | PathLike[str] | None
Colors = str | PathLike[str] | Iterable[ColorClass] | None
Markers = MarkerLayout | RobotDefinition | str | PathLike[str] | None

#: The options that are values of their own, and their types in the normal form.
KINDS: dict[str, tuple[type, ...]] = {
    "robot": (RobotDefinition,),
    "noise": (GaussianNoise, UniformNoise),
    "dropout": (Dropout,),
    "process_noise": (PoseNoise, WheelNoise),
    "mismatch": (ParameterMismatch,),
    "background": (Floor,),
    "markers": (MarkerLayout,),
    "model": (RobotModel, RobotParameters),
    "evaluate_model": (Unicycle,),
    "control": (Spin, DriveAround, Replay),
}

UNLIMITED = 2**62 - 1  # steps

_PIXEL = np.zeros((1, 1, 3), np.uint8)
_MAXIMUM_START = 1e6  # work-area px
_MOST_PIXELS = 2**26  # of a floor, whose four images take 0.8 GB then
_LARGEST_ROBOT = 4096  # camera px; its image takes 0.3 GB then


def step_count(steps: Any) -> int:
    """Return `steps` as an int of at least 0; else raise TypeError or ValueError."""
    if not is_int(steps):
        raise TypeError(f"steps must be an int, got {quoted(steps)}")
    if not 0 <= steps <= UNLIMITED:
        raise ValueError(f"steps must lie within 0..{UNLIMITED}, got {steps}")
    return int(steps)


def limits_value(limits: Limits) -> Limits:
    """Return the option ``limits``."""
    if not isinstance(limits, Limits):
        raise TypeError(
            f"limits must be robsim.lab.Limits(voltage=..., slew_rate=...), got {quoted(limits)}"
        )
    return limits


def timeout_value(timeout: float | None, default: float) -> float:
    """Return the option ``frame_timeout`` in s; inf = no limit."""
    if timeout is None:
        return default
    is_number = isinstance(timeout, (int, float, np.integer, np.floating))
    if not is_number or isinstance(timeout, bool):
        raise TypeError(f"frame_timeout must be a number (s), got {quoted(timeout)}")
    if not timeout > 0:  # NaN is not, too
        raise ValueError(
            f"frame_timeout must be above 0 (s), or inf for no limit, got {quoted(timeout)}"
        )
    return float(timeout)


def background_value(background: Background) -> Floor | None:
    """Return the option ``background`` as a value, in its own size; None stays None."""
    if background is None or isinstance(background, Floor):
        return background
    if isinstance(background, (str, PathLike)):
        return _floor_in_file(FileVersion.of(Path(background).resolve()))
    return as_floor(background)


@lru_cache(maxsize=2)
def _floor_in_file(file: FileVersion) -> Floor:
    return Floor(load_image(file.path))


def start_value(
    start: ArrayLike | None, area: tuple[int, int] | None
) -> tuple[float, float, float] | str | None:
    """Return the option ``start`` as a pose, ``"random"``, or None = the centre, facing right.

    Parameters
    ----------
    start : array (3,), str or None
        The option.
    area : tuple of int, or None
        Where the position must lie (px); None = anywhere.
    """
    if start is None:
        return None
    if isinstance(start, str):
        if start != "random":
            raise ValueError(
                f"start must be a pose (x, y, heading) or 'random', got {quoted(start)}"
            )
        return start
    expected = f"start must be a pose (x, y, heading) in px, px and rad, got {quoted(start)}"
    try:
        pose = as_float_array("start", start)
    except TypeError:
        raise TypeError(expected) from None
    if pose.shape != (3,) or not np.isfinite(pose).all():
        raise ValueError(expected)
    x, y, heading = pose.tolist()
    if area and not (0 <= x <= area[0] - 1 and 0 <= y <= area[1] - 1):
        raise ValueError(
            f"start must lie within the area of {area[0]} x {area[1]} px, got {quoted(start)}"
        )
    if abs(heading) > 2 * math.pi:
        raise ValueError(
            f"start must have a heading in rad, within -2 pi..2 pi, got {heading:g}: if that is in "
            f"degrees, it is {math.radians(heading):.4g} rad, numpy.radians({heading:g})"
        )
    if max(abs(x), abs(y)) > _MAXIMUM_START:
        raise ValueError(f"start must lie within {_MAXIMUM_START:g} px, got {quoted(start)}")
    return x, y, wrap_angle(heading)


def colors_value(colors: Colors, smoothing: int | None = None) -> tuple[ColorClass, ...]:
    """Return the option ``colors``; `smoothing`, too, is checked by the native classifier."""
    classes = as_colors(colors)
    if not classes:
        raise ValueError("colors must have at least one ColorClass, got none")
    classify(_PIXEL, classes, smoothing=1 if smoothing is None else smoothing)
    return classes


def check_marker_colors(markers: MarkerLayout, colors: Iterable[ColorClass], purpose: str) -> None:
    """Raise ValueError unless the colours of both markers are among `colors`."""
    known, needed = [color.name for color in colors], [*markers.colors.values()]
    if not set(needed) <= set(known):
        raise ValueError(
            f"colors must have {' and '.join(needed)} for {purpose}: the colours of the robot's "
            f"markers; got {', '.join(known)}"
        )


def markers_value(markers: Markers) -> MarkerLayout | None:
    """Return the option ``markers`` as a layout; None = that of the robot."""
    if markers is None or isinstance(markers, MarkerLayout):
        return markers
    if not isinstance(markers, (str, PathLike, RobotDefinition)):
        raise TypeError(
            f"markers must be a MarkerLayout, a RobotDefinition, a robot's name or a folder, "
            f"got {quoted(markers)}"
        )
    try:
        return as_robot(markers).marker_layout()
    except ValueError as error:
        raise ValueError(f"markers: {error}") from error


def smoothing_value(smoothing: int | None) -> int | None:
    """Return the option ``smoothing``; None = by the size of the markers."""
    return None if smoothing is None else check_int("smoothing", smoothing, minimum=1, maximum=15)


def resolution_value(resolution: tuple[int, int] | None) -> tuple[int, int] | None:
    """Return the option ``resolution``; None = the size of the area."""
    return None if resolution is None else check_size("resolution", resolution)


def check_images(
    area: tuple[int, int], resolution: tuple[int, int] | None, robot: RobotDefinition
) -> None:
    """Raise ValueError if the images of the floor or of the robot would take too much memory."""
    resolution = resolution or area
    for name, (width, height) in {"area": area, "resolution": resolution}.items():
        if width * height > _MOST_PIXELS:
            raise ValueError(
                f"{name} must have at most {_MOST_PIXELS} px in all, such as 8192 x 8192, got "
                f"{width} x {height}"
            )
    scale = max(resolution[0] / area[0], resolution[1] / area[1])
    height, width = robot.image.shape[:2]
    size = robot.size * max(1, height / width) * scale
    if size > _LARGEST_ROBOT:
        raise ValueError(
            f"resolution must show the robot with at most {_LARGEST_ROBOT} px: for an area of "
            f"{area[0]} x {area[1]} px, {resolution[0]} x {resolution[1]} px show it with "
            f"{size:.0f}; give a smaller resolution of the camera or a larger area"
        )


def headings_value(headings: int | None) -> int | None:
    """Return the option ``headings``; None = continuous."""
    return None if headings is None else check_int("headings", headings, minimum=1, maximum=360)


def camera_delay_value(delay: int) -> int:
    """Return the option ``camera_delay`` in steps."""
    if isinstance(delay, (float, np.floating)) and not float(delay).is_integer():
        raise TypeError(
            f"camera_delay must be an int, got {quoted(delay)}: a frame shows a step; put the "
            "fraction into motor_delay, since frames say when they were taken"
        )
    return check_int("camera_delay", delay, minimum=0, maximum=MAXIMUM_DELAY)


def motor_delay_value(delay: float) -> float:
    """Return the option ``motor_delay`` in steps, a whole number as an int."""
    value = check_delay("motor_delay", delay)
    return int(value) if value.is_integer() else value


def model_value(model: RobotModel | RobotParameters | None) -> RobotModel | RobotParameters | None:
    """Return the option ``model``; None = that of the default parameters."""
    if isinstance(model, RobotParameters):
        RobotModel(model)  # raises if the predictor is unstable
    elif model is not None and not isinstance(model, RobotModel):
        raise TypeError(
            f"model must be a RobotModel, a RobotParameters or None, got {quoted(model)}"
        )
    return model


def switch_value(name: str, value: bool | None) -> bool:
    """Return whether a stage that may be off is on."""
    if value is None or isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise TypeError(
        f"{name} must be True or False in a Scenario, got {quoted(value)}{_no_code(value)}"
    )


def check_is_data(name: str, value: Any) -> None:
    """Raise TypeError if an option is of none of its `KINDS`: a subclass may hold code."""
    if value is not None and type(value) not in KINDS[name]:
        names = " or ".join(kind.__name__ for kind in KINDS[name])
        raise TypeError(
            f"{name} must be {names} in a Scenario, got {quoted(value)}{_no_code(value)}"
        )


def _no_code(value: Any) -> str:
    return ": code is no data, give it to Simulation itself" if callable(value) else ""
