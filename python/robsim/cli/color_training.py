"""The command ``robsim colors train``: colours from regions of images, or from a recording."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robsim._core import ColorClass, Frame, Observation, color_histograms
from robsim.base.text import quoted
from robsim.cli import errors
from robsim.cli.shared import Area, CalibrationFile, Colors, Robot
from robsim.cli.text import Region, parse_region, parse_size
from robsim.vision.imaging.images import Pixels, image_suffixes, load_image
from robsim.vision.markers.color_files import colors_to_toml, save_colors
from robsim.vision.markers.training import train_color, train_markers
from robsim.vision.robots.lookup import load_robot

if TYPE_CHECKING:
    from robsim.trace.sessions.session import Session
    from robsim.vision.imaging.recordings import Recording


def train(
    frames: list[Path],
    regions: list[str] | None = None,
    name: str | None = None,
    robot: Robot = None,
    colors: Colors = None,
    area: Area = None,
    calibration: CalibrationFile = None,
    to: Path | None = None,
    margin: int | None = None,
    limit_y: bool = False,
    figure: Path | None = None,
) -> None:
    """Find the ranges of a colour in images, or the ranges of a robot's markers in a recording.

    With images, give one --region per image, and the --name of the colour; image viewers show pixel
    positions. With a recording of the driving robot, the command trains the markers along the whole
    path, in the light of the whole floor. The command prints the ranges in the format of a colour
    file, and the drift of level and chroma from frame to frame. --to writes the ranges to a file,
    and keeps the other colours in the file.

    FRAMES: Images, or one recording: a video, a folder of images, a session.
    --region [NAME=]L,T,R,B: Box in px around pixels of the colour: left,top,right,bottom. Give one
        box per image. For a recording, give red=L,T,R,B and blue=L,T,R,B in the first frame if
        --colors fail to find the robot. Can be repeated.
    --name NAME: For images: name of the colour, such as red.
    --to FILE: Colour file to write to; created if needed.
    --margin LEVELS: Widening of the ranges found, in levels of 0..255. Default: 52.
    --limit-y: For images: also limit the brightness Y, as needed for black and white.
    --figure FILE: For images: file for the histograms, such as red.png.

    Example: robsim colors train frame.png --region 578,613,594,630 --name red --to colors.toml
    """
    from robsim.cli.results import check_figure_name, check_file

    if to:
        check_file(to)
    if name is None:
        _check_for_a_recording(frames, limit_y, figure)
        source = _recording(frames[0], area, calibration)
        markers = load_robot(robot).marker_layout()
        if regions and colors is not None:
            raise ValueError("--colors and --region must not both be given for a recording")
        seen = _regions_of_markers(regions, [*markers.colors.values()]) if regions else None
        trained = [*train_markers(source, markers, colors=colors, regions=seen, margin=margin)]
    else:
        others = {"robot": robot, "colors": colors, "area": area, "calibration": calibration}
        for other, value in others.items():
            if value is not None:
                raise ValueError(
                    f"--{other} is for a recording, but --name is for images: leave one out"
                )
        if figure:
            check_figure_name(figure)
            check_file(figure)
        images = [load_image(image) for image in frames]
        boxes = _regions_of_images(images, regions or [])
        trained = [train_color(images, boxes, name=name, margin=margin, limit_y=limit_y)]
        if figure:
            _write_histograms(figure, trained[0].color, trained[0].histograms, images, frames)
    if to:
        save_colors(to, [one.color for one in trained])
    errors.show(colors_to_toml([one.color for one in trained]))
    if len(frames) > 1 or name is None:
        for one in trained:
            errors.show("\n".join(f"# {line}".rstrip() for line in str(one).splitlines()) + "\n")
    for file, what in ((to, "written to"), (figure, "histograms in")):
        if file:
            errors.say(f"{what} {file}")


def _check_for_a_recording(frames: Sequence[Path], limit_y: bool, figure: Path | None) -> None:
    """Raise ValueError unless the arguments fit a recording."""
    are_images = all(frame.suffix.lower() in image_suffixes() for frame in frames)
    if are_images or len(frames) > 1:
        raise ValueError(
            "frames must be one recording (a video, folder or session), or images with --name and "
            f"one --region per image, got {quoted(str(frames[0]))}"
        )
    for name, value in (("--limit-y", limit_y), ("--figure", figure)):
        if value:
            raise ValueError(f"{name} is for images with --name, not for a recording")


def _recording(
    source: Path, area: str | None, calibration: Path | None
) -> Recording | Session | Iterable[Frame | Observation]:
    from robsim.trace.sessions.session import Session
    from robsim.vision.imaging.recordings import Recording

    if not Session._is_in(source):
        return Recording(source, area=parse_size("--area", area), calibration=calibration)
    for name, value in (("--area", area), ("--calibration", calibration)):
        if value is not None:
            raise ValueError(f"{name} is already in the session: leave it out")
    return Session(source)


def _regions_of_markers(texts: Sequence[str], names: Sequence[str]) -> dict[str, Region]:
    """Return the regions of both markers from texts such as red=578,613,594,630."""
    regions = {}
    first, second = names
    for text in texts:
        name, _, box = text.rpartition("=")
        if name not in names or name in regions:
            raise ValueError(
                f"--region must be given once for {first} and once for {second} in the first frame "
                f"of a recording, such as {first}=578,613,594,630, got {quoted(text)}"
            )
        regions[name] = parse_region("--region", box)
    if len(regions) == 1:
        raise ValueError(
            f"--region must be given for both {first} and {second}, got only {quoted(texts[0])}"
        )
    return regions


def _regions_of_images(images: Sequence[Pixels], texts: Sequence[str]) -> list[Region]:
    regions = [parse_region("--region", text) for text in texts]
    if not regions or (len(images) > 1 and len(images) != len(regions)):
        raise ValueError(
            f"--region must be given once for each of the {len(images)} images, in the order of "
            f"the images, got {len(regions)} regions"
        )
    return regions


def _write_histograms(
    file: Path,
    color: ColorClass,
    histograms: NDArray[np.int64],
    images: Sequence[Pixels],
    names: Sequence[Path],
) -> None:
    from robsim.cli.results import save_figure
    from robsim.plotting import plot_color_histograms

    whole = np.sum(
        [color_histograms(p, (0, 0, p.shape[1] - 1, p.shape[0] - 1)) for p in images], axis=0
    )
    picture = ", ".join(name.name for name in names)
    figure = plot_color_histograms(histograms, color, others=whole, picture=picture)
    save_figure(file, figure)
