"""The options of a simulated world and of its robot: a table with a row for each.

The row gives the check, the form in files, the documentation, the shell's option and the argument
of `Simulation` and `Scenario`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
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
from robsim.base.checks import as_float_array, check_heading, check_int
from robsim.base.seeds import Seed, SeedRecord, seed_value
from robsim.base.text import quoted
from robsim.base.values import FileVersion
from robsim.simulation.option import (
    ROBOT,
    WORLD,
    Option,
    choice,
    number,
    size,
    switch,
    value,
    whole,
)
from robsim.simulation.slots import SLOTS
from robsim.simulation.world.disturbances import Dropout, ParameterMismatch, PoseNoise, WheelNoise
from robsim.simulation.world.scene import HEADINGS, Floor, as_floor
from robsim.trace.columns import POSES
from robsim.trace.timing import MAXIMUM_DELAY
from robsim.vision.imaging import images
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import GaussianNoise, Noise, UniformNoise
from robsim.vision.markers.color_files import as_colors
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot

UNLIMITED = 2**62 - 1  # steps

_PIXEL = np.zeros((1, 1, 3), np.uint8)
_MAXIMUM_START = 1e6  # work-area px
_LARGEST_ROBOT = 4096  # camera px; its image takes 0.3 GB then


def step_count(steps: Any) -> int:
    """Return `steps` as an int of at least 0; else raise TypeError or ValueError."""
    return check_int("steps", steps, minimum=0, maximum=UNLIMITED)


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


def background_value(background: Pixels | Floor | str | PathLike[str] | None) -> Floor | None:
    """Return the option ``background`` as a value, in its own size; None stays None."""
    if background is None or isinstance(background, Floor):
        return background
    if isinstance(background, (str, PathLike)):
        return _floor_in_file(FileVersion.of(Path(background).resolve()))
    return as_floor(background)


@lru_cache(maxsize=2)
def _floor_in_file(file: FileVersion) -> Floor:
    return Floor(images.load_image(file.path))


def start_value(
    start: ArrayLike | None, area: tuple[int, int] | None
) -> tuple[float, float, float] | str | None:
    """Return the option ``start``: a pose within an area (px; None = anywhere), or unchanged."""
    if start is None:
        return None
    if isinstance(start, str):
        if start != "random":
            raise ValueError(
                f"start must be a pose (x, y, heading) or 'random', got {quoted(start)}"
            )
        return start
    expected = (
        f"start must be a pose (x, y, heading) in px, px and rad, or 'random', got {quoted(start)}"
    )
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
    check_heading("start", heading)
    if max(abs(x), abs(y)) > _MAXIMUM_START:
        raise ValueError(f"start must lie within +-{_MAXIMUM_START:g} px, got {quoted(start)}")
    return x, y, wrap_angle(heading)


def colors_value(
    colors: str | PathLike[str] | Iterable[ColorClass] | None,
) -> tuple[ColorClass, ...]:
    """Return the option ``colors``, checked by the native classifier."""
    classes = as_colors(colors)
    if not classes:
        raise ValueError("colors must have at least one ColorClass, got none")
    classify(_PIXEL, classes, smoothing=1)
    return classes


def _check_smoothing(smoothing: int | None) -> int | None:
    """Return a window that the native classifier accepts; None = by the size of the markers."""
    classify(_PIXEL, (ColorClass("any"),), smoothing=1 if smoothing is None else smoothing)
    return smoothing


def check_marker_colors(markers: MarkerLayout, colors: Iterable[ColorClass], purpose: str) -> None:
    """Raise ValueError unless the colours of both markers are among `colors`."""
    known, needed = [color.name for color in colors], [*markers.colors.values()]
    if not set(needed) <= set(known):
        raise ValueError(
            f"colors must have {' and '.join(needed)}, the colours of the robot's markers, for "
            f"{purpose}, got {', '.join(known)}"
        )


def markers_value(
    markers: MarkerLayout | RobotDefinition | str | PathLike[str] | None,
) -> MarkerLayout | None:
    """Return the option ``markers`` as a layout; None = the robot's."""
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


