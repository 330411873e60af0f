"""Draw the default pictures of robsim: `python assets/draw.py`, or `--check` to measure them."""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

sys.dont_write_bytecode = True

import draw_lab  # noqa: E402
import draw_robot2  # noqa: E402
import draw_sheep  # noqa: E402
from draw_floor import draw_floor  # noqa: E402
from draw_polygons import (  # noqa: E402
    area_and_centroid,
    colour_margin,
    outline_polygon,
    patch_polygon,
    scene_scale,
)
from draw_scene import SIZE  # noqa: E402
from draw_tools import chroma  # noqa: E402

HERE = Path(__file__).resolve().parent
FLOOR = HERE / "floor.jpg"

DEFINITION = """\
# The robot "{name}": {about}
# Written by assets/draw.py, and free to be edited by hand.

name = "{name}"
image = "robot.png"   # beside this file; {image}
size = {size:.1f}          # work-area px that the picture's width stands for
{alignment:<21} # degrees clockwise that turn the picture so that the robot faces right (+x)

# Points are [right, down] in picture pixels; the centre of the top left pixel is (0, 0).
# {centre}
centre = [{middle[0]:.1f}, {middle[1]:.1f}]

# Polygons. {outline}
outline = {outline_points}
"""

MARKER = """
# {about}
[markers.{role}]
color = "{color}"
polygon = {points}
"""


@dataclass(frozen=True, kw_only=True)
class Robot:
    """How a robot is drawn, and the words of its definition."""

    draw: Callable[[], tuple[Image.Image, dict[str, np.ndarray]]]
    size: float
    alignment: float
    about: str
    image: str
    centre: str
    outline: str
    markers: dict[str, tuple[str, str]]  # by role: colour, and what it is


def lab() -> tuple[Image.Image, dict[str, np.ndarray]]:
    """The lab robot's picture and its polygons, which are known exactly."""
    picture, outline = draw_lab.draw_lab()
    markers = {name: draw_lab.marker_polygon(name) for name in draw_lab.MARKERS}
    return picture, {"outline": outline, **markers}


def robot2() -> tuple[Image.Image, dict[str, np.ndarray]]:
    """The portrait's picture, its four corners, and the polygons of what vision sees."""
    picture = draw_robot2.draw_robot2()
    right, down = picture.width - 0.5, picture.height - 0.5
    corners = np.array([(-0.5, -0.5), (right, -0.5), (right, down), (-0.5, down)])
    return picture, {"outline": corners, **patches(picture, draw_robot2.SIZE)}


def sheep() -> tuple[Image.Image, dict[str, np.ndarray]]:
    """The sheep's picture, its outline, and the polygons of what vision sees."""
    picture = draw_sheep.draw_sheep()
    return picture, {"outline": outline_polygon(picture), **patches(picture, draw_sheep.SIZE)}


def patches(picture: Image.Image, size: float) -> dict[str, np.ndarray]:
    """The polygons of the red and the blue patch."""
    return {name: patch_polygon(picture, size, name) for name in ("red", "blue")}


ROBOTS = {
    "lab": Robot(
        draw=lab,
        size=SIZE,
        alignment=90,
        about="a small differential-drive robot with a red and a blue paper marker on top.",
        image="surroundings transparent, the contact shadow included",
        centre="The point between the wheels, around which the robot turns:",
        outline="Around the chassis and the wheels, without the shadow:",
        markers={
            "right": ("red", "The red marker; area and centroid are those of the disc:"),
            "left": ("blue", "The blue marker:"),
        },
    ),
    "robot2": Robot(
        draw=robot2,
        size=draw_robot2.SIZE,
        alignment=90,
        about="a portrait on a cart, somebody in a red jacket before blue sky.\n"
        "# Its patches lie farther apart than the lab robot's markers: its markers never finds it.",
        image="a photo print, not transparent; its head is up",
        centre="The point around which the robot turns, the middle of the print:",
        outline="Around the print:",
        markers={
            "front": (
                "blue",
                "The blue sky around the head; area and centroid are those of the pixels that\n"
                "# vision sees as blue:",
            ),
            "back": ("red", "The red jacket, in the same way:"),
        },
    ),
    "sheep": Robot(
        draw=sheep,
        size=draw_sheep.SIZE,
        alignment=0,
        about="a sheep with a red and a blue paint mark on its fleece, one behind the other.",
        image="transparent around, with its shadow; it faces right",
        centre="The point around which the sheep turns, between its legs:",
        outline="Around fleece, head and feet, without the shadow:",
        markers={
            "front": (
                "red",
                "The red mark, on the shoulders; area and centroid are those of the pixels that\n"
                "# vision sees as red:",
            ),
            "back": ("blue", "The blue mark, on the rump, in the same way:"),
        },
    ),
}


def folder(name: str) -> Path:
    """Where the robot's picture and definition lie."""
    return HERE / "robots" / name


