"""The scene under the camera, composed of floor, shadow and robot image; made once, then shared."""

from __future__ import annotations

import inspect
import os
from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cache, lru_cache
from threading import Lock

import numpy as np

from robsim._core import Scene
from robsim.base.shipped import ASSETS
from robsim.base.text import quoted
from robsim.base.values import Value, frozen
from robsim.simulation.callbacks.errors import failed, refused
from robsim.vision.imaging import images
from robsim.vision.imaging.images import Pixels
from robsim.vision.robots.definition import RobotDefinition


class SceneCache:
    """Keeps the last scenes, in `maximum_size` bytes; the newest always. Thread-safe."""

    def __init__(self, *, maximum_size: int) -> None:
        self.maximum_size = maximum_size
        self.forget()

    def forget(self) -> None:
        """Forget all scenes."""
        self._scenes: OrderedDict[Hashable, Scene] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Hashable, make: Callable[[], Scene]) -> Scene:
        """Return the scene of a key; `make` is called for a missing key."""
        with self._lock:
            scene = self._scenes.get(key)
            if scene is not None:
                self._scenes.move_to_end(key)
                return scene
        # Unlocked, as it takes long: two threads may make the same scene, and one of them is kept.
        made = make()
        with self._lock:
            scene = self._scenes.setdefault(key, made)
            while len(self._scenes) > 1 and self.size > self.maximum_size:
                self._scenes.popitem(last=False)
            return scene

    @property
    def size(self) -> int:
        """Memory of the scenes (bytes)."""
        return sum(scene.nbytes for scene in self._scenes.values())


#: Number of headings that the robot is drawn in, as in the program of 2008.
HEADINGS = 36
# The square on the default background: left, top, side (work-area px), RGB.
_SQUARE = (572, 64, 56, (198, 36, 40))
_cache = SceneCache(maximum_size=64 * 2**20)
if hasattr(os, "register_at_fork"):
    # A thread of the parent's may have been about to change it, or a heading in a scene.
    os.register_at_fork(after_in_child=_cache.forget)


def draw_red_square(background: Pixels) -> Pixels:
    """Draw a red square near the top: the default of the slot ``adjust_background``.

    The square is larger than the robot's red marker; the vision must not confuse the two.

    Parameters
    ----------
    background : array (H, W, 3) of uint8
        The work area, RGB, one pixel per work-area px; it is changed in place.

    Returns
    -------
    array (H, W, 3) of uint8
        The same array.

    Raises
    ------
    TypeError, ValueError
        If the image has the wrong type or shape.

    Examples
    --------
    >>> image = np.zeros((1200, 1200, 3), np.uint8)
    >>> robsim.simulation.draw_red_square(image).max(axis=(0, 1))
    array([198,  36,  40], dtype=uint8)
    """
    _check_pixels(background)
    left, top, side, color = _SQUARE
    background[top : top + side, left : left + side] = color
    return background


def leave_floor(background: Pixels) -> Pixels:
    """Draw nothing."""
    return background


@dataclass(frozen=True, eq=False)
class Floor(Value):
    """A user's floor, pixels (H, W, 3) of uint8, copied, as a value of the work area's size."""

    pixels: Pixels = field(repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "pixels", frozen(self.pixels))


def make_scene(
    *,
    robot: RobotDefinition,
    area: tuple[int, int],
    resolution: tuple[int, int],
    headings: int,
    background: Floor | None,
    adjust_background: Callable[[Pixels], Pixels],
) -> Scene:
    """Return a scene, cached by its arguments; TypeError, ValueError: the adjusted image is wrong.

    `area` and `resolution` are the sizes of work area and frame (px). 0 `headings` = continuous, no
    `background` = robsim's floor. `adjust_background` changes the image of the area with its
    shadow; functions except `draw_red_square` and `leave_floor` are called each time.
    """

    def make() -> Scene:
        return _composed(robot, area, resolution, headings, background, adjust_background)

    shipped = inspect.unwrap(adjust_background)  # of a time limit
    if shipped not in (draw_red_square, leave_floor):
        return make()
    return _cache.get((robot, area, resolution, headings, background, shipped), make)


def _composed(
    robot: RobotDefinition,
    area: tuple[int, int],
    resolution: tuple[int, int],
    headings: int,
    background: Floor | None,
    adjust_background: Callable[[Pixels], Pixels],
) -> Scene:
    floor = _shipped_floor(area) if background is None else background.pixels
    shadowed_floor = images.darkened(floor)
    home, shadowed_home = _home(floor, shadowed_floor, adjust_background)
    sprite, centre, unit = robot_sprite(
        robot, max(resolution[0] / area[0], resolution[1] / area[1])
    )
    return Scene(
        floor=(images.resized(floor, *resolution), images.resized(shadowed_floor, *resolution)),
        home=(images.resized(home, *resolution), images.resized(shadowed_home, *resolution)),
        shadow_left=_shadow_left(resolution[0]),
        shadow_factor=images.SHADOW,
        sprite=sprite,
        centre=centre,
        unit=unit,
        alignment=np.deg2rad(robot.alignment),
        headings=headings,
        area=area,
    )


