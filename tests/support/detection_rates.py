"""How often the default vision finds the robot in disturbed frames of the renderer."""

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image

import robsim
from robsim.vision import detect
from scenes import AREA, false_poses, poses_within, renderer


def dimmed(exposure):
    return lambda image: (image * exposure + 0.5).astype(np.uint8)


def compressed(quality):
    def disturb(image):
        file = io.BytesIO()
        Image.fromarray(image).save(file, "JPEG", quality=quality)
        return np.asarray(Image.open(file))

    return disturb


#: Disturbance before the noise, noise.
CASES = {
    "Gaussian 20 %": (None, robsim.GaussianNoise(20)),
    "Gaussian 40 %": (None, robsim.GaussianNoise(40)),
    "uniform 40 %": (None, robsim.UniformNoise(40)),
    "uniform 60 %": (None, robsim.UniformNoise(60)),
    "exposure .5": (dimmed(0.5), None),
    "exposure .6, Gaussian 20 %": (dimmed(0.6), robsim.GaussianNoise(20)),
    "JPEG 50": (compressed(50), None),
}


@dataclass
class Rates:
    """What was found in some frames with a robot, and in some without."""

    found: int
    false: int
    on_empty_floor: int


def measured(camera, disturb, noise, poses, *, seed=1):
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
        blobs = robsim.find_blobs(frame, colors, markers=markers)
        found = detect(blobs, markers, plane_map=plane_map, image=frame, colors=colors).measurement
        if found is not None:
            errors[i] = found.pose - np.nan_to_num(pose)
            errors[i, 2] = robsim.wrap_angle(errors[i, 2])
    return errors


def rates(camera, disturb, noise, frames, *, empty):
    """The rates over so many frames with a robot, and `empty` without."""
    poses = poses_within(np.random.default_rng(1), frames, margin=70)
    errors = measured(camera, disturb, noise, poses)
    errors = errors[np.isfinite(errors[:, 0])]
    nowhere = measured(camera, disturb, noise, np.full((empty, 3), np.nan))
    return Rates(len(errors), false_poses(errors).sum(), np.isfinite(nowhere[:, 0]).sum())
