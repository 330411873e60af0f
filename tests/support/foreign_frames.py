"""Frames of a robot at known poses, drawn by code that shares nothing with robsim's renderer.

Markers are polygons, and a pixel takes of each the area that it covers: computed from the corners,
not sampled, so that a marker stands where it should to rounding. What a camera adds is in
`camera_effects`. Of robsim come the polygons of the lab robot and `PlaneMap`, which is made of the
matrix that is drawn with.
"""

import functools
import zlib
from dataclasses import dataclass

import numpy as np
from PIL import Image

import robsim
from camera_effects import photographed

FLOOR = (176.0, 169.0, 158.0)
BODY, WHEEL, PLATE = (62.0, 64.0, 68.0), (24.0, 24.0, 26.0), (120.0, 124.0, 122.0)
RED, BLUE = (199.0, 37.0, 41.0), (29.0, 63.0, 171.0)
WHITE = (235.0, 235.0, 232.0)


# --- polygons


def coverage(corners, width, height):
    """The area of each pixel that lies in a polygon: array (height, width), exact.

    Pixel (row, column) is the square from (column, row) to (column + 1, row + 1); the polygon lies
    within the array. An edge is cut where it enters a pixel: a piece that goes down by dy at the
    mean place x hides dy (column + 1 - x) of its own pixel, and dy of all on its right.
    """
    gained = np.zeros((height, width + 1))
    for start, way in zip(corners, np.roll(corners, -1, axis=0) - corners, strict=True):
        ends = start + _cuts(start, way)[:, None] * way
        middle, down = (ends[1:] + ends[:-1]) / 2, np.diff(ends[:, 1])
        column, row = np.floor(middle).astype(int).T
        np.add.at(gained, (row, column), down * (column + 1 - middle[:, 0]))
        np.add.at(gained, (row, column + 1), down * (middle[:, 0] - column))
    covered = np.cumsum(gained, axis=1)[:, :-1]
    return np.clip(covered * np.sign(covered.sum()), 0, 1)


def _cuts(start, way):
    """Where an edge crosses from pixel to pixel: fractions of it, with 0 and 1."""
    found = [(0.0, 1.0)]
    for begin, length in zip(start, way, strict=True):
        low, high = sorted((begin, begin + length))
        if length != 0:
            found.append((np.arange(np.ceil(low), np.floor(high) + 1) - begin) / length)
    return np.sort(np.clip(np.concatenate(found), 0, 1))


def placed(corners, pose):
    """Corners of the robot's frame (forward, right) in the work area."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return pose[:2] + corners @ np.array([[c, s], [-s, c]])


def middle_of(corners):
    """The centroid of a polygon."""
    x, y = corners.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    return (corners + np.roll(corners, -1, axis=0)).T @ cross / (3 * cross.sum())


def _ring(radius, count=48):
    angle = 2 * np.pi * np.arange(count) / count
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def _rectangle(forward, right):
    (back, front), (left, far) = forward, right
    return np.array([(back, left), (front, left), (front, far), (back, far)], float)


# --- robots


@functools.cache
def marker_polygons(robot):
    """The red and the blue marker in the robot's frame: forward, right (work-area px)."""
    if robot == "lab":
        lab = robsim.load_robot("lab")
        return tuple(lab.to_robot_frame(one.polygon) for one in lab.markers.values())
    red = np.array([(34, 1), (22, 19), (6, 12), (6, -10), (22, -17)], float)
    return red, _rectangle((-34, -14), (-14, 12))  # in front and behind


def _body(markers):
    """Colour and polygon of what lies under the markers."""
    radius = np.hypot(*np.concatenate(markers).T).max() + 14
    wheel = radius - 12
    return [
        (BODY, _ring(radius)),
        *((WHEEL, _rectangle((-9, 9), side)) for side in ((-radius, -wheel), (wheel, radius))),
        (PLATE, _rectangle((radius - 11, radius - 4), (-8, 8))),
    ]


# --- cases


@dataclass(frozen=True)
class Case:
    """What a frame shows, and what the camera does to it; lengths in frame px unless said."""

    robot: str = "lab"
    colors: tuple = (RED, BLUE)
    exposure: float = 1.0
    cast: tuple = (1.0, 1.0, 1.0)  # gains of R, G, B
    gradient: tuple = (1.0, 1.0)  # light at the left and at the right edge
    shadow: bool = False  # its edge crosses the robot
    tilted: bool = False  # the camera looks at the floor at an angle
    hidden: float = 0.0  # of the red marker's width
    hidden_by: tuple = WHITE
    floor: tuple = FLOOR
    defined_size: float = 1.0  # of the markers in the definition, of their true one
    defined_distance: float = 1.0
    blur: float = 0.0  # standard deviation
    bayer: bool = False
    gaussian: float = 0.0  # %, as robsim.GaussianNoise; with a mosaic, of the raw pixels
    uniform: float = 0.0
    jpeg: int | None = None  # quality


