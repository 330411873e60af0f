"""The commands ``robsim colors``: show, train and test colour classes, draw a test image."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from robsim._core import ColorClass, classify, find_blobs
from robsim.base.checks import Floats, check_float
from robsim.base.text import quoted
from robsim.cli import color_training, errors
from robsim.cli.command import command, command_group
from robsim.cli.shared import Colors, Json, Noise, Robot, Seed
from robsim.cli.text import Region, parse_noise, parse_point, parse_region
from robsim.simulation import Simulation
from robsim.vision.imaging.images import Pixels, load_image, save_image
from robsim.vision.markers.color_files import colors_to_toml, load_colors
from robsim.vision.markers.color_score import score_color
from robsim.vision.markers.painting import paint_classes
from robsim.vision.robots.polygons import inner_box, placed

HELP = (
    "A colour class is a name with ranges of Y (brightness), U and V; a colour file contains "
    "several. Most commands accept a colour file: --colors FILE."
)
app = command_group("Start with: robsim colors frame")

Images = Annotated[list[Path], "IMAGE: Image files."]


@command(app)
def frame(
    file: Path = Path("frame.png"),
    robot: Robot = None,
    at: str | None = None,
    heading: float = 0.0,
    noise: Noise = None,
    seed: Seed = None,
) -> None:
    """Write an image of the simulated robot, to train and test colours.

    The command also prints the regions of the robot's markers.

    FILE: The image to write.
    --at X,Y: Position of the robot in px. Default: the centre.
    --heading DEGREES: Heading in degrees, clockwise from facing right.

    Example: robsim colors frame frame.png
    """
    x, y = parse_point("--at", at) or (600.0, 600.0)
    if not (0 <= x < 1200 and 0 <= y < 1200):
        raise ValueError(f"--at must lie within the image of 1200 x 1200 px, got {at}")
    check_float("--heading", heading, "degrees")
    start = x, y, float(np.deg2rad(np.remainder(heading, 360)))
    simulation = Simulation(
        robot=robot,
        start=start,
        headings=None,
        noise=parse_noise("--noise", noise),
        adjust_background=lambda background: background,  # no red square beside the marker
        seed=seed,
    )
    _write_image(file, simulation.frame.image)
    errors.say(f"frame of the robot {simulation.robot.name} written to {file}")
    seen = simulation.robot
    for role, marker in seen.markers.items():
        region = _marker_region(simulation, marker.polygon, start)
        errors.say(f"  {role} marker ({marker.color}): {region}")


@command(app, "list")
def list_colors(file: Path | None = None) -> None:
    """List the colours in a file, with their ranges.

    FILE: Colour file. [default: robsim's colours]

    Example: robsim colors list
    """
    colors = load_colors(file)
    errors.print_rows(
        ("colour", "Y", "U", "V"), [(c.name, *map(_range, (c.y, c.u, c.v))) for c in colors]
    )
    errors.say(f"from {file or 'the colours shipped with robsim'}")


command(app)(color_training.train)


@command(app, "test")
def try_colors(
    images: Images,
    colors: Colors = None,
    smoothing: int = 7,
    regions: list[str] | None = None,
    out: Path | None = None,
    as_json: Json = False,
) -> None:
    """Search images for colours.

    With --region, the command scores the detection of a colour in one image under other light and
    noise, and proposes wider or narrower ranges.

    --smoothing PX: Width of the averaging window in px: 3, 5, ... 15; 1 = off.
    --region NAME=L,T,R,B: Region of the colour NAME. Repeat the option for all regions.
    --out FILE|FOLDER: Image file to write, with each pixel painted in its colour class. For several
        images, a folder.

    Example: robsim colors test frame.png --colors colors.toml --out seen.png --region
    red=578,613,594,630
    """
    classes = load_colors(colors)
    marked = _marked_regions(images, classes, regions or [])
    painted = _painted_files(images, out)
    found = {str(image): _found(image, classes, smoothing, painted.get(image)) for image in images}
    scores = [
        score_color(load_image(images[0]), color, marked[color.name], smoothing=smoothing)
        for color in classes
        if color.name in marked
    ]
    if as_json:
        result = {"found": found, "scores": [score.to_dict() for score in scores]}
        errors.show(json.dumps(result, indent=2))
        return
    _print_found(found)
    for score in scores:
        errors.show(score)
        if score.margin:
            errors.show(f"\nproposed:\n{colors_to_toml(score.proposed)}")
    if out:
        errors.say(f"colours painted, written to {out}")


def _marker_region(
    simulation: Simulation, marker: Floats, start: tuple[float, float, float]
) -> str:
    """Return the region of a marker in the frame as a command-line option, or a hint."""
    polygon = placed(simulation.robot.to_robot_frame(marker), start)
    height, width = simulation.frame.image.shape[:2]
    box = inner_box(polygon, width, height)
    return "see the image" if box is None else f"--region {','.join(map(str, box))}"


def _marked_regions(
    images: list[Path], classes: tuple[ColorClass, ...], texts: list[str]
) -> dict[str, list[Region]]:
    """Return the regions of each colour from texts such as red=578,613,594,630."""
    names = [color.name for color in classes]
    marked: dict[str, list[Region]] = {}
    for text in texts:
        name, equals, box = text.rpartition("=")
        if not equals or name not in names:
            raise ValueError(
                f"--region must begin with one of the colours {', '.join(names)}, as in "
                f"{names[0]}=578,613,594,630, got {quoted(text)}"
            )
        marked.setdefault(name, []).append(parse_region("--region", box))
    if marked and len(images) > 1:
        raise ValueError(f"--region can only be used with one image, got {len(images)} images")
    return marked


def _painted_files(images: list[Path], out: Path | None) -> dict[Path, Path]:
    if out is None:
        return {}
    if len(images) == 1:
        files = {images[0]: out}
    else:
        files = {image: out / f"{image.stem}.png" for image in images}
    if len(set(files.values())) < len(images):
        raise ValueError("--out: the images must have different names")
    for image in images:
        if image.resolve() in [file.resolve() for file in files.values()]:
            raise ValueError(f"--out {out} would overwrite {image}: give another name")
    return files


def _found(
    image: Path, classes: tuple[ColorClass, ...], smoothing: int, painted: Path | None
) -> dict[str, Any]:
    """Return the blobs and the number of pixels of each colour in an image."""
    pixels = load_image(image)
    blobs = find_blobs(pixels, classes, smoothing=smoothing)
    masks = classify(pixels, classes, smoothing=smoothing)
    if painted:
        _write_image(painted, paint_classes(pixels, masks))
    return {
        name: {
            "pixels": int(masks[name].sum()),
            "blobs": [
                {
                    "area": blob.area,
                    "centroid": blob.centroid.tolist(),
                    "bounding_box": blob.bounding_box,
                }
                for blob in found
            ],
        }
        for name, found in blobs.items()
    }


def _print_found(found: dict[str, dict[str, Any]]) -> None:
    rows = [
        (image, name, str(seen["pixels"]), str(len(seen["blobs"])), *_largest(seen["blobs"]))
        for image, colors in found.items()
        for name, seen in colors.items()
    ]
    errors.print_rows(("image", "colour", "pixels", "blobs", "largest", "at"), rows)


def _largest(blobs: list[dict[str, Any]]) -> tuple[str, str]:
    if not blobs:
        return "", ""
    right, down = blobs[0]["centroid"]
    return f"{blobs[0]['area']} px", f"({right:.1f}, {down:.1f})"


def _range(limits: tuple[int, int]) -> str:
    return "any" if limits == (0, 255) else f"{limits[0]} .. {limits[1]}"


def _write_image(file: Path, pixels: Pixels) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    save_image(file, pixels)
