"""How exact the measurement is in frames drawn by other code: without and with the image."""

from dataclasses import dataclass

import numpy as np

import robsim
from foreign_frames import CASES, frames, layout_of
from scenes import false_poses, rms

COLORS = robsim.load_colors()

#: By how much the rms of one way may exceed that of another, beside two standard errors.
EQUAL = 1.03


def counted(frame, markers):
    """By the centroids of the blobs, every pixel counted once."""
    blobs = robsim.find_blobs(frame, COLORS, markers=markers)
    return robsim.locate(blobs, markers, frame.plane_map)


def fitted(frame, markers):
    """By the markers' edges in the image; with a second chance in dim light, as a run measures."""
    blobs = robsim.find_blobs(frame, COLORS, markers=markers)
    return robsim.locate(blobs, markers, frame.plane_map, image=frame, colors=COLORS)


@dataclass
class Errors:
    """Measured minus true poses: array (N, 3) in px, px, rad; NaN where none was found.

    `squared` are the errors squared and normalised by the covariance, e' C^-1 e: array (N,).
    """

    poses: np.ndarray
    squared: np.ndarray

    @property
    def found(self):
        return np.isfinite(self.poses[:, 0])

    @property
    def false(self):
        return self.found & false_poses(self.poses)

    @property
    def good(self):
        return self.found & ~self.false

    @property
    def nees(self):
        """The mean NEES / 3 of the poses that are not false: 1 where the covariance is right."""
        return np.mean(self.squared[self.good]) / 3 if self.good.any() else np.nan

    def rms(self):
        """Place (px) and heading (degrees), of the poses that are not false."""
        return rms(self.poses[self.good]) if self.good.any() else (np.nan, np.nan)


def compared(name, view, count, ways):
    """The errors of each way (name to function) in the same frames of a case."""
    markers = layout_of(CASES[name])
    found = {way: Errors(np.full((count, 3), np.nan), np.full(count, np.nan)) for way in ways}
    for k, (frame, pose) in enumerate(frames(name, view, count)):
        for way, measure in ways.items():
            if (measurement := measure(frame, markers)) is None:
                continue
            error = measurement.pose - pose
            error[2] = robsim.wrap_angle(error[2])
            found[way].poses[k] = error
            if (covariance := getattr(measurement, "covariance", None)) is not None:
                found[way].squared[k] = error @ np.linalg.solve(covariance, error)
    return found


def worse(new, old):
    """In what new errors are worse than old ones of the same frames, beyond the spread: texts."""
    both = new.good & old.good
    reasons = []
    for name, columns in (("place", slice(0, 2)), ("heading", slice(2, 3))):
        mine, yours = (np.sum(one.poses[both, columns] ** 2, axis=1) for one in (new, old))
        excess = mine - EQUAL**2 * yours
        if len(excess) > 1 and excess.mean() > 2 * excess.std(ddof=1) / np.sqrt(len(excess)):
            reasons.append(name)
    for name, mine, yours in (
        ("misses", ~new.found, ~old.found),
        ("false poses", new.false, old.false),
    ):
        # of the frames in which they differ, each is either's with the same probability
        more, fewer = np.sum(mine & ~yours), np.sum(yours & ~mine)
        if more - fewer > 2 * np.sqrt(more + fewer):
            reasons.append(name)
    return reasons