FADED = ((150.0, 80.0, 75.0), (75.0, 85.0, 120.0))

CASES = {
    "clean": Case(),
    **{f"Gaussian {p} %": Case(gaussian=p) for p in (5, 10, 20, 40)},
    **{f"uniform {p} %": Case(uniform=p) for p in (10, 20, 40)},
    "blur 1": Case(blur=1),
    "blur 3": Case(blur=3),
    "JPEG 75": Case(jpeg=75),
    "JPEG 50": Case(jpeg=50),
    "Bayer": Case(bayer=True),
    "Bayer, raw Gaussian 2 %": Case(bayer=True, gaussian=2),
    "gradient .3-1.2": Case(gradient=(0.3, 1.2)),
    **{f"exposure {e}": Case(exposure=e) for e in (0.15, 0.2, 0.3, 0.5, 3)},
    **{
        f"exposure {e}, Gaussian {p} %": Case(exposure=e, gaussian=p)
        for e, p in ((0.3, 5), (0.5, 5), (0.6, 40))
    },
    "faded": Case(colors=FADED),
    "faded, exposure 0.5": Case(colors=FADED, exposure=0.5),
    "faded, Gaussian 5 %": Case(colors=FADED, gaussian=5),
    "reddish": Case(cast=(1.3, 1, 0.8)),
    "bluish": Case(cast=(0.85, 1, 1.4)),
    "yellow": Case(cast=(1.4, 1, 0.5)),
    "blue at 0.3": Case(exposure=0.3, cast=(0.6, 1, 1.3)),
    "wooden floor at 0.3": Case(exposure=0.3, floor=(185.0, 140.0, 95.0)),
    "green floor at 0.3": Case(exposure=0.3, floor=(110.0, 160.0, 100.0)),
    "shadow's edge, Gaussian 10 %": Case(shadow=True, gaussian=10),
    "hidden 25 %, white": Case(hidden=0.25),
    "defined 5 % too large, Gaussian 10 %": Case(defined_size=1.05, gaussian=10),
    "defined 5 % too far apart": Case(defined_distance=1.05),
    "tilted": Case(tilted=True),
    "tilted, Gaussian 10 %": Case(tilted=True, gaussian=10),
    "other markers": Case(robot="other"),
    "other markers, Gaussian 10 %": Case(robot="other", gaussian=10),
}


def layout_of(case):
    """The markers as the definition has them, right or wrong."""
    polygons = marker_polygons(case.robot)
    roles = ("right", "left") if case.robot == "lab" else ("front", "back")
    middles = [middle_of(polygon) for polygon in polygons]
    centre = np.mean(middles, axis=0)
    defined = [
        centre + (middle - centre) * case.defined_distance + (polygon - middle) * case.defined_size
        for polygon, middle in zip(polygons, middles, strict=True)
    ]
    return robsim.vision.MarkerLayout.from_markers(dict(zip(roles, defined, strict=True)))


# --- the camera


@dataclass(frozen=True)
class View:
    """A camera's pixels, and how many of them a px of the work area takes in the middle."""

    resolution: tuple = (640, 480)
    scale: float = 1.0

    @property
    def area(self):
        """What it sees from above (work-area px)."""
        return tuple(size / self.scale for size in self.resolution)

    @functools.cache  # noqa: B019 - a handful of views
    def pixels_from_floor(self, tilted=False):
        """The homography, array (3, 3), from work area to pixels (integer = pixel centre)."""
        width, height = self.resolution
        middle = np.array([[1, 0, (width - 1) / 2], [0, 1, (height - 1) / 2], [0, 0, 1]])
        to_middle = np.array([[1, 0, 0.5 - self.area[0] / 2], [0, 1, 0.5 - self.area[1] / 2]])
        floor = np.vstack((to_middle, (0, 0, 1)))
        if not tilted:
            return middle @ np.diag((self.scale, self.scale, 1)) @ floor
        # floor (x, y, 0) turned about x, at the distance where the middle has the same scale
        focal, tilt = 0.95 * width, np.deg2rad(35)
        away = focal / self.scale
        turned = np.array([[1, 0, 0], [0, np.cos(tilt), 0], [0, -np.sin(tilt), away]])
        return middle @ np.diag((focal, focal, 1)) @ turned @ floor

    def plane_map(self, tilted=False):
        return robsim.vision.PlaneMap(np.linalg.inv(self.pixels_from_floor(tilted)))

    def pixels(self, positions, tilted=False):
        """The pixels of positions (N, 2) in the work area."""
        seen = np.c_[positions, np.ones(len(positions))] @ self.pixels_from_floor(tilted).T
        return seen[:, :2] / seen[:, 2:]

    def pose_in_view(self, rng, robot="lab", tilted=False, margin=4):
        """A pose anywhere, the whole robot in view."""
        outline = _body(marker_polygons(robot))[0][1]
        while True:
            xy = rng.uniform((0, 0), self.area)
            pose = np.array((*xy, rng.uniform(-np.pi, np.pi)))
            seen = self.pixels(placed(outline, pose), tilted)
            if (seen > margin).all() and (seen < np.array(self.resolution) - 1 - margin).all():
                return pose


