"""Draw the default pictures of robsim: `python assets/draw.py`, or `--check` to measure them."""

from __future__ import annotations

import argparse
import sys
import tomllib
from pathlib import Path

import numpy as np
from PIL import Image

sys.dont_write_bytecode = True

from draw_floor import draw_floor  # noqa: E402
from draw_lab import MARKER_RADIUS, MARKERS, PICTURE, SIZE, draw_lab, marker_polygon  # noqa: E402
from draw_tools import chroma  # noqa: E402

HERE = Path(__file__).resolve().parent
FLOOR = HERE / "floor.jpg"
LAB = HERE / "robots" / "lab"

DEFINITION = """\
# The robot "lab": a small differential-drive robot with a red and a blue paper marker on top.
# Written by assets/draw.py, and free to be edited by hand.

name = "lab"
image = "robot.png"   # beside this file; surroundings transparent, the contact shadow included
size = {size:.1f}          # work-area px that the picture's width stands for
alignment = 90.0      # degrees clockwise that turn the picture so that the robot faces right (+x)

# Points are [right, down] in picture pixels; the centre of the top left pixel is (0, 0).
# The point between the wheels, around which the robot turns:
centre = [{middle:.1f}, {middle:.1f}]

# Polygons. Around the chassis and the wheels, without the shadow:
outline = {outline}

# The red marker, on the robot's right; area and centroid are those of the disc:
red = {red}

# The blue marker, on the robot's left:
blue = {blue}
"""


def toml_points(points: np.ndarray) -> str:
    """A TOML array of [right, down] points, four on a line."""
    texts = [f"[{right:.2f}, {down:.2f}]" for right, down in points]
    rows = [", ".join(texts[i : i + 4]) for i in range(0, len(texts), 4)]
    return "[\n    " + ",\n    ".join(rows) + ",\n]"


def draw() -> None:
    """Write all pictures and the robot's definition."""
    LAB.mkdir(parents=True, exist_ok=True)
    Image.fromarray(draw_floor()).save(FLOOR, quality=88, subsampling=0, optimize=True)
    picture, outline = draw_lab()
    picture.save(LAB / "robot.png", optimize=True)
    text = DEFINITION.format(
        size=SIZE,
        middle=(PICTURE - 1) / 2,
        outline=toml_points(outline),
        red=toml_points(marker_polygon("red")),
        blue=toml_points(marker_polygon("blue")),
    )
    (LAB / "robot.toml").write_text(text, encoding="utf-8")


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


def check_markers(u: np.ndarray, v: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Print the markers' centroid errors and rims; return which pixels are clear of markers."""
    clear = np.ones(u.shape, bool)
    for name, passed in (("red", v >= 38), ("blue", u >= 36)):
        true_x, true_y = MARKERS[name]
        away = np.hypot(x - true_x, y - true_y)
        clear &= away > MARKER_RADIUS + 0.5
        error_x, error_y = x[passed].mean() - true_x, y[passed].mean() - true_y
        radius = np.sqrt(passed.sum() / np.pi) * SIZE / PICTURE
        print(
            f"  {name}: centroid error ({error_x:+.4f}, {error_y:+.4f}) work-area px, radius "
            f"{radius:.2f}, pixels elsewhere {(passed & (away > MARKER_RADIUS + 0.5)).sum()}"
        )
    return clear


def check_robot() -> None:
    """Print how well the robot's picture and definition keep to their geometry."""
    rgba = np.asarray(Image.open(LAB / "robot.png")).astype(float)
    u, v = chroma(rgba)
    steps = (np.arange(PICTURE) - (PICTURE - 1) / 2) * SIZE / PICTURE
    x, y = np.meshgrid(-steps, steps, indexing="ij")
    print(f"robot {rgba.shape}, {(LAB / 'robot.png').stat().st_size / 1e3:.0f} kB")
    clear = check_markers(u, v, x, y)
    elsewhere = np.maximum(abs(u), abs(v))[clear]
    print(f"  max |U-128| or |V-128| off the markers {elsewhere.max():.1f} (allowed 20)")
    near = [np.hypot(x - mx, y - my) < MARKER_RADIUS + 5 for mx, my in MARKERS.values()]
    rim = clear & (near[0] | near[1])
    rim_chroma = np.maximum(abs(u), abs(v))[rim].max()
    print(
        f"  rims: max chroma {rim_chroma:.1f} (allowed 8), brightest {rgba[rim][:, :3].max():.0f}, "
        f"least alpha {rgba[rim][:, 3].min():.0f}"
    )
    edge = np.concatenate([rgba[[0, -1], :, 3].ravel(), rgba[:, [0, -1], 3].ravel()])
    solid = np.hypot(x, y)[rgba[..., 3] > 230].max()
    print(f"  alpha at the picture's edge {edge.max():.0f}, solid parts reach {solid:.1f} (of 57)")
    check_definition()


def check_definition() -> None:
    """Print the areas and centroids of the polygons in the robot's definition."""
    definition = tomllib.loads((LAB / "robot.toml").read_text(encoding="utf-8"))
    per_px = PICTURE / definition["size"]
    middle = np.array(definition["centre"])
    reach = np.hypot(*(np.array(definition["outline"]) - middle).T).max() / per_px
    print(f"definition: outline of {len(definition['outline'])} points, reach {reach:.1f}")
    for name in MARKERS:
        a = np.array(definition[name])
        b = np.roll(a, -1, axis=0)
        cross = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
        right, down = ((a + b) * cross[:, None]).sum(0) / (3 * cross.sum())
        radius = np.sqrt(abs(cross.sum()) / 2 / np.pi) / per_px
        place = (middle[1] - down) / per_px, (right - middle[0]) / per_px
        print(f"  {name}: centroid ({place[0]:.4f}, {place[1]:.4f}), radius {radius:.4f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="measure the pictures, draw nothing")
    if parser.parse_args().check:
        check_floor()
        check_robot()
    else:
        draw()