def _shadow_left(width: int) -> int:
    return round(width * 2 / 3)


def _home(
    floor: Pixels, shadowed_floor: Pixels, adjust_background: Callable[[Pixels], Pixels]
) -> tuple[Pixels, Pixels]:
    """Return the work area after the callback, lit and in the shadow."""
    left = _shadow_left(floor.shape[1])
    shown = np.concatenate((floor[:, :left], shadowed_floor[:, left:]), axis=1)
    adjusted = _adjusted(adjust_background, shown)
    home, shadowed_home = floor.copy(), shadowed_floor.copy()
    rows = np.flatnonzero((adjusted != shown).reshape(len(floor), -1).any(axis=1))
    # Changes in the light are darkened for the shadow, and vice versa.
    home[rows, :left] = adjusted[rows, :left]
    shadowed_home[rows, :left] = images.darkened(adjusted[rows, :left])
    shadowed_home[rows, left:] = adjusted[rows, left:]
    # Only changes: lightened(darkened(floor)) is not exact.
    in_shadow = adjusted[rows, left:]
    drawn = (in_shadow != shown[rows, left:]).any(axis=2, keepdims=True)
    home[rows, left:] = np.where(drawn, images.lightened(in_shadow), floor[rows, left:])
    return home, shadowed_home


def as_floor(pixels: Pixels) -> Floor:
    """Return a floor (H, W, 3) of uint8; messages name it as the option ``background``."""
    _check_pixels(pixels, " or a file")
    return Floor(pixels)


def _check_pixels(background: Pixels, alternative: str = "") -> None:
    if not isinstance(background, np.ndarray) or background.dtype != np.uint8:
        raise TypeError(
            f"background must be a uint8 array{alternative}, got {_described(background)}"
        )
    if background.ndim != 3 or background.shape[2] != 3 or not background.size:
        raise ValueError(f"background must have the shape (H, W, 3), got {background.shape}")


def _described(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"a {value.dtype} array of shape {value.shape}"
    return quoted(value)


@lru_cache(maxsize=2)
def scaled_floor(floor: Floor | None, area: tuple[int, int]) -> Floor | None:
    """Return a floor scaled to the work area; None stays None."""
    if floor is None or floor.pixels.shape[1::-1] == area:
        return floor
    return Floor(images.resized(floor.pixels, *area))


def _shipped_floor(area: tuple[int, int]) -> Pixels:
    """Return the shipped floor, tiled and cropped to the size of the work area."""
    width, height = area
    tile = _floor_tile()
    across, down = -(-width // tile.shape[1]), -(-height // tile.shape[0])
    return np.ascontiguousarray(np.tile(tile, (down, across, 1))[:height, :width])


@cache
def _floor_tile() -> Pixels:
    return images.load_image(ASSETS / "floor.jpg")


def _adjusted(adjust_background: Callable[[Pixels], Pixels], shown: Pixels) -> Pixels:
    """Return the image that the callback returns, checked."""
    place = ("adjust_background", "the callback adjust_background", -1, adjust_background)
    try:
        adjusted = adjust_background(shown.copy())
    except BaseException as error:
        failed(error, *place)
        raise
    expected = f"the result must be a uint8 array of shape {shown.shape}"
    if not isinstance(adjusted, np.ndarray):
        raise refused(TypeError(f"{expected}, got {quoted(adjusted)}"), *place)
    if adjusted.dtype != np.uint8 or adjusted.shape != shown.shape:
        came = f"{adjusted.dtype} of shape {adjusted.shape}"
        raise refused(ValueError(f"{expected}, got {came}"), *place)
    return adjusted


def robot_sprite(robot: RobotDefinition, scale: float) -> tuple[Pixels, tuple[float, float], float]:
    """Return the robot's sprite (h, w, 4), uint8 RGBA, its centre u, v (px) and its pixel width.

    `scale` is camera pixels per work-area px; the width of a sprite pixel is in work-area px.
    """
    height, width = robot.image.shape[:2]
    small_width = max(1, round(robot.size * scale))
    small_height = max(1, round(robot.size * scale * height / width))
    sprite = images.resized(robot.image, small_width, small_height)
    assert robot.centre is not None
    centre = (
        (robot.centre[0] + 0.5) * small_width / width - 0.5,
        (robot.centre[1] + 0.5) * small_height / height - 0.5,
    )
    return sprite, centre, robot.size / small_width
