"""How exact the measurement is in frames drawn by other code: without and with the image.

    python tests/support/foreign_accuracy.py --frames 80 [--cases clean "Gaussian 40 %"] [--hsv]

prints for every case of `foreign_frames` and every way to measure: rms error over the poses that
are found and not false (px of the work area, degrees), misses, false poses, and the mean NEES / 3
of the covariance that a measurement carries. Ways: "counted", `locate` of the blobs alone;
"fitted", `locate` with image and colours as well; "hsv", the same with blobs of an HSV threshold.

The exit status is 1 if the fit is worse than the count in any case, by more than the spread.
"""

import argparse
import sys
from dataclasses import dataclass

import numpy as np

import robsim
from foreign_frames import CASES, VIEWS, frames, layout_of
from hsv_detector import hsv_blobs
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


def hsv(frame, markers):
    """By the centroids of what OpenCV finds by hue and saturation."""
    return robsim.locate(hsv_blobs(frame, markers), markers, frame.plane_map)


WAYS = {"counted": counted, "fitted": fitted, "hsv": hsv}


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


def row(errors):
    """The columns of a way in the table."""
    place, heading = errors.rms()
    counts = f"{np.sum(~errors.found):4d} {np.sum(errors.false):4d}"
    return f"{place:7.3f} {heading:7.3f} {counts} {errors.nees:6.2f}".replace("nan", "  -")


def report(names, count, ways):
    """Print a table for each view; return the cases in which the fit is worse than the count."""
    failed = []
    columns = " | ".join(f"{way:>7} px     deg miss fals NEES/3"[:33] for way in ways)
    for of_view, view in VIEWS.items():
        print(f"\nmarkers {of_view} wide, {count} frames a case\n{'':42} {columns}")
        for name in names:
            found = compared(name, view, count, ways)
            if reasons := ", ".join(worse(found["fitted"], found["counted"])):
                failed.append(f"{name}, markers of {of_view}: {reasons}")
            print(f"{name:42} {' | '.join(row(one) for one in found.values())} {reasons}")
    return failed


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=80, help="of a case")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES), metavar="CASE")
    parser.add_argument("--hsv", action="store_true", help="an HSV threshold beside them")
    given = parser.parse_args(arguments)
    ways = {name: way for name, way in WAYS.items() if name != "hsv" or given.hsv}
    failed = report(given.cases, given.frames, ways)
    if failed:
        print("\nThe fit is worse than the count in:", *failed, sep="\n  ")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
