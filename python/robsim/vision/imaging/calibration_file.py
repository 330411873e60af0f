"""Calibrations as TOML files: exact, and checked key by key when they are read."""

from __future__ import annotations

import re
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from robsim._core import Intrinsics, PlaneMap
from robsim.base.checks import check_mm_per_px, check_size
from robsim.base.files import as_path, codec, write_whole
from robsim.base.text import one_line, quoted
from robsim.vision.imaging.calibration import Calibration, Residuals, check_region

_FORMAT = 1
_HEADER = (
    "A camera that was calibrated by robsim: its lens, and how it looks at the floor.",
    "It holds as long as the camera, its lens and its size of frames stay as they are. Give it to",
    "robsim live --calibration, robsim track --calibration, or robsim.Camera(calibration=...).",
)
_LONGEST_NUMBER = 10  # digits; Python refuses to read thousands of them
_NUMBER = re.compile("0|[1-9][0-9]*")  # 01 would be another name of 1


def _rows(array: Any) -> Any:
    import tomlkit

    return tomlkit.item(np.asarray(array).tolist()).multiline(True)


_MATRIX = codec.Entry(codec.array(3, 3), "", _rows, is_needed=True)
_DISTORTION = codec.Entry(codec.array(5), "k1, k2, p1, p2, k3", is_needed=True)
#: A lens, and the map of a plane with one, as files have them.
INTRINSICS = codec.Table(Intrinsics, {"matrix": _MATRIX, "distortion": _DISTORTION})
_CAMERA = codec.Entry(INTRINSICS.read, "", INTRINSICS.write, is_needed=True)
PLANE_MAP = codec.Table(PlaneMap, {"matrix": _MATRIX, "intrinsics": _CAMERA})
_RESIDUALS = {
    "rms": codec.Entry(codec.anything, "how well it fits: root mean square (px of the frame)"),
    "worst": codec.Entry(codec.anything, "the largest (px of the frame)"),
} | dict.fromkeys(("points", "pictures"), codec.Entry(codec.anything))
_MARKS = "Where the frames showed the floor sheets' marks, by their numbers: u, v (px)."
_FRAMES = codec.Table(
    dict,
    {
        "size": codec.Entry(check_size, "width and height (px)", is_needed=True),
        "region": codec.Entry(check_region, "of the sensor: left, top, width, height (px)"),
    },
    "What" + " it is a calibration of.",  # kept files have these words
)


def _lens(matrix: Any, distortion: Any, **residuals: Any) -> dict[str, Any]:
    intrinsics = Intrinsics(matrix, distortion=distortion.tolist())
    return {"intrinsics": intrinsics, "lens_residuals": _residuals(residuals)}


def _floor(matrix: Any, **given: Any) -> dict[str, Any]:
    residuals = {name: given.pop(name) for name in _RESIDUALS if name in given}
    return given | {"floor": PlaneMap(matrix), "floor_residuals": _residuals(residuals)}


def _residuals(given: dict[str, Any]) -> Residuals | None:
    missing = [name for name in _RESIDUALS if name not in given]
    if given and missing:
        raise ValueError(f"{missing[0]} is missing")
    return Residuals(**given) if given else None


_LENS = codec.Table(
    _lens,
    INTRINSICS.keys | _RESIDUALS,
    "Focal lengths and centre (px), then how the lens distorts, as OpenCV has it.",
)
_FLOOR = codec.Table(
    _floor,
    {
        "area": codec.Entry(check_size, "the work area: width and height (px)", is_needed=True),
        "mm_per_px": codec.Entry(
            lambda _, value: check_mm_per_px(value), "a px of the work area on the floor (mm)"
        ),
        "marker_height": codec.Entry(codec.number, "of the robot's markers above the floor (mm)"),
        "matrix": _MATRIX,
        **_RESIDUALS,
    },
    "The matrix takes (u, v, 1) of an ideal lens to (x, y, 1) on the floor, times a number.",
)


