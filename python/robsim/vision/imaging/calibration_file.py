"""Calibrations as TOML files: exact, with checks of each key on reading."""

from __future__ import annotations

import re
from os import PathLike
from typing import Any

from robsim._core import Intrinsics, PlaneMap
from robsim.base.checks import check_float, check_kind, check_mm_per_px, check_size
from robsim.base.files import as_path, codec, write_whole
from robsim.base.text import one_line, quoted
from robsim.vision.imaging.calibration import Calibration, Residuals, check_region

_FORMAT = 1
_HEADER = """\
A camera that was calibrated by robsim: its lens, and how it looks at the floor.
It holds as long as the camera, its lens and its size of frames stay as they are. Give it to
robsim live --calibration, robsim track --calibration, or robsim.Camera(calibration=...)."""
_MARKS = "Where the frames showed the floor sheets' marks, by their numbers: u, v (px)."
_NUMBER = re.compile("0|[1-9][0-9]{0,8}")  # 01 would be another name of 1


_MATRIX = codec.Entry("", write=codec.rows)
#: A lens, and the map of a plane with one, as files have them.
INTRINSICS = codec.Table(
    Intrinsics, {"matrix": _MATRIX, "distortion": "k1, k2, p1, p2, k3"}, needed=("distortion",)
)
PLANE_MAP = codec.Table(PlaneMap, {"matrix": _MATRIX, "intrinsics": INTRINSICS}, needed=("matrix",))
_RESIDUALS = codec.Table(
    Residuals,
    {
        "rms": "how well it fits: root mean square (px of the frame)",
        "worst": "the largest (px of the frame)",
        "points": "",
        "pictures": "",
    },
)
_FRAMES = codec.Table(
    codec.together,
    {
        "size": codec.Entry("width and height (px)", check_size),
        "region": codec.Entry("of the sensor: left, top, width, height (px)", check_region),
    },
    "What" + " it is a calibration of.",  # kept files have these words
    needed=("size",),
)


def _residuals(given: dict[str, Any]) -> Residuals | None:
    return _RESIDUALS.read("residuals", given) if given else None


def _lens(matrix: Any, distortion: Any, **residuals: Any) -> dict[str, Any]:
    lens = Intrinsics(matrix, distortion=distortion)
    return {"intrinsics": lens, "lens_residuals": _residuals(residuals)}


def _floor(matrix: Any, area: Any, **given: Any) -> dict[str, Any]:
    residuals = {name: given.pop(name) for name in _RESIDUALS.keys if name in given}
    floor = {"floor": PlaneMap(matrix), "floor_residuals": _residuals(residuals)}
    return given | floor | {"area": area}


_LENS = codec.Table(
    _lens,
    {**INTRINSICS.keys, **_RESIDUALS.keys},
    "Focal lengths and centre (px), then how the lens distorts, as OpenCV has it.",
    parts=lambda one: one.intrinsics and (one.intrinsics, one.lens_residuals),
)
_FLOOR = codec.Table(
    _floor,
    {
        "area": codec.Entry("the work area: width and height (px)", check_size),
        "mm_per_px": codec.Entry(
            "a px of the work area on the floor (mm)", lambda _, value: check_mm_per_px(value)
        ),
        "marker_height": codec.Entry("of the robot's markers above the floor (mm)", check_float),
        "matrix": _MATRIX,
        **_RESIDUALS.keys,
    },
    "The matrix takes (u, v, 1) of an ideal lens to (x, y, 1) on the floor, times a number.",
    parts=lambda one: one.floor and (one, one.floor, one.floor_residuals),
)


def _read_marks(name: str, value: Any) -> dict[Any, Any]:
    """Return a table with numbers as keys; another key stays, to be refused."""
    table = codec.as_table(name, value)
    return {int(key) if _NUMBER.fullmatch(key) else key: pixel for key, pixel in table.items()}


def _calibration(
    format: int, frames: Any, lens: Any = (), floor: Any = (), **others: Any
) -> Calibration:
    return Calibration(**frames, **dict(lens), **dict(floor), **others)


_FILE = codec.Table(
    _calibration,
    {
        "format": "",
        "date": codec.date,
        "frames": _FRAMES,
        "lens": _LENS,
        "floor": _FLOOR,
        "features": codec.named("", said="Settings of the camera."),
        "marks": codec.Entry("", _read_marks, codec.named("", said=_MARKS).write),
    },
    _HEADER,
    parts=lambda one: (
        {"format": _FORMAT, "frames": one, "lens": one, "floor": one},
        {"date": one.date, "features": one.features or None, "marks": one.marks or None},
    ),
)


def save_calibration(path: str | PathLike[str], calibration: Calibration) -> None:
    """Write a calibration as a human-readable TOML file.

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

    Examples
    --------
    >>> lens = robsim.vision.Intrinsics([[800, 0, 319.5], [0, 800, 239.5], [0, 0, 1]])
    >>> calibration = robsim.vision.Calibration(size=(640, 480), intrinsics=lens)
    >>> robsim.vision.save_calibration("ceiling.toml", calibration)
    >>> robsim.vision.load_calibration("ceiling.toml").size
    (640, 480)
    """
    file = as_path(path)
    check_kind("calibration", calibration, Calibration)
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
        raise ValueError("calibration and plane_map both map the pixels: give only one of them")
    if isinstance(value, (str, PathLike)):
        value = load_calibration(value)
    if not isinstance(value, Calibration):
        raise TypeError(f"calibration must be a Calibration or a path, got {quoted(value)}")
    value.check_floor()
    return value


def calibration_text(one: Calibration) -> str:
    """Return the file of a calibration."""
    return str(_FILE.write(one).as_string())


def load_calibration(path: str | PathLike[str]) -> Calibration:
    """Read a calibration written by `save_calibration`.

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
        If the file does not exist.
    TypeError
        If `path` is not a path.
    ValueError
        If the file is no calibration, or is damaged; the message names file and key, the expected
        and the actual value.

    Examples
    --------
    >>> lens = robsim.vision.Intrinsics([[800, 0, 319.5], [0, 800, 239.5], [0, 0, 1]])
    >>> calibration = robsim.vision.Calibration(size=(640, 480), intrinsics=lens)
    >>> robsim.vision.save_calibration("ceiling.toml", calibration)
    >>> robsim.vision.load_calibration("ceiling.toml").intrinsics.matrix[0].tolist()
    [800.0, 0.0, 319.5]
    """
    return codec.load_table(path, _read)  # type: ignore[no-any-return]


def _read(table: dict[str, Any]) -> Calibration:
    codec.check_format(table, _FORMAT)
    return _FILE.read("calibration", table)  # type: ignore[no-any-return]
