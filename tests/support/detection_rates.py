"""How well the default vision finds the robot, by size of the camera, noise and light.

    python tests/support/detection_rates.py --frames 200

prints, for every camera and every disturbance: frames with a pose, false ones among them, rms of
the others (work-area px, degrees), and the poses reported on as many frames of an empty floor.
Frames are drawn by the core with poses anywhere, and disturbed, from a seed.
"""

import argparse
import io
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageFilter

import robsim
from robsim.vision import detect
from scenes import AREA, false_poses, poses_within, renderer, rms

CAMERAS = ((200, 200), (240, 240), (320, 240), (320, 320), (360, 360), (480, 480), (640, 480), AREA)


def dimmed(exposure):
    return lambda image: (image * exposure + 0.5).astype(np.uint8)


def faded(image):
    """With half of its contrast and colour."""
    return (128 + (image.astype(float) - 128) * 0.55).astype(np.uint8)


def blurred(image):
    return np.asarray(Image.fromarray(image).filter(ImageFilter.GaussianBlur(1)))


def compressed(quality):
    def disturb(image):
        file = io.BytesIO()
        Image.fromarray(image).save(file, "JPEG", quality=quality)
        return np.asarray(Image.open(file))

    return disturb


def tinted(*gains):
    return lambda image: np.clip(image * np.array(gains), 0, 255).astype(np.uint8)


def littered(count, seed=7):
    """With discs as red and as blue as the markers, and about as large."""

    def disturb(image):
        rng = np.random.default_rng((seed, int(image.sum())))
        height, width = image.shape[:2]
        result = image.copy()
        for i in range(count):
            u, v = rng.integers(0, width), rng.integers(0, height)
            radius = rng.uniform(8, 30) * width / AREA[0]
            far = int(radius)
            part = result[max(0, v - far) : v + far + 1, max(0, u - far) : u + far + 1]
            dv, du = np.mgrid[: part.shape[0], : part.shape[1]]
            disc = (du - min(u, far)) ** 2 + (dv - min(v, far)) ** 2 < radius**2
            part[disc] = ((199, 37, 41), (29, 63, 171))[i % 2]
        return result

    return disturb


NOISES = {
    "clean": None,
    **{f"Gaussian {p} %": robsim.GaussianNoise(p) for p in (5, 10, 20, 30, 40, 60)},
    **{f"uniform {p} %": robsim.UniformNoise(p) for p in (20, 40, 60)},
}

#: Disturbance before the noise, noise.
CASES = {name: (None, noise) for name, noise in NOISES.items()} | {
    "exposure .5": (dimmed(0.5), None),
    "exposure .35": (dimmed(0.35), None),
    "exposure .6, Gaussian 20 %": (dimmed(0.6), robsim.GaussianNoise(20)),
    "exposure .6, Gaussian 40 %": (dimmed(0.6), robsim.GaussianNoise(40)),
    "faded, Gaussian 10 %": (faded, robsim.GaussianNoise(10)),
    "blur 1 px": (blurred, None),
    "JPEG 75": (compressed(75), None),
    "JPEG 50": (compressed(50), None),
    "reddish": (tinted(1.3, 1, 0.8), None),
    "bluish": (tinted(0.85, 1, 1.4), None),
    **{f"{count} discs": (littered(count), None) for count in (20, 60, 200, 300)},
}


@dataclass
class Rates:
    """What was found in some frames with a robot, and in some without."""

    frames: int
    found: int
    false: int
    position: float
    heading: float
    on_empty_floor: int

    def __str__(self):
        return (
            f"{self.found:4d} found {self.false:3d} false  {self.position:6.3f} px "
            f"{self.heading:6.3f} deg  {self.on_empty_floor:3d} on the empty floor"
        )


def measured(camera, disturb, noise, poses, *, seed=1, smoothing=None):
    """Measured minus true poses (N, 3), NaN where none was found; nan poses = empty floor."""
    draw = renderer(resolution=camera)
    markers, colors = robsim.load_robot("lab").marker_layout(), robsim.load_colors()
    plane_map = robsim.imaging.PlaneMap.scaled(camera, AREA)
    errors = np.full((len(poses), 3), np.nan)
    for i, pose in enumerate(poses):
        image = draw.render(np.nan_to_num(pose, nan=-9 * AREA[0]))
        image = image if disturb is None else disturb(image)
        image = image if noise is None else noise.add(image, seed, i)
        frame = robsim.Frame(image, plane_map=plane_map)
        blobs = robsim.find_blobs(frame, colors, markers=markers, smoothing=smoothing)
        found = detect(blobs, markers, plane_map=plane_map, image=frame, colors=colors).measurement
        if found is not None:
            errors[i] = found.pose - np.nan_to_num(pose)
            errors[i, 2] = robsim.wrap_angle(errors[i, 2])
    return errors


def rates(camera, disturb, noise, frames, *, empty=None, seed=1, smoothing=None):
    """The rates over this many frames with a robot, and `empty` without (default: as many)."""
    poses = poses_within(np.random.default_rng(seed), frames, margin=70)
    nowhere = np.full((frames if empty is None else empty, 3), np.nan)
    options = {"seed": seed, "smoothing": smoothing}
    errors = measured(camera, disturb, noise, poses, **options)
    on_empty_floor = np.isfinite(measured(camera, disturb, noise, nowhere, **options)[:, 0]).sum()
    errors = errors[np.isfinite(errors[:, 0])]
    false = false_poses(errors)
    position, heading = rms(errors[~false]) if (~false).any() else (np.nan, np.nan)
    found = {"found": len(errors), "false": int(false.sum())}
    return Rates(frames, **found, position=position, heading=heading, on_empty_floor=on_empty_floor)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=100, help="of a camera and disturbance")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--smoothing", type=int, help="px, in place of the default")
    parser.add_argument("--case", help="only the disturbances whose name contains this text")
    given = parser.parse_args()
    cases = {name: case for name, case in CASES.items() if (given.case or "") in name}
    for camera in CAMERAS:
        scale = np.sqrt(camera[0] * camera[1] / AREA[0] / AREA[1])
        width = scale * np.sqrt(robsim.load_robot("lab").marker_layout().areas["right"])
        print(f"\n{camera[0]} x {camera[1]} px: markers of {width:.1f} px, {given.frames} frames")
        for name, (disturb, noise) in cases.items():
            found = rates(
                camera, disturb, noise, given.frames, seed=given.seed, smoothing=given.smoothing
            )
            print(f"{name:27} {found}", flush=True)


if __name__ == "__main__":
    main()
