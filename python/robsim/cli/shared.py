"""Options that several commands share, such as --robot, --colors and --noise."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np

from robsim.base.checks import check_choice, check_float
from robsim.cli import errors
from robsim.cli.text import about, parse_points
from robsim.control.by_name import NAMES, POINTS
from robsim.simulation.option import Choice, Number, Option, Size, Switch, Whole
from robsim.simulation.options import OPTIONS

if TYPE_CHECKING:
    from robsim._core import PlaneMap


# The names are written out where --help must show points, too.
_CONTROLS = ", ".join(
    f"{name}:X,Y" if POINTS.get(name) else f"{name}:'X,Y X,Y ...'" if name in POINTS else name
    for name in NAMES
)

#: The shell's form of the options of a world: its type, what --help shows, a remark.
_FORMS: dict[str | type[Option], tuple[type, str, str]] = {
    Number: (float, "NUMBER", ""),
    Whole: (int, "N", ""),
    Size: (str, "WxH", ""),
    Choice: (str, "WORD", ""),
    Switch: (bool, "", ""),
    "robot": (str, "NAME|FOLDER", ""),
    "headings": (str, "N", ""),
    "noise": (str, "KIND:PERCENT", "Examples: gaussian:10, uniform:10."),
    "dropout": (str, "PROBABILITY[:STEPS]", "0.2:5 means probability 0.2, 5 steps at a time."),
    "start": (str, "X,Y,DEGREES", ""),
    "seed": (int, "N", ""),
    "colors": (str, "FILE", ""),
    "markers": (str, "NAME|FOLDER", ""),
    "control": (
        str,
        "NAME[:POINTS]",
        f"A built-in controller replaces the controller of the folder: {_CONTROLS}. Points are in "
        "px, and a controller with points switches --measure on.",
    ),
}
# Texts of the options whose values differ in the shell.
_TEXTS = {
    "robot": "Name of a robot, or a folder with a robot.toml. Default: the choice of robsim "
    "robots use, initially lab.",
    "headings": "Number of headings in which the robot is drawn, at whole pixels. Or continuous: "
    "the robot is drawn at its exact pose.",
    "start": "The initial pose: x, y (px), heading (degrees, clockwise), such as 300,300,90, or "
    "random. Default: the centre of the area, facing right.",
    "seed": "Seed of all random numbers of the run. Default: a different seed in each run.",
    "colors": "File of the colours to detect. Default: red and blue as shipped with robsim.",
    "markers": "Robot with the markers of the default measurement. Default: the robot of --robot.",
}

#: The rows of options that the shell has.
WORLD = {name: row for name, row in OPTIONS.items() if {name, type(row)} & {*_FORMS}}


def entry_of(name: str) -> str:
    """Return the line for an option of the world, with the text of its row or ours."""
    row = OPTIONS[name]
    _, form, remark = _FORMS.get(name) or _FORMS[type(row)]
    limits = row.limits and f"{row.limits} {row.unit}".strip() + "."
    default = f"Default: {row.default}." if isinstance(row, (Number, Whole, Choice)) else ""
    words = (_TEXTS.get(name) or re.sub(r'[`"]', "", row.doc), limits, remark, default)
    text = " ".join(filter(None, words)).removesuffix(" Default: None.")
    return f"--{name.replace('_', '-')} {form}".rstrip() + f": {text}"


def kind_of(name: str) -> type:
    return (_FORMS.get(name) or _FORMS[type(OPTIONS[name])])[0]


Callbacks = Annotated[Path | None, "FOLDER: Folder with your callbacks."]
Robot = Annotated[str | None, entry_of("robot")]
Colors = Annotated[Path | None, entry_of("colors")]
Smoothing = Annotated[int | None, entry_of("smoothing")]
Noise = Annotated[str | None, entry_of("noise")]
Seed = Annotated[int | None, entry_of("seed")]
Area = Annotated[str | None, "--area WxH: Work area in px. Default: the size of the frames."]
Pixels = Annotated[
    str | None,
    "--pixels POINTS: Four or more points in the frames, in px, such as '0,0 639,0 639,479 0,479'.",
]
Positions = Annotated[
    str | None,
    "--positions POINTS: Positions of the same points on the work area, in px: x to the right, y "
    "down. For mm, use robsim calibrate floor.",
]
CalibrationFile = Annotated[
    Path | None,
    "--calibration FILE: Calibration of the camera, from robsim calibrate floor.",
]
ScenarioFile = Annotated[
    Path | None,
    "--scenario FILE: TOML file of a scenario, from Scenario.save; other options change it.",
]
Unit = Annotated[str, "--unit UNIT: Unit of lengths in the results and figures: px, mm, cm or m."]
Scale = Annotated[
    float | None, "--scale MM: With --unit: length on the floor of 1 px of the work area, in mm."
]
CallLimit = Annotated[
    float | None,
    "--time-limit SECONDS: Maximum time of each call of your callbacks. Default: no limit.",
]
Jobs = Annotated[int, "--jobs N: Number of processes."]
#: As many as there are cores, unless it is given.
AllJobs = Annotated[
    int | None, "--jobs N: Number of processes. Default: the number of available cores."
]
Out = Annotated[Path, "--out FOLDER: Folder for the results."]
Json = Annotated[bool, "--json: Print only the numbers, as JSON."]


def check_unit(
    unit: str, scale: float | None, calibration: Path | None = None, *, is_simulated: bool = False
) -> None:
    """Raise an error unless lengths can be given in a unit."""
    from robsim.trace.units import UNITS
    from robsim.vision.imaging.calibration_file import load_calibration

    with about("--unit"):
        check_choice("unit", unit, UNITS)
    if scale is not None:
        with about("--scale"):
            check_float("scale", scale, "mm", minimum=1e-3, maximum=1e4)
        if unit == "px":
            raise ValueError("--scale is for lengths in mm, cm or m: add --unit mm")
        if calibration is not None:
            raise ValueError("--scale and --calibration both set the length of a px: give only one")
    elif unit != "px":
        known = load_calibration(calibration).mm_per_px if calibration is not None else None
        if known is None:
            other = "" if is_simulated else ", or a --calibration with this length"
            raise ValueError(
                f"--unit {unit} needs the length of a px on the floor: give --scale MM, in "
                f"mm{other}"
            )


def engine_of(jobs: int | None) -> int | None:
    """Return the executor of a number of processes; None = the number of cores."""
    if jobs is None:
        from robsim.campaigns.engines.engine import processors

        jobs = processors()
    if jobs < 1:
        raise ValueError(f"--jobs must be at least 1, got {jobs}")
    return jobs if jobs > 1 else None


def earlier_run(out: Path) -> str | None:
    """Return the remark that a folder's earlier results will be replaced, or None."""
    from robsim.cli.results import TRACE

    if (out / TRACE).exists():
        return f"the earlier run in {out} is replaced; --out selects another folder"
    return None


def parse_plane_map(pixels: str | None, positions: str | None) -> PlaneMap | None:
    """Return the map of the options --pixels and --positions; None if they are absent.

    A note gives its error at the points, or says that four points are not checked.
    """
    from robsim._core import PlaneMap

    if (pixels is None) != (positions is None):
        raise ValueError("--pixels and --positions belong together: give both or neither")
    seen = parse_points("--pixels", pixels, minimum=4)
    placed = parse_points("--positions", positions, minimum=4)
    if not (seen and placed):
        return None
    plane_map = PlaneMap.from_points(seen, placed)
    if len(seen) > 4:
        distances = np.linalg.norm(plane_map.to_world(seen) - np.array(placed), axis=1)
        worst = int(np.argmax(distances))
        errors.print_note(
            f"the {len(seen)} points fit within {distances[worst]:.1f} px of the work area (number "
            f"{worst + 1}), rms {np.sqrt((distances**2).mean()):.1f} px"
        )
    else:
        errors.print_note(
            "the 4 points are not checked: they fit exactly, right or wrong; add a fifth point"
        )
    return plane_map