def toml_points(points: np.ndarray) -> str:
    """A TOML array of [right, down] points, four on a line."""
    texts = [f"[{right:.2f}, {down:.2f}]" for right, down in points]
    rows = [", ".join(texts[i : i + 4]) for i in range(0, len(texts), 4)]
    return "[\n    " + ",\n    ".join(rows) + ",\n]"


def draw_robot(name: str, robot: Robot) -> None:
    """Write the robot's picture and definition."""
    picture, polygons = robot.draw()
    folder(name).mkdir(parents=True, exist_ok=True)
    picture.save(folder(name) / "robot.png", optimize=True)
    text = DEFINITION.format(
        name=name,
        middle=((picture.width - 1) / 2, (picture.height - 1) / 2),
        outline_points=toml_points(polygons["outline"]),
        size=robot.size,
        alignment=f"alignment = {robot.alignment:.1f}",
        about=robot.about,
        image=robot.image,
        centre=robot.centre,
        outline=robot.outline,
    )
    for role, (color, about) in robot.markers.items():
        points = toml_points(polygons[color])
        text += MARKER.format(role=role, color=color, about=about, points=points)
    (folder(name) / "robot.toml").write_text(text, encoding="utf-8")


def draw(names: list[str]) -> None:
    """Write the floor and the robots, or only the robots that are named."""
    if not names:
        Image.fromarray(draw_floor()).save(FLOOR, quality=88, subsampling=0, optimize=True)
    for name in names or ROBOTS:
        draw_robot(name, ROBOTS[name])


def check_floor() -> None:
    """Print the floor's brightness, chroma and how its seams compare with its inside."""
    floor = np.asarray(Image.open(FLOOR)).astype(float)
    u, v = chroma(floor)
    print(f"floor {floor.shape}, {FLOOR.stat().st_size / 1e3:.0f} kB, mean {floor.mean():.1f}")
    print(f"  max |U-128| {abs(u).max():.1f}, max |V-128| {abs(v).max():.1f} (allowed 14)")
    for axis, name in ((1, "left-right"), (0, "top-bottom")):
        steps = abs(floor - np.roll(floor, 1, axis)).mean((1 - axis, 2))
        print(
            f"  {name} seam: mean step {steps[0]:.2f} levels; inside: median "
            f"{np.median(steps):.2f}, at block edges {np.median(steps[8::8]):.2f}, "
            f"99 % {np.percentile(steps, 99):.2f}"
        )


def check_robot(name: str) -> None:
    """Print how well the robot's picture and definition fit each other."""
    file = folder(name) / "robot.png"
    picture = Image.open(file)
    definition = tomllib.loads((folder(name) / "robot.toml").read_text(encoding="utf-8"))
    unit = definition["size"] / picture.width
    outline = np.array(definition["outline"])
    reach = np.hypot(*(outline - definition["centre"]).T).max() * unit
    alpha = np.asarray(picture)[..., 3]
    edge = np.concatenate([alpha[[0, -1]].ravel(), alpha[:, [0, -1]].ravel()])
    print(f"robot {name} {picture.size}, {file.stat().st_size / 1e3:.0f} kB")
    print(
        f"  outline of {len(outline)} points, reach {reach:.1f} px; alpha at the edge {edge.max()}"
    )
    print(
        f"  area {area_and_centroid(outline)[0] * unit**2:.0f} px^2, solid parts "
        f"{(alpha > 230).sum() * unit**2:.0f}"
    )
    markers = definition["markers"].values()
    places = [
        check_patch(picture, definition, np.array(marker["polygon"]), marker["color"], unit)
        for marker in markers
    ]
    print(f"  the markers are {np.hypot(*(places[0] - places[1])):.2f} px apart")


def check_patch(
    picture: Image.Image, definition: dict, polygon: np.ndarray, color: str, unit: float
) -> np.ndarray:
    """Print how a patch is seen in the light and in the shadow; return its centroid (px)."""
    area, centroid = area_and_centroid(polygon)
    print(f"  {color}: {area * unit**2:.0f} px^2")
    rgb = scene_scale(picture, definition["size"])
    for light in (1.0, 0.8):
        margin = colour_margin(light * rgb, color)
        down, right = np.nonzero(margin >= 0)
        error = (np.array([right.mean(), down.mean()]) - centroid) * unit
        print(
            f"    light {light:.1f}: {right.size * unit**2:.0f} px^2 seen, centroid error "
            f"({error[0]:+.2f}, {error[1]:+.2f}) px, median {np.median(margin[margin >= 0]):.0f} "
            "levels within the colour"
        )
    return centroid * unit


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="measure the pictures, draw nothing")
    parser.add_argument("robots", nargs="*", help="draw only these robots", metavar="ROBOT")
    arguments = parser.parse_args()
    if unknown := set(arguments.robots) - set(ROBOTS):
        parser.error(f"no robot {', '.join(sorted(unknown))}: there are {', '.join(ROBOTS)}")
    if arguments.check:
        check_floor()
        for robot_name in arguments.robots or ROBOTS:
            check_robot(robot_name)
    else:
        draw(arguments.robots)
