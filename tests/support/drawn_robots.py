"""Robots that the tests draw."""

import numpy as np
from PIL import Image, ImageDraw

from robsim.vision import robot_from_image

COLORS = {"red": (205, 38, 42, 255), "blue": (28, 72, 205, 255)}
BODY = (70, 70, 70, 255)


def star(rng, place, radius):
    """A polygon around the place that does not cross itself: 5 to 12 corners."""
    corners = rng.integers(5, 13)
    angle = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 1)) / corners
    reach = radius * rng.uniform(0.7, 1.0, corners)
    return place + reach[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))


def painted(red, blue, *, size=(400, 400), body=BODY, paints=None):
    """A picture (h, w, 4): a round body with two markers, the surroundings transparent."""
    image = Image.new("RGBA", size, (0, 0, 0, 0))
    draw = ImageDraw.Draw(image)
    draw.ellipse((4, 4, size[0] - 5, size[1] - 5), fill=body)
    for polygon, paint in zip((red, blue), paints or COLORS.values(), strict=True):
        draw.polygon([tuple(point) for point in polygon], fill=paint)
    return np.array(image)


def random_robot(rng):
    """A random robot whose markers are not the lab robot's distance, 43 px, apart."""
    size = rng.uniform(100, 150)
    apart = rng.choice([rng.uniform(27, 36), rng.uniform(51, 60)]) * 400 / size
    turn = rng.uniform(-np.pi, np.pi)
    middle = 199.5 + rng.uniform(-20, 20, 2)
    half = apart / 2 * np.array((np.cos(turn), np.sin(turn)))
    radius = min(45, apart / 2 - 4)
    red, blue = star(rng, middle + half, radius), star(rng, middle - half, radius)
    rim = 2 * np.pi * np.arange(40) / 40
    return robot_from_image(
        "random",
        painted(red, blue),
        size=size,
        alignment=rng.uniform(-180, 180),
        centre=(199.5, 199.5),
        markers={"red": red, "blue": blue},
        outline=199.5 + 195 * np.column_stack((np.cos(rim), np.sin(rim))),
    )


def box(left, top, right, bottom):
    """A rectangle as a polygon."""
    return np.array([(left, top), (right, top), (right, bottom), (left, bottom)], float)


def covered(polygon, image):
    """The pixels of an image (h, w) within a polygon, by the even-odd rule."""
    down, right = np.indices(image.shape[:2])
    odd = np.zeros(image.shape[:2], bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if ay != by:
            odd ^= ((ay > down) != (by > down)) & (right < ax + (down - ay) * (bx - ax) / (by - ay))
    return odd