def _calibration(
    *, format: int, frames: Any, lens: Any = (), floor: Any = (), **others: Any
) -> Calibration:
    return Calibration(**frames, **dict(lens), **dict(floor), **others)


def _marks(name: str, value: Any) -> dict[Any, Any]:
    """Return a table with numbers as keys; another key stays, to be refused."""
    return {
        int(key) if len(key) < _LONGEST_NUMBER and _NUMBER.fullmatch(key) else key: pixel
        for key, pixel in codec.as_table(name, value).items()
    }


def _any_keys(said: str, values: dict[str, Any]) -> Any:
    return codec.Table(dict, dict.fromkeys(values, codec.Entry(codec.anything)), said).write(values)


_FILE = codec.Table(
    _calibration,
    {
        "format": codec.Entry(codec.anything),
        "date": codec.Entry(codec.date),
        "frames": codec.Entry(_FRAMES.read, "", _FRAMES.write, is_needed=True),
        "lens": codec.Entry(_LENS.read, "", _LENS.write),
        "floor": codec.Entry(_FLOOR.read, "", _FLOOR.write),
        "features": codec.Entry(codec.anything, "", partial(_any_keys, "Settings of the camera.")),
        "marks": codec.Entry(_marks, "", partial(_any_keys, _MARKS)),
    },
)


def save_calibration(path: str | PathLike[str], calibration: Calibration) -> None:
    """Write a calibration as a TOML file, which people can read.

    Parameters
    ----------
    path : path
        The file to write, such as ``camera.toml``.
    calibration : Calibration
        The calibration.

    Raises
    ------
    OSError
        If the file cannot be written.
    TypeError, ValueError
        If an argument has another type, or the name of the file does not end in ``.toml``.
    """
    file = as_path(path)
    if not isinstance(calibration, Calibration):
        raise TypeError(f"calibration must be a Calibration, got {quoted(calibration)}")
    if file.suffix.lower() != ".toml":
        raise ValueError(f"{one_line(file)}: the name of a calibration must end in .toml")
    write_whole(file, calibration_text(calibration).encode())


def as_calibration(value: Any, plane_map: PlaneMap | None = None) -> Calibration | None:
    """Return an argument's calibration, with a floor; None stays None.

    ValueError or OSError: it is invalid, its file cannot be read, or a plane map is given, too.
    """
    if value is None:
        return None
    if plane_map is not None:
        raise ValueError("calibration and plane_map both map the pixels: give one of them")
    if isinstance(value, (str, PathLike)):
        value = load_calibration(value)
    if not isinstance(value, Calibration):
        raise TypeError(f"calibration must be a Calibration or a path, got {quoted(value)}")
    value.check_floor()
    return value


def calibration_text(one: Calibration) -> str:
    """Return the file of a calibration."""
    values = {
        "format": _FORMAT,
        "date": one.date,
        "frames": one,
        "lens": one.intrinsics
        and {
            "matrix": one.intrinsics.matrix,
            "distortion": one.intrinsics.distortion,
            **_numbers_of(one.lens_residuals),
        },
        "floor": one.floor
        and {**vars(one), "matrix": one.floor.matrix, **_numbers_of(one.floor_residuals)},
        "features": one.features or None,
        "marks": {str(mark): [*at] for mark, at in one.marks.items()} or None,
    }
    return "".join(f"# {line}\n" for line in _HEADER) + str(_FILE.write(values).as_string())


def _numbers_of(residuals: Residuals | None) -> dict[str, Any]:
    return {} if residuals is None else vars(residuals)


def load_calibration(path: str | PathLike[str]) -> Calibration:
    """Read a calibration that `save_calibration` wrote.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    Calibration
        The calibration.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    TypeError
        If `path` is no path.
    ValueError
        If it is no calibration, or is damaged; the message names file and key, what was expected
        and what came.
    """
    return codec.load_table(path, _read)  # type: ignore[no-any-return]


def _read(table: dict[str, Any]) -> Calibration:
    codec.check_format(table, _FORMAT, hint="is it a calibration that robsim wrote?")
    return _FILE.read("calibration", table)  # type: ignore[no-any-return]
