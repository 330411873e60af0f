"""The answers of the notebook 10_measure, and mistakes that students make."""

import math

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise

MORE = 60  # of 255
NONE = (-1, -1)  # if there is no robot


def random_image(rng):
    return (rng.integers(0, 256, (6, 8, 3), dtype=np.uint8),)


def channels(image):
    return np.moveaxis(image.astype(int), 2, 0)


def overflowing(image):
    red, green, blue = np.moveaxis(image, 2, 0)
    return (red - green > MORE) & (red - blue > MORE)


def either(image):
    red, green, blue = channels(image)
    return (red > green + MORE) | (red > blue + MORE)


@exercise(
    cases=random_image,
    hint="Try it with the pixel (50, 100, 100) as uint8. Which number is red minus green?",
    mistakes={
        "uint8 has no negative numbers, 10 - 20 is 246: convert the image to int first.": (
            overflowing
        ),
        "Red must be larger than green and than blue: both, not one.": either,
        "The colours are in the order red, green, blue: this takes the last for red.": (
            lambda image: red(image[:, :, ::-1])
        ),
        "Compare red with blue, too: yellow is no red.": lambda image: (
            channels(image)[0] > channels(image)[1] + MORE
        ),
        "Compare red with green, too: violet is no red.": lambda image: (
            channels(image)[0] > channels(image)[2] + MORE
        ),
        "A grey or white pixel has much red, too: compare red with green and blue.": (
            lambda image: image[:, :, 0] > MORE
        ),
    },
)
def red_mask(image):
    """Return where an image is red, an array (H, W) of bool."""
    red, green, blue = np.moveaxis(image.astype(int), 2, 0)
    return (red - green > 60) & (red - blue > 60)


red = red_mask.right


def random_mask(rng):
    mask = rng.random(rng.integers(5, 12, 2)) < 0.3
    mask[1, 3] = True
    return (mask,)


def middle_of_box(mask):
    rows, columns = np.nonzero(mask)
    return (columns.min() + columns.max()) / 2, (rows.min() + rows.max()) / 2


@exercise(
    cases=random_mask,
    hint="Draw a mask of one pixel, in row 1 and column 3: u is 3, v is 1. What has numpy.nonzero?",
    mistakes={
        "Row and column are exchanged: u is the column, v the row.": (
            lambda mask: np.argwhere(mask).mean(axis=0)
        ),
        "This is the middle of the box around the pixels: take the mean of all pixels.": (
            middle_of_box
        ),
        "This is the middle of the image: take the pixels of the mask only.": lambda mask: (
            (mask.shape[1] - 1) / 2,
            (mask.shape[0] - 1) / 2,
        ),
        "Rows and columns begin with 0.": lambda mask: np.argwhere(mask).mean(axis=0)[::-1] + 1,
    },
)
def centroid(mask):
    """Return the centroid (u, v) of a mask (H, W) of bool: the mean column, the mean row (px)."""
    rows, columns = np.nonzero(mask)
    return columns.mean(), rows.mean()


def random_blobs(rng):
    """Return red and blue places, in half of the cases with a robot, and its distance."""
    distance, kind = rng.uniform(30, 60), rng.integers(4)
    counts = rng.integers(0, 4, 2) if kind == 0 else (3, 3)
    reds, blues = (rng.uniform(0, 1200, (count, 2)) for count in counts)

    def beside(place, factor):
        turn = rng.uniform(-3, 3)
        return place + factor * distance * np.array((math.cos(turn), math.sin(turn)))

    if kind == 1:  # a pair that is too near
        blues[-1] = beside(reds[0], 0.6)
    if kind > 1:
        blues[-1] = beside(reds[0], rng.uniform(0.95, 1.05))
        blues[0] = beside(reds[1], 1.2)  # it fits, but not best
        reds[2] = beside(blues[1], 0.2)  # the nearest pair
    return rng.permutation(reds), rng.permutation(blues), distance


def distances(reds, blues):
    return np.linalg.norm(reds[:, None] - blues, axis=2)


