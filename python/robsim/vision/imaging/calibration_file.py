"""Calibrations as TOML files: exact, and checked key by key when they are read."""

from __future__ import annotations

import re
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from robsim._core import Intrinsics, PlaneMap
from robsim.base.checks import as_float_array
from robsim.base.files import as_path, read_toml, write_whole
from robsim.base.text import one_line, quoted
from robsim.vision.imaging.calibration import Calibration, Residuals

if TYPE_CHECKING:
    from tomlkit.items import Table

_FORMAT = 1
_HEADER = (
    "A camera that was calibrated by robsim: its lens, and how it looks at the floor.",
    "It holds as long as the camera, its lens and its size of frames stay as they are. Give it to",
    "robsim live --calibration, robsim track --calibration, or robsim.Camera(calibration=...).",
)
_TABLES = {
    "": ("format", "date", "frames", "lens", "floor", "features", "marks"),
    "frames": ("size", "region"),
    "lens": ("matrix", "distortion", "rms", "worst", "points", "pictures"),
    "floor": (
        *("area", "mm_per_px", "marker_height", "matrix", "rms", "worst", "points", "pictures"),
    ),
}
_COMMENTS = {
    "size": "width and height (px)",
    "region": "of the sensor: left, top, width, height (px)",
    "distortion": "k1, k2, p1, p2, k3",
    "area": "the work area: width and height (px)",
    "mm_per_px": "a px of the work area on the floor (mm)",
    "marker_height": "of the robot's markers above the floor (mm)",
    "rms": "how well it fits: root mean square (px of the frame)",
    "worst": "the largest (px of the frame)",
}
_LONGEST_NUMBER = 10  # digits; Python refuses to read thousands of them
_NUMBER = re.compile("0|[1-9][0-9]*")  # 01 would be another name of 1
_RESIDUALS = ("rms", "worst", "points", "pictures")


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
    """Return the calibration that an argument stands for, with a floor; None is none.

    Raises
    ------
    OSError, TypeError, ValueError
        If it is none, its file cannot be read, or a plane map is given, too.
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
    import tomlkit  # it costs milliseconds

    document = tomlkit.document()
    for line in _HEADER:
        document.add(tomlkit.comment(line))
    document.add("format", tomlkit.item(_FORMAT))
    if one.date is not None:
        document.add("date", tomlkit.item(one.date))
    frames = {"size": list(one.size), "region": one.region and list(one.region)}
    document.add("frames", _table(frames, "What it is a calibration of."))
    if one.intrinsics is not None:
        lens = {
            "matrix": np.asarray(one.intrinsics.matrix).tolist(),
            "distortion": np.asarray(one.intrinsics.distortion).tolist(),
            **_as_dict(one.lens_residuals),
        }
        said = "Focal lengths and centre (px), then how the lens distorts, as OpenCV has it."
        document.add("lens", _table(lens, said))
    if one.floor is not None:
        floor = {
            "area": list(one.area or ()),
            "mm_per_px": one.mm_per_px,
            "marker_height": one.marker_height,
            "matrix": one.floor.matrix.tolist(),
            **_as_dict(one.floor_residuals),
        }
        said = (
            "The matrix takes (u, v, 1) of an ideal lens to (x, y, 1) on the floor, times a number."
        )
        document.add("floor", _table(floor, said))
    if one.features:
        document.add("features", _table(one.features, "Settings of the camera."))
    if one.marks:
        said = "Where the frames showed the floor sheets' marks, by their numbers: u, v (px)."
        document.add("marks", _table({str(n): [*at] for n, at in one.marks.items()}, said))
    return tomlkit.dumps(document)


def _table(values: Any, comment: str) -> Table:
    import tomlkit

    table = tomlkit.table()
    table.add(tomlkit.comment(comment))
    for key, value in values.items():
        if value is None:
            continue
        item = tomlkit.item(value)
        if isinstance(value, list) and isinstance(value[0], list):
            item.multiline(True)
        elif key in _COMMENTS:
            item.comment(_COMMENTS[key])
        table.add(key, item)
    return table


def _as_dict(residuals: Residuals | None) -> dict[str, Any]:
    return {} if residuals is None else {name: getattr(residuals, name) for name in _RESIDUALS}


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
    file = as_path(path)
    table = read_toml(file)
    try:
        return _read(table)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{one_line(file)}: {one_line(error)}") from error


def _read(table: dict[str, Any]) -> Calibration:
    if table.get("format") != _FORMAT or table["format"] is True:
        raise ValueError(
            f"format must be {_FORMAT}, got {quoted(table.get('format'))}: is it a calibration "
            "that robsim wrote?"
        )
    _check_keys("", table)
    frames = _subtable(table, "frames") or {}
    if "size" not in frames:
        raise ValueError("frames must have size")
    lens, floor = _subtable(table, "lens"), _subtable(table, "floor")
    intrinsics = None if lens is None else _intrinsics("lens", lens)
    if floor is not None:
        _need("floor", floor, "area", "matrix")
    return _named(
        {
            "size": ("frames.size", frames["size"]),
            "region": ("frames.region", frames.get("region")),
            "area": ("floor.area", (floor or {}).get("area")),
            "mm_per_px": ("floor.mm_per_px", (floor or {}).get("mm_per_px")),
            "marker_height": ("floor.marker_height", (floor or {}).get("marker_height", 0.0)),
            "date": ("date", table.get("date")),
            "features": ("features", table.get("features", {})),
            "marks": ("marks", _marks(table.get("marks", {}))),
        },
        intrinsics=intrinsics,
        floor=None if floor is None else _plane_map("floor", floor),
        lens_residuals=_residuals("lens", lens),
        floor_residuals=_residuals("floor", floor),
    )


def _named(values: dict[str, tuple[str, Any]], **others: Any) -> Calibration:
    """Return a calibration; an error in a value speaks of its key in the file."""
    try:
        return Calibration(**{name: value for name, (_, value) in values.items()}, **others)
    except (TypeError, ValueError) as error:
        text = str(error)
        for name, (key, _) in values.items():
            if text.startswith(f"{name} must"):
                raise ValueError(text.replace(name, key, 1)) from error
        raise


def _subtable(table: dict[str, Any], name: str) -> dict[str, Any] | None:
    value = table.get(name)
    if value is None:
        return None
    if not isinstance(value, dict):
        raise TypeError(f"{name} must be a table, got {quoted(value)}")
    _check_keys(name, value)
    return value


def _check_keys(name: str, table: dict[str, Any]) -> None:
    if unknown := [key for key in table if key not in _TABLES[name]]:
        where = f"{name} must have only the keys" if name else "it must have only the keys"
        raise ValueError(f"{where} {', '.join(_TABLES[name])}, got {quoted(unknown[0])}")


def _marks(table: Any) -> Any:
    """Return the table with numbers as keys; what is none stays as it is, to be refused."""
    if not isinstance(table, dict):
        return table
    return {
        int(key) if len(key) < _LONGEST_NUMBER and _NUMBER.fullmatch(key) else key: value
        for key, value in table.items()
    }


def _need(name: str, table: dict[str, Any], *keys: str) -> None:
    for key in keys:
        if key not in table:
            raise ValueError(f"{name} must have {key}")


def _intrinsics(name: str, table: dict[str, Any]) -> Intrinsics:
    _need(name, table, "matrix", "distortion")
    matrix = _numbers(f"{name}.matrix", table["matrix"], (3, 3))
    distortion = _numbers(f"{name}.distortion", table["distortion"], (5,))
    try:
        return Intrinsics(matrix, distortion=distortion.tolist())
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}.{error}") from error


def _plane_map(name: str, table: dict[str, Any]) -> PlaneMap:
    matrix = _numbers(f"{name}.matrix", table["matrix"], (3, 3))
    try:
        return PlaneMap(matrix)
    except ValueError as error:
        raise ValueError(f"{name}.{error}") from error


def _numbers(name: str, value: Any, shape: tuple[int, ...]) -> Any:
    size = " x ".join(map(str, shape))
    expected = f"{name} must be {size} finite numbers, got {quoted(value)}"
    try:
        array = as_float_array(name, value)
    except TypeError:
        raise TypeError(expected) from None
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(expected)
    return array


def _residuals(name: str, table: dict[str, Any] | None) -> Residuals | None:
    if table is None or not any(key in table for key in _RESIDUALS):
        return None
    _need(name, table, *_RESIDUALS)
    try:
        return Residuals(**{key: table[key] for key in _RESIDUALS})
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}.{error}") from error