#: By the width of the lab robot's markers, the square root of their area.
VIEWS = {"20.9 px": View((640, 480), 0.907), "10.5 px": View((320, 240), 0.4557)}

#: The same with little floor around the robot: quick.
NARROW = {"20.9 px": View((200, 160), 0.907), "10.5 px": View((120, 96), 0.4557)}


# --- drawing: arrays (height, width, 3) of levels, not rounded


@functools.cache
def _texture(size, seed=1):
    """Grain and patches of a floor, to be shifted: array (size, size, 3)."""
    rng = np.random.default_rng(seed)
    texture = np.array(FLOOR) + rng.normal(0, 2.5, (size, size, 1))
    for cell, amplitude in ((48, 9), (12, 4)):
        coarse = Image.fromarray(rng.normal(0, amplitude, 2 * (size // cell,)).astype(np.float32))
        texture += np.array(coarse.resize((size, size)))[..., None] * (1, 0.96, 0.9)
    return texture


def floor(view, rng, color=FLOOR):
    """The floor at a random place of its texture."""
    size = max(960, *view.resolution)
    right, down = (
        (np.arange(count) - shift) % size
        for count, shift in zip(view.resolution, rng.integers(0, size, 2)[::-1], strict=True)
    )
    return _texture(size)[down[:, None], right] * np.divide(color, FLOOR)


def _markers(case, polygons):
    """Colour and polygon of the markers, and of what hides the front of the red one."""
    red, blue = polygons
    cover = []
    if case.hidden:
        (back, left), (front, right) = red.min(axis=0), red.max(axis=0)
        edge = front - case.hidden * (front - back)
        cover = [(case.hidden_by, _rectangle((edge, front + 3), (left - 2, right + 2)))]
    return [(case.colors[0], red), *cover, (case.colors[1], blue)]


def paint_robot(image, case, view, pose):
    """Paint a robot over a floor."""
    polygons = marker_polygons(case.robot)

    def raster(corners):
        return view.pixels(placed(corners, pose), case.tilted) + 0.5

    body = _body(polygons)
    outline = np.concatenate([raster(corners) for _, corners in body])
    first = np.floor(outline.min(axis=0)).astype(int) - 1
    width, height = np.ceil(outline.max(axis=0)).astype(int) + 1 - first
    part = image[first[1] : first[1] + height, first[0] : first[0] + width]
    for color, corners in [*body, *_markers(case, polygons)]:
        part += coverage(raster(corners) - first, width, height)[..., None] * (color - part)


def light(case, view, pose, rng):
    """The light at each pixel, as a factor: array (height or 1, width, 1)."""
    width, height = view.resolution
    factor = np.linspace(*case.gradient, width)[None, :, None] * case.exposure
    if case.shadow and pose is not None:
        # the edge is 3 px wide, and passes the robot's centre within 20 px of the work area
        angle, off = rng.uniform(0, 2 * np.pi), rng.uniform(-20, 20) * view.scale
        u, v = view.pixels(np.array([pose[:2]]), case.tilted)[0]
        du, dv = np.arange(width)[None, :] - u, np.arange(height)[:, None] - v
        across = du * np.cos(angle) + dv * np.sin(angle) - off
        factor = factor * (0.8 - 0.2 * np.clip(across / 1.5, -1, 1))[..., None]
    return factor


def picture(case, view, pose, rng):
    """A picture of the robot at a pose, or of an empty floor (pose None)."""
    levels = floor(view, rng, case.floor)
    if pose is not None:
        paint_robot(levels, case, view, pose)
    levels = levels * light(case, view, pose, rng) * np.array(case.cast)
    return photographed(levels, case, rng)


def frame_at(case, pose, size, seed=0):
    """A frame of a camera above an area of 600 x 600 px; pose None: no robot."""
    view = View(size, size[0] / 600)
    image = picture(case, view, pose, np.random.default_rng(seed))
    return robsim.Frame(image, plane_map=view.plane_map(case.tilted))


def frames(name, view, count):
    """Yield frames of a case and the poses in them; the seed is that of the case's name."""
    case, seed = CASES[name], zlib.crc32(name.encode())
    plane_map = view.plane_map(case.tilted)
    for index in range(count):
        rng = np.random.default_rng((seed, *view.resolution, index, False))
        pose = view.pose_in_view(rng, case.robot, case.tilted)
        yield robsim.Frame(picture(case, view, pose, rng), plane_map=plane_map), pose
