"""How well vision finds the robot in other light, beside a plain HSV detector.

    python tests/support/light.py --frames 30

prints, for two sizes of markers and every light: frames with a pose, false ones among them, and the
rms of the others (work-area px), with the colour classes as they are, with the second chance
relative to brightness, and with HSV thresholds; then the poses reported on empty floors.
Frames are drawn here, by supersampling, from a seed: nothing of the renderer is in them.
"""

import argparse
import itertools
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

import robsim
from robsim.vision import Blob, MarkerLayout, detect

AREA = (600, 600)  # px
RADIUS = 11.8  # px, of a marker
MARKERS = MarkerLayout.from_positions(
    {"right": (-14, 21.5), "left": (-14, -21.5)},
    areas={"right": np.pi * RADIUS**2, "left": np.pi * RADIUS**2},
)
RED, BLUE, BODY, WHEEL = (198, 36, 40), (30, 62, 190), (92, 94, 96), (28, 27, 30)
FADED = ((150, 80, 75), (75, 85, 120))
FLOOR = (186, 183, 178)
SAMPLES = 8  # of a px in each direction
SIZES = ((600, 600), (300, 300))
FALSE = 10  # px
SATURATION = 90  # of 255, that of the HSV detector


def floor(rng, size, color=FLOOR):
    """A floor with grain, large spots and the joints of tiles: (H, W, 3) of float."""
    width, height = size
    grain = rng.normal(0, 4, (height, width))
    spots = ndimage.zoom(rng.normal(0, 7, (8, 8)), (height / 8, width / 8), order=1)
    light = 1 + (grain + spots)[..., None] / 190
    light[:: height // 4] *= 0.85
    light[:, :: width // 4] *= 0.85
    return np.array(color) * light


def with_robot(image, pose, red=RED, blue=BLUE):
    """Draw the robot at a pose (px of the area, rad) over a floor."""
    scale = image.shape[1] / AREA[0]
    x, y, heading = pose
    fine = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    reach = 52  # px of the area around the pose
    left, top = (int((p - reach) * scale) for p in (x, y))
    count = int(2 * reach * scale) + 2
    u = (left + np.arange(count)[:, None] + fine).ravel()
    v = (top + np.arange(count)[:, None] + fine).ravel()
    dx, dy = (u + 0.5) / scale - 0.5 - x, ((v + 0.5) / scale - 0.5 - y)[:, None]
    forward = dx * np.cos(heading) + dy * np.sin(heading)
    right = -dx * np.sin(heading) + dy * np.cos(heading)
    parts = (
        (BODY, forward**2 + right**2 < 46**2),
        (WHEEL, (abs(forward) < 14) & (abs(abs(right) - 41) < 4)),
        *(
            (color, np.hypot(forward - ahead, right - beside) < RADIUS)
            for color, (ahead, beside) in zip((red, blue), MARKERS.positions.values(), strict=True)
        ),
    )
    patch = image[top : top + count, left : left + count]
    colors = np.repeat(np.repeat(patch, SAMPLES, axis=0), SAMPLES, axis=1)
    for color, inside in parts:
        colors[inside] = color
    patch[:] = colors.reshape(count, SAMPLES, count, SAMPLES, 3).mean(axis=(1, 3))
    return image


@dataclass(frozen=True)
class Light:
    """What light and camera make of a scene."""

    exposure: float = 1.0
    gradient: tuple[float, float] = (1, 1)  # of the light, from left to right
    gains: tuple[float, float, float] = (1, 1, 1)
    markers: tuple = (RED, BLUE)
    floor: tuple[int, int, int] = FLOOR
    noise: object = None

    def frame(self, pose, size, seed, index):
        """The frame of a robot at a pose; None = no robot."""
        rng = np.random.default_rng((seed, index))
        image = floor(rng, size, self.floor)
        if pose is not None:
            image = with_robot(image, pose, *self.markers)
        light = self.exposure * np.linspace(*self.gradient, size[0])[:, None] * self.gains
        pixels = np.clip(np.rint(image * light), 0, 255).astype(np.uint8)
        if self.noise is not None:
            pixels = self.noise.add(pixels, seed, index)
        return robsim.Frame(pixels, plane_map=robsim.imaging.PlaneMap.scaled(size, AREA))


CASTS = ((1.3, 1, 0.8), (0.85, 1, 1.4), (1.4, 1, 0.5), (0.6, 1, 1.3), (0.8, 1.2, 0.8))
LIGHTS = {
    **{f"exposure {e}": Light(e) for e in (0.15, 0.2, 0.25, 0.3, 0.35, 0.5, 1, 2, 3)},
    **{f"gradient {a}-{b}": Light(gradient=(a, b)) for a, b in ((0.2, 1), (0.3, 1.2), (1, 0.15))},
    "faded": Light(markers=FADED),
    "faded, exposure .5": Light(0.5, markers=FADED),
    "faded, Gaussian 5 %": Light(markers=FADED, noise=robsim.GaussianNoise(5)),
    "faded, Gaussian 10 %": Light(markers=FADED, noise=robsim.GaussianNoise(10)),
    "exposure .3, Gaussian 5 %": Light(0.3, noise=robsim.GaussianNoise(5)),
    "exposure .3, Gaussian 10 %": Light(0.3, noise=robsim.GaussianNoise(10)),
    "exposure .15, Gaussian 2 %": Light(0.15, noise=robsim.GaussianNoise(2)),
    **{f"cast {r}, {g}, {b}": Light(gains=(r, g, b)) for r, g, b in CASTS},
    "cast 1.4, 1, .5 at .3": Light(0.3, gains=(1.4, 1, 0.5)),
    "cast .6, 1, 1.3 at .3": Light(0.3, gains=(0.6, 1, 1.3)),
    "green floor at .3": Light(0.3, floor=(110, 160, 100)),
    "wooden floor at .3": Light(0.3, floor=(185, 140, 95)),
    "blue floor at .3": Light(0.3, floor=(120, 140, 175)),
}

EMPTY = {
    "clean": None,
    **{f"Gaussian {p} %": robsim.GaussianNoise(p) for p in (5, 10, 20, 40)},
    **{f"uniform {p} %": robsim.UniformNoise(p) for p in (20, 60)},
}


def hsv_masks(image):
    """Red and blue by saturation and hue: (H, W) of bool each."""
    r, g, b = (image[..., i].astype(int) for i in range(3))
    value, least = image.max(axis=2).astype(int), image.min(axis=2).astype(int)
    is_colorful = 255 * (value - least) >= SATURATION * np.maximum(value, 10)
    # hues within 30 degrees of red and of blue
    spread = value - least
    is_red = (value == r) & (2 * abs(g - b) <= spread)
    is_blue = (value == b) & (2 * abs(r - g) <= spread)
    return {"red": is_colorful & is_red, "blue": is_colorful & is_blue}


def blobs_of(masks, least):
    """The components of masks as blobs, the largest 64 of each."""
    return {name: _blobs(name, mask, least) for name, mask in masks.items()}


def _blobs(name, mask, least):
    labels, _ = ndimage.label(mask, np.ones((3, 3)))
    areas = np.bincount(labels.ravel())
    areas[0] = 0
    found = [i for i in np.argsort(-areas, kind="stable")[:64] if areas[i] >= least]
    boxes = ndimage.find_objects(labels)
    height, width = mask.shape
    blobs = []
    for i in found:
        rows, columns = boxes[i - 1]
        v, u = np.nonzero(labels[rows, columns] == i)
        box = (columns.start, rows.start, columns.stop - 1, rows.stop - 1)
        centroid = (columns.start + u.mean(), rows.start + v.mean())
        edge = box[0] == 0 or box[1] == 0 or box[2] == width - 1 or box[3] == height - 1
        blobs.append(
            Blob(name, area=int(areas[i]), centroid=centroid, bounding_box=box, at_border=edge)
        )
    return blobs


def by_hsv(frame):
    """A plain HSV detector, and the same choice of a pair."""
    least = MARKERS.areas["right"] / 8 * (frame.image.shape[1] / AREA[0]) ** 2
    return detect(blobs_of(hsv_masks(frame.image), least), MARKERS, plane_map=frame.plane_map)


def by_classes(frame, *, second_chance=True):
    """As the default measurement does it, with and without a second chance."""
    colors = robsim.load_colors()
    blobs = robsim.find_blobs(frame, colors, markers=MARKERS)
    given = {"colors": colors} if second_chance else {}
    return detect(blobs, MARKERS, plane_map=frame.plane_map, image=frame, **given)


FINDERS = {
    "first chance": lambda frame: by_classes(frame, second_chance=False),
    "second chance": by_classes,
    "HSV": by_hsv,
}


def poses_of(count, seed):
    rng = np.random.default_rng(seed)
    return np.column_stack((rng.uniform(60, 540, (count, 2)), rng.uniform(-np.pi, np.pi, count)))


def distances(find, light, size, poses, seed=1):
    """How far the measured places are off (px of the area): (N,), NaN where none is found."""
    result = np.full(len(poses), np.nan)
    for i, pose in enumerate(poses):
        found = find(light.frame(pose, size, seed, i)).measurement
        if found is not None:
            result[i] = np.hypot(*(found.pose[:2] - pose[:2]))
    return result


def reported(find, light, size, count, seed=1):
    """On how many of so many empty floors a pose is reported."""
    frames = (light.frame(None, size, seed, i) for i in range(count))
    return sum(find(frame).measurement is not None for frame in frames)


def _cell(distance):
    seen = distance[np.isfinite(distance)]
    good = seen[seen <= FALSE]
    rms = np.sqrt(np.mean(good**2)) if len(good) else np.nan
    return f"{len(seen):4d} {len(seen) - len(good):2d} {rms:7.3f} px"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=30, help="of a size and light")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", help="only the lights whose name contains this text")
    given = parser.parse_args()
    for size in SIZES:
        _print_lights(size, given)
    _print_empty_floors(given)


def _heads():
    return " " * 30 + "".join(f"{name:>20}" for name in FINDERS)


def _print_lights(size, given):
    width = np.sqrt(MARKERS.areas["right"]) * size[0] / AREA[0]
    print(f"\nmarkers of {width:.1f} px, {given.frames} frames: found, false, rms\n{_heads()}")
    poses = poses_of(given.frames, given.seed)
    for name, light in LIGHTS.items():
        if (given.case or "") in name:
            off = [distances(find, light, size, poses, given.seed) for find in FINDERS.values()]
            print(f"{name:30}" + "".join(f"{_cell(each):>20}" for each in off), flush=True)


def _print_empty_floors(given):
    print(f"\nposes reported on {given.frames} empty floors\n{_heads()}")
    for (width, height), exposure in itertools.product(((320, 240), (640, 480)), (1, 0.3)):
        for noise in EMPTY:
            title = f"{width} x {height}, {exposure:g}, {noise}"
            if (given.case or "") not in title:
                continue
            light = Light(exposure, noise=EMPTY[noise])
            counts = [
                reported(find, light, (width, height), given.frames, given.seed)
                for find in FINDERS.values()
            ]
            print(f"{title:30}" + "".join(f"{count:20d}" for count in counts), flush=True)


if __name__ == "__main__":
    main()
