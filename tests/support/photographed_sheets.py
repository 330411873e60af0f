"""Pictures of printed sheets, taken by a camera whose lens and place are known."""

from dataclasses import dataclass, replace
from functools import cache

import cv2
import numpy as np

from robsim.lab import FloorSheet

SAMPLES = 3  # of each pixel, in each direction
DOTS = 4  # of a printed page, for one mm
FLOOR = 150  # its level
PAGE, BELOW = (297, 210), 11  # mm, A4, and room for the ruler below the pattern


@dataclass(frozen=True)
class Shot:
    """A camera: its lens, and where it is.

    The floor has x to the right, y down (as seen from above) and z away from the camera (mm).
    """

    size: tuple[int, int] = (640, 480)
    focal: float = 560.0
    centre: tuple[float, float] = (327.0, 232.0)
    distortion: tuple[float, ...] = (-0.16, 0.05, 0.001, -0.0006, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)  # rotation vector, rad
    place: tuple[float, float, float] = (0.0, 0.0, 1500.0)  # of the floor's origin, mm

    @property
    def matrix(self):
        u, v = self.centre
        return np.array([(self.focal, 0, u), (0, self.focal, v), (0, 0, 1.0)])

    def pixels(self, points):
        """Return the pixels (N, 2) of points (N, 3) above the floor (mm)."""
        points = np.asarray(points, float) * (1, 1, -1)
        turn, place = np.array(self.turn, float), np.array(self.place, float)
        return cv2.projectPoints(points, turn, place, self.matrix, self.distortion)[0][:, 0]

    @property
    def plane(self):
        """The homography from the floor (mm) to ideal pixels."""
        rotation, _ = cv2.Rodrigues(np.array(self.turn, float))
        return self.matrix @ np.column_stack([rotation[:, :2], self.place])


@cache
def _ideal(size, focal, centre, distortion):
    """The ideal pixels (N, 1, 2) of all samples of a picture."""
    width, height = size
    shot = Shot(size, focal, centre, distortion)
    u = (np.arange(width * SAMPLES) + 0.5) / SAMPLES - 0.5
    v = (np.arange(height * SAMPLES) + 0.5) / SAMPLES - 0.5
    samples = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 1, 2)
    k = shot.matrix
    return cv2.undistortPoints(samples, k, np.array(distortion), P=k)


@cache
def printed(pattern):
    """The page of a pattern, in `DOTS` for one mm."""
    wide, tall = PAGE
    page = np.full((DOTS * tall, DOTS * wide), 245, np.uint8)
    corner = (np.subtract(PAGE, (0, BELOW)) - pattern.size) / 2
    for left, top, width, height in pattern.rectangles:
        x0, y0 = np.rint(DOTS * np.add(corner, (left, top))).astype(int)
        x1, y1 = np.rint(DOTS * np.add(corner, (left + width, top + height))).astype(int)
        page[y0:y1, x0:x1] = 20
    return page


def photograph(shot, sheets, *, rng=None):
    """Return the picture (H, W, 3) of sheets on the floor.

    `sheets` are pairs of a pattern and the place of its centre: x, y (mm) and angle (rad).
    """
    ideal = _ideal(shot.size, shot.focal, shot.centre, shot.distortion)
    width, height = shot.size
    light = np.full((height * SAMPLES, width * SAMPLES), FLOOR, np.float32)
    for pattern, (x, y, angle) in sheets:
        page = printed(pattern)
        forward = np.array((np.cos(angle), np.sin(angle)))
        axes = np.array([(*forward, x), (-forward[1], forward[0], y), (0, 0, 1)])
        axes[:2, :2] = axes[:2, :2].T
        v, u = np.subtract(page.shape, (DOTS * BELOW, 0)) / 2 - 0.5
        dots = np.array([(DOTS, 0, u), (0, DOTS, v), (0, 0, 1)])
        to_page = dots @ np.linalg.inv(shot.plane @ axes)
        on_page = cv2.perspectiveTransform(ideal, to_page).astype(np.float32)
        on_page = on_page.reshape(*light.shape, 2)
        seen = cv2.remap(page, on_page[..., 0], on_page[..., 1], cv2.INTER_LINEAR, borderValue=0)
        light[seen > 0] = seen[seen > 0]
    light = light.reshape(height, SAMPLES, width, SAMPLES).mean(axis=(1, 3))
    light = cv2.GaussianBlur(light, (0, 0), 0.6)
    if rng is not None:
        light = light + 1.5 * rng.standard_normal(light.shape)
    gray = np.clip(np.rint(light), 0, 255).astype(np.uint8)
    return np.repeat(gray[:, :, None], 3, axis=2)


def true_pixels(shot, positions, place):
    """The pixels of positions (N, 2) from the centre of a pattern that lies at a place (mm)."""
    x, y, angle = place
    positions = np.asarray(positions, float)
    forward = np.array((np.cos(angle), np.sin(angle)))
    right = np.array((-forward[1], forward[0]))
    floor = np.array((x, y)) + positions[:, :1] * forward + positions[:, 1:] * right
    return shot.pixels(np.column_stack([floor, np.zeros(len(floor))]))


# Where in the picture the middle of the board is, its distance (mm), and its tilts (rad).
VIEWS = [
    (0.3, 0.3, 500, 0.5, 0.1),
    (0.7, 0.3, 520, -0.4, 0.3),
    (0.3, 0.7, 540, 0.2, -0.5),
    (0.7, 0.7, 500, -0.3, -0.4),
    (0.5, 0.5, 420, 0.6, 0.0),
    (0.5, 0.5, 450, 0.0, 0.6),
    (0.25, 0.5, 560, -0.5, 0.2),
    (0.75, 0.5, 560, 0.3, 0.5),
]


def board_pictures(board, views=VIEWS, base=Shot(), rng=None, farther=1.0):
    """Yield pictures of a board that is held in front of a camera."""
    rng = rng or np.random.default_rng(1)
    for across, down, away, tilt_x, tilt_y in views:
        z = farther * away
        u, v = across * base.size[0], down * base.size[1]
        x, y = (u - base.centre[0]) / base.focal * z, (v - base.centre[1]) / base.focal * z
        shot = replace(base, turn=(tilt_x, tilt_y, 0.1), place=(x, y, z))
        yield photograph(shot, [(board, (0, 0, 0))], rng=rng)


#: Sheets on a floor: their numbers, and where they lie (mm, rad).
LAID = {
    1: (0.0, 0.0, 0.05),
    2: (-650.0, -450.0, 0.6),
    3: (600.0, -500.0, -0.4),
    4: (-500.0, 380.0, 2.0),
    5: (520.0, 400.0, 0.3),
}


def floor_picture(shot):
    """Return the picture of five floor sheets."""
    sheets = [(FloorSheet(number), place) for number, place in LAID.items()]
    return photograph(shot, sheets, rng=np.random.default_rng(4))


#: Looks at them, 30 degrees aside.
OBLIQUE = Shot(turn=(-0.5236, 0.0, 0.0), place=(0.0, 100.0, 2400.0))