def pair_by(misfit, limit=np.inf):
    if not misfit.size or misfit.min() > limit:
        return NONE
    return np.unravel_index(misfit.argmin(), misfit.shape)


def best_pair(reds, blues, distance):
    return pair_by(abs(distances(reds, blues) - distance), distance / 4)


@exercise(
    cases=random_blobs,
    hint="reds[:, None] - blues has the differences of all pairs. Which of these fits best?",
    mistakes={
        "This takes the pair that is nearest to each other: the distance must be the given one.": (
            lambda reds, blues, distance: pair_by(distances(reds, blues))
        ),
        "A pair whose distance is far off is no robot: return (-1, -1).": (
            lambda reds, blues, distance: pair_by(abs(distances(reds, blues) - distance))
        ),
        "This takes the first of each colour: compare all pairs.": (
            lambda reds, blues, distance: (0, 0) if len(reds) and len(blues) else NONE
        ),
        "The indexes are exchanged: the red one is the first.": lambda reds, blues, distance: (
            best_pair(reds, blues, distance)[::-1]
        ),
        "This returns the distance of the pair: return its indexes.": (
            lambda reds, blues, distance: (
                NONE
                if (pair := best_pair(reds, blues, distance)) == NONE
                else distances(reds, blues)[pair]
            )
        ),
    },
)
def marker_pair(reds, blues, distance):
    """Return the indexes (i, j) of the red and blue place with a distance nearest to `distance`."""
    if len(reds) == 0 or len(blues) == 0:
        return -1, -1
    misfit = abs(np.linalg.norm(reds[:, None] - blues, axis=2) - distance)
    i, j = np.unravel_index(misfit.argmin(), misfit.shape)
    return (i, j) if misfit[i, j] <= distance / 4 else (-1, -1)


def markers(rng):
    """Return the places of the right and the left marker, and an offset."""
    middle, turn = rng.uniform(0, 1200, 2), rng.uniform(-3, 3)
    half = 20 * np.array((-math.sin(turn), math.cos(turn)))
    return middle + half, middle - half, rng.uniform(5, 20)


def heading_of_line(right, left):
    return math.atan2(right[1] - left[1], right[0] - left[0])


def pose(right, left, offset, heading):
    ahead = np.array((math.cos(heading), math.sin(heading)))
    return (*((right + left) / 2 + offset * ahead), heading)


def with_degrees(right, left, offset):
    x, y, heading = right_pose(right, left, offset)
    return x, y, math.degrees(heading)


def along_x(right, left, offset):
    x, y = (right + left) / 2
    return x + offset, y, right_pose(right, left, offset)[2]


@exercise(
    cases=markers,
    hint="A robot with heading 0 looks along +x. Where is its right marker then, with y down?",
    mistakes={
        "The robot looks backwards: its red marker is on its right, and y points down.": (
            lambda right, left, offset: right_pose(left, right, offset)
        ),
        "This is the direction from the left to the right marker: the heading is perpendicular.": (
            lambda right, left, offset: pose(right, left, offset, heading_of_line(right, left))
        ),
        "The heading leaves the interval from -pi to pi: wrap it with robsim.wrap_angle.": (
            lambda right, left, offset: pose(
                right, left, offset, heading_of_line(right, left) - math.pi / 2
            )
        ),
        "This is the middle of the markers: the robot's centre is ahead of it.": (
            lambda right, left, offset: right_pose(right, left, 0)
        ),
        "The centre is ahead of the middle of the markers: this goes backwards.": (
            lambda right, left, offset: right_pose(right, left, -offset)
        ),
        "The centre lies ahead along the heading, not along the x axis.": along_x,
        "The heading is in degrees, and must be in radians.": with_degrees,
    },
)
def pose_from(right, left, offset):
    """Return (x, y, heading) from the places (x, y) of the right and the left marker (px)."""
    across = right - left
    heading = robsim.wrap_angle(np.arctan2(across[1], across[0]) - np.pi / 2)
    x, y = (right + left) / 2
    return x + offset * np.cos(heading), y + offset * np.sin(heading), heading


right_pose = pose_from.right