def check_images(
    area: tuple[int, int], resolution: tuple[int, int] | None, robot: RobotDefinition
) -> None:
    """Raise ValueError if the images of the floor or of the robot would take too much memory."""
    resolution = resolution or area
    for name, (width, height) in {"area": area, "resolution": resolution}.items():
        if width * height > images.MOST_PIXELS:
            raise ValueError(
                f"{name} must have at most {images.MOST_PIXELS} px in all, such as 8192 x 8192, "
                f"got {width} x {height}"
            )
    scale = max(resolution[0] / area[0], resolution[1] / area[1])
    height, width = robot.image.shape[:2]
    size = robot.size * max(1, height / width) * scale
    if size > _LARGEST_ROBOT:
        raise ValueError(
            f"the robot must have at most {_LARGEST_ROBOT} px in the frame, got {size:.0f} px for "
            f"an area of {area[0]} x {area[1]} px and a resolution of {resolution[0]} x "
            f"{resolution[1]} px; use a smaller resolution or a larger area"
        )


def _check_model(model: RobotModel | RobotParameters | None) -> Any:
    """Return a model; raise ValueError if its predictor is unstable."""
    if isinstance(model, RobotParameters):
        RobotModel(model)
    return model


_CONTROL = Spin()


@dataclass(frozen=True, kw_only=True)
class Options:
    """The table: a field for each option, in the order of files, which digests depend on."""

    robot: str | PathLike[str] | RobotDefinition | None = value(
        ROBOT, None,
        "Name of a robot, a folder with a ``robot.toml``, or a definition. Default: the robot "
        'chosen with ``robsim robots use``, initially ``"lab"``.',
        kind="str, path or RobotDefinition", types=(RobotDefinition,), normal=as_robot,
        group="robot",
    )  # fmt: skip
    area: tuple[int, int] = size(
        WORLD, (1200, 1200), "Width and height of the work area (px).", unit="width and height, px",
        group="world",
    )  # fmt: skip
    resolution: tuple[int, int] | None = size(
        WORLD, None, "Width and height of the frames (px). Default: the same as the area.",
        unit="px", group="camera",
    )  # fmt: skip
    boundary: str = choice(
        WORLD, "bounce",
        '``"bounce"``: the robot bounces off the walls. ``"unlimited"``: there are no walls, and '
        "the view follows the robot.",
        choices=("bounce", "unlimited"), group="world",
    )  # fmt: skip
    headings: int | None = whole(
        WORLD, HEADINGS,
        "Number of drawn headings of the robot: the nearest one, at integer pixels. None: the "
        "robot is drawn at its exact position and heading.",
        minimum=1, maximum=360, group="camera",
    )  # fmt: skip
    noise: Noise | None = value(
        WORLD, None, "Camera noise.",
        types=(UniformNoise, GaussianNoise), example="robsim.GaussianNoise(40)", is_live=True,
        group="camera",
    )  # fmt: skip
    dropout: Dropout | None = value(
        ROBOT, None, "Random occlusion: the probability that the robot is hidden from the camera.",
        types=(Dropout,), example="robsim.Dropout(0.2)", is_live=True,
        label="Dropout", level=Dropout._LEVEL, part="probability", group="camera",
    )  # fmt: skip
    process_noise: PoseNoise | WheelNoise | None = value(
        ROBOT, None, "Random disturbance of the robot's motion in every step.",
        types=(PoseNoise, WheelNoise), example="robsim.PoseNoise.from_sigma(0.5, 0.5, 0.01)",
        is_live=True, group="robot",
    )  # fmt: skip
    mismatch: ParameterMismatch | None = value(
        ROBOT, None, "Difference of the parameters of the world from those of `model`.",
        types=(ParameterMismatch,), example="robsim.ParameterMismatch(0.05)", group="robot",
    )  # fmt: skip
    camera_delay: int = whole(
        WORLD, 0,
        "Delay of a frame until it reaches the robot's software (steps). The robot keeps moving "
        "during the delay, and the software knows the exposure time only from the frame.",
        minimum=0, maximum=MAXIMUM_DELAY, unit="steps",
        reason="a frame shows a step; put the fraction into motor_delay, since frames carry "
        "their exposure time", group="camera",
    )  # fmt: skip
    motor_delay: float = number(
        ROBOT, 0,
        "Delay of an input until it reaches the motors (steps). With a fractional delay, two "
        "inputs act in each step, and the robot gets their mean; see the notes of `Scenario`.",
        minimum=0, maximum=MAXIMUM_DELAY, unit="steps", group="robot",
    )  # fmt: skip
    background: Pixels | Floor | str | PathLike[str] | None = value(
        WORLD, None,
        "The floor, scaled to the area. Default: the floor that ships with robsim.",
        kind="array (H, W, 3) of uint8, or path", types=(Floor,),
        normal=background_value, group="world",
    )  # fmt: skip
    start: ArrayLike | None = value(
        ROBOT, None,
        "The first pose: x, y (px), heading (rad). Default: the centre of the area, facing right.",
        kind='array (3,) or "random"', unit="px, px, rad", group="world",
    )  # fmt: skip
    seed: Seed = value(
        WORLD, None,
        "Seed of all random numbers of the run. None = unpredictable: each run has another seed.",
        kind="int, SeedSequence or Generator", normal=seed_value,
        types=(SeedRecord,), plain=True, group="world",
    )  # fmt: skip
    colors: str | PathLike[str] | Iterable[ColorClass] | None = value(
        ROBOT, None,
        "Colour file, or classes, to detect. Default: red and blue as shipped with robsim.",
        kind="path or iterable of ColorClass", normal=colors_value, group="software",
    )  # fmt: skip
    markers: MarkerLayout | RobotDefinition | str | PathLike[str] | None = value(
        ROBOT, None,
        "Geometry of the markers for the default measurement, or the robot that has them. Default: "
        "`robot`.",
        kind="MarkerLayout, RobotDefinition, str or path", types=(MarkerLayout,),
        normal=markers_value, group="software",
    )  # fmt: skip
    smoothing: int | None = whole(
        ROBOT, None,
        "Width of the averaging window applied before a pixel's colour is classified (px of the "
        "frame), against noise: 3, 5, ... 15, a quarter to three quarters of a marker's width. "
        "1 = off. Default: 0.28 of the smaller marker's width, limited to 3..7. For a marker below "
        "7 px, the default is 3 in frames with noise and 1 in others.",
        minimum=1, maximum=15, unit="px", normal=_check_smoothing, group="software",
    )  # fmt: skip
    identify_from: str = choice(
        ROBOT, "truth",
        'Source of the poses in the samples: ``"truth"``, ``"measurement"`` or ``"estimate"``.',
        choices=tuple(POSES), group="software",
    )  # fmt: skip
    model: RobotModel | RobotParameters | None = value(
        ROBOT, None,
        "The model of the world, except for `mismatch`, and the belief of the robot's software, "
        "unless ``define_model`` gives another. Default: the result of ``define_model``, or the "
        "model of ``RobotParameters()``.",
        types=(RobotModel, RobotParameters), normal=_check_model, group="robot",
    )  # fmt: skip
    evaluate_model: Unicycle | None = value(
        ROBOT, None, "The motion of the robot. Default: the model's own equations.",
        types=SLOTS["evaluate_model"].native, group="robot",
    )  # fmt: skip
    estimate_parameters: bool = switch(
        ROBOT, False, "Whether recursive least squares estimate the parameters.", group="software",
    )  # fmt: skip
    measure: bool = switch(
        ROBOT, False, "Whether the robot is located by its markers.", group="software",
    )  # fmt: skip
    control: Spin | DriveAround | Replay | None = value(
        ROBOT, _CONTROL, "The controller.",
        types=SLOTS["control"].native,
        normal=lambda control: _CONTROL if control is None else control, group="software",
    )  # fmt: skip


#: The rows by name. A row has the name and the type of its field.
OPTIONS: dict[str, Option] = {
    field.name: replace(field.metadata["option"], name=field.name, annotation=str(field.type))
    for field in fields(Options)
}
