"""Training of colours on several frames: with a region each, or along a robot's track."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim._core import (
    ColorClass,
    Detection,
    Frame,
    MarkerLayout,
    Observation,
    color_histograms,
    detect,
    find_blobs,
    surrounding_chroma,
)
from robsim.base.checks import Floats, check_bool, check_kind, is_int
from robsim.base.text import listed, quoted
from robsim.vision.imaging.images import Pixels
from robsim.vision.markers.color_files import as_colors
from robsim.vision.markers.trained_color import TrainedColor

Region = tuple[int, int, int, int]

_AROUND_LIMIT = 0.25  # of an image; a larger region leaves too little around it
_AXES = 3  # of pixels (H, W, 3)
_CHANNELS = ("y", "u", "v")
_ONE_PIXEL = np.eye(1, 256, 128, dtype=np.int64).repeat(3, axis=0)


def train_color(
    images: Frame | Pixels | Iterable[Frame | Pixels],
    regions: Region | Sequence[Region],
    *,
    name: str,
    percentile: float | None = None,
    margin: int | None = None,
    limit_y: bool = False,
) -> TrainedColor:
    """Train a colour on regions of several images, for example of a marker in different light.

    The ranges of the class cover the classes of all regions, so the class is valid in each image.

    Parameters
    ----------
    images : Frame, array (H, W, 3) of uint8, or iterable of them
        RGB.
    regions : tuple of four ints, or sequence of them
        (left, top, right, bottom), all included (px): one for each image; for a single image, any
        number.
    name, percentile, margin, limit_y
        As for `ColorClass.from_region`.

    Returns
    -------
    TrainedColor
        The class, and the drift of the colour's level and chroma from image to image.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape. If a region does not lie within its image, or
        has hardly any colour; with several regions the message names the region.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, noise=robsim.GaussianNoise(8), robot="lab")
    >>> step = sim.step()
    >>> x, y = (int(value) for value in step.blobs["red"][0].centroid)
    >>> region = (x - 4, y - 4, x + 4, y + 4)
    >>> robsim.vision.train_color([step.frame], [region], name="red").color
    ColorClass('red', y=(0, 255), u=(0, 159), v=(154, 255))
    """
    boxes = _boxes(regions)
    shown = _images(images)
    if len(shown) == 1:
        shown *= len(boxes)
    if len(shown) != len(boxes):
        raise ValueError(
            f"regions must have one region per image, got {len(boxes)} regions for {len(shown)} "
            "images"
        )
    samples = _Samples(name, percentile, margin, limit_y)
    for k, (image, box) in enumerate(zip(shown, boxes, strict=True)):
        try:
            samples.add(k, image, box)
        except ValueError as error:
            if len(boxes) > 1:
                error.add_note(f"in region {k + 1} of {len(boxes)}")
            raise
    return samples.trained()


def train_markers(
    frames: Iterable[Frame | Observation | Pixels],
    markers: MarkerLayout,
    *,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
    regions: Mapping[str, Region] | None = None,
    percentile: float | None = None,
    margin: int | None = None,
) -> tuple[TrainedColor, TrainedColor]:
    """Train the colours of both markers on a recording of the driving robot.

    The robot is located in each frame, and the colours are trained on the inner part of its
    markers. So the colours are valid along the whole path of the robot, in the light of every part
    of the floor.

    Parameters
    ----------
    frames : iterable of Frame, Observation, or array (H, W, 3) of uint8
        A `Recording`, a `Session`, a list. Lengths of arrays are in px of the work area.
    markers : MarkerLayout
        The positions of the markers on the robot.
    colors : path, iterable of ColorClass, optional
        The initial colours, including the markers'. Default: the colours shipped with robsim.
        It is sufficient if these find the robot by the second chance; see `Detection`.
    regions : dict of str to tuple of four ints, optional
        Instead of `colors`: the region of each marker colour, such as ``"red"`` and ``"blue"``, in
        the first frame (px).
    percentile, margin
        As for `ColorClass.from_region`.

    Returns
    -------
    tuple of TrainedColor
        The colours of both markers in the order of their roles, right before left, or front before
        back. Each colour includes its drift from frame to frame.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or if there are no frames. If the robot is found
        in no frame; the message gives the reason.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, noise=robsim.GaussianNoise(8), robot="lab")
    >>> frames = [sim.step().frame for _ in range(5)]
    >>> markers = robsim.load_robot("lab").marker_layout()
    >>> right, left = robsim.vision.train_markers(frames, markers)
    >>> right.color.name, left.color.name
    ('red', 'blue')
    """
    check_kind("markers", markers, MarkerLayout)
    if colors is not None and regions is not None:
        raise ValueError("colors and regions must not both be given")
    names = [*markers.colors.values()]
    boxes = None if regions is None else _marker_boxes(regions, names)
    classes = None if regions is not None else _marker_classes(colors, names)
    samples = {name: _Samples(name, percentile, margin, limit_y=False) for name in names}
    missed: list[str] = []
    for k, frame in _frames(frames):
        if classes is None:
            assert boxes is not None
            classes = [_class_in(frame, boxes[name], name, percentile, margin) for name in names]
        detection = _detected(frame, classes, markers)
        if detection.measurement is None:
            missed.append(f"in frame {k} {detection.explanation}")
            continue
        assert detection.seen is not None
        for blob in detection.seen.values():
            try:
                samples[blob.color].add(k, frame, square_within(blob.area, blob.centroid))
            except ValueError as error:
                samples[blob.color].skip(f"in frame {k}, {blob.color}: {error}")
    if not missed and not any(one.count for one in samples.values()):
        raise ValueError("frames must have at least one frame, got none")
    first, second = (samples[name].trained(missed) for name in names)
    return first, second


@dataclass(frozen=True, eq=False)
class Sample:
    """A region of a picture in the colour."""

    picture: str  # which one, for people
    region: Region
    histograms: NDArray[np.int64]  # (3, 256): how many pixels have each value of Y, U and V
    around: Floats | None = None  # chroma around it, (2, 2); None if it is most of the picture

    @classmethod
    def of(cls, image: Frame | Pixels, region: Region, picture: str) -> Sample:
        """Return the sample of a region of a picture; ValueError if it lies outside."""
        histograms = color_histograms(image, region)
        pixels = image.image if isinstance(image, Frame) else image
        is_most = histograms[0].sum() >= _AROUND_LIMIT * pixels.shape[0] * pixels.shape[1]
        return cls(picture, region, histograms, None if is_most else surrounding_chroma(image))

    @property
    def medians(self) -> Floats:
        """Medians of Y, U and V."""
        parts = np.cumsum(self.histograms, axis=1) / self.histograms.sum(axis=1, keepdims=True)
        return np.asarray((parts < 0.5).sum(axis=1), float)

    def share_in(self, color: ColorClass) -> float:
        """Return the share of its pixels in a class, in the channel with the smallest share."""
        taken = [
            counts[lower : upper + 1].sum()
            for counts, (lower, upper) in zip(
                self.histograms, (color.y, color.u, color.v), strict=True
            )
        ]
        return float(min(taken) / self.histograms[0].sum())


class _Samples:
    """The regions of a colour, frame by frame."""

    def __init__(
        self, name: str, percentile: float | None, margin: int | None, limit_y: bool
    ) -> None:
        given = {"percentile": percentile, "margin": margin}
        self._options: dict[str, Any] = {
            "name": name,
            "limit_y": check_bool("limit_y", limit_y),
            **{key: value for key, value in given.items() if value is not None},
        }
        # Errors in the options are raised before a recording is read.
        ColorClass.from_histograms(_ONE_PIXEL, **(self._options | {"limit_y": True}))
        self._frames: list[int] = []
        self._regions: list[Sample] = []
        self._classes: list[ColorClass] = []
        self._skipped: list[str] = []

    def add(self, k: int, image: Frame | Pixels, region: Region) -> None:
        """Take a region of frame k; ValueError if it is grey."""
        one = Sample.of(image, region, f"frame {k}")
        self._classes.append(
            ColorClass.from_histograms(one.histograms, around=one.around, **self._options)
        )
        self._regions.append(one)
        self._frames.append(k)

    @property
    def count(self) -> int:
        return len(self._frames) + len(self._skipped)

    def skip(self, why: str) -> None:
        self._skipped.append(why)

    def trained(self, missed: Sequence[str] = ()) -> TrainedColor:
        """Return the class of all regions together, and the drift."""
        left_out = [*missed, *self._skipped]
        if not self._frames:
            raise ValueError(
                f"frames must show {self._options['name']}, but no frame does: {left_out[0]}"
            )
        color = _widest(self._classes)
        medians = np.array([one.medians for one in self._regions])
        return TrainedColor(
            color=color,
            frames=np.array(self._frames),
            medians=medians,
            margins=np.array([margin_of(color, one) for one in medians]),
            shares=np.array([one.share_in(color) for one in self._regions]),
            histograms=np.sum([one.histograms for one in self._regions], axis=0),
            missed=len(left_out),
        )


def _class_in(
    frame: Frame | Pixels, box: Region, name: str, percentile: float | None, margin: int | None
) -> ColorClass:
    samples = _Samples(name, percentile, margin, limit_y=False)
    try:
        samples.add(0, frame, box)
        return samples.trained().color
    except ValueError as error:
        error.add_note(f"in the region of {name}, in the first frame")
        raise


def _detected(
    frame: Frame | Pixels, classes: Sequence[ColorClass], markers: MarkerLayout
) -> Detection:
    blobs = find_blobs(frame, classes, markers=markers)
    options = {"plane_map": frame.plane_map} if isinstance(frame, Frame) else {}
    return detect(blobs, markers, image=frame, colors=classes, **options)


def square_within(area: float, centroid: Floats) -> tuple[int, int, int, int]:
    """Return (left, top, right, bottom) of half the area (px): it fits into a round marker, too."""
    half_width = 0.35 * np.sqrt(area)
    left, top = np.rint(centroid - half_width).astype(int).tolist()
    right, bottom = np.rint(centroid + half_width).astype(int).tolist()
    return left, top, right, bottom


def _widest(classes: Sequence[ColorClass]) -> ColorClass:
    """Return the smallest class that contains all these classes."""
    ranges = {
        channel: (
            min(getattr(color, channel)[0] for color in classes),
            max(getattr(color, channel)[1] for color in classes),
        )
        for channel in _CHANNELS
    }
    return ColorClass(classes[0].name, **ranges)


def margin_of(color: ColorClass, yuv: Floats) -> float:
    """Return the distance of a colour (3,) to the nearest limit of a class, except open ends."""
    inside = []
    for channel, value in zip(_CHANNELS, yuv, strict=True):
        lower, upper = getattr(color, channel)
        inside += [value - lower] * (lower > 0) + [upper - value] * (upper < 255)
    return float(min(inside, default=255.0))


def _images(images: Any) -> list[Frame | Pixels]:
    if _is_picture(images):
        return [images]
    if isinstance(images, (str, bytes, dict)) or not isinstance(images, Iterable):
        raise TypeError(f"images must be an image or a list of images, got {quoted(images)}")
    shown = list(images)
    if not shown:
        raise ValueError("images must have at least one image, got none")
    for image in shown:
        if not _is_picture(image):
            raise TypeError(f"images must contain only images, got {quoted(image)}")
    return shown


def _boxes(regions: Any) -> list[Region]:
    expected = "regions must be (left, top, right, bottom), four ints, or a list of such"
    if isinstance(regions, (str, bytes, dict)) or not isinstance(regions, Iterable):
        raise TypeError(f"{expected}, got {quoted(regions)}")
    boxes = list(regions)
    if not boxes:
        raise ValueError("regions must have at least one region, got none")
    if all(is_int(side) for side in boxes):
        boxes = [tuple(boxes)]
    for box in boxes:
        if np.shape(box) != (4,) or not all(is_int(side) for side in box):
            raise TypeError(f"{expected}, got one of {quoted(box)}")
    return boxes


def _frames(frames: Any) -> Iterable[tuple[int, Frame | Pixels]]:
    if isinstance(frames, (str, bytes, dict, Frame)) or not isinstance(frames, Iterable):
        raise TypeError(
            f"frames must be an iterable of frames, such as a Recording, got {quoted(frames)}"
        )
    for k, one in enumerate(getattr(frames, "_each", frames.__iter__)()):
        frame = one.frame if isinstance(one, Observation) else one
        if frame is None:
            continue  # a step without a frame
        if not _is_picture(frame):
            raise TypeError(f"frames must contain only frames, got {quoted(one)}")
        yield k, frame


def _is_picture(value: Any) -> bool:
    """Return whether a value is a frame or pixels; its size is checked later, on use."""
    if isinstance(value, Frame):
        return True
    return isinstance(value, np.ndarray) and value.dtype == np.uint8 and value.ndim == _AXES


def _marker_boxes(regions: Any, names: Sequence[str]) -> dict[str, Region]:
    both = " and ".join(map(repr, names))
    if not isinstance(regions, Mapping):
        raise TypeError(f"regions must be a dict with {both}, got {quoted(regions)}")
    if set(regions) != set(names):
        raise ValueError(f"regions must have exactly the keys {both}, got {listed(regions)}")
    return dict(regions)


def _marker_classes(colors: Any, names: Sequence[str]) -> list[ColorClass]:
    by_name = {color.name: color for color in as_colors(colors)}
    missing = [name for name in names if name not in by_name]
    if missing:
        both = " and ".join(names)
        raise ValueError(f"colors must have {both}, got no {' and no '.join(missing)}")
    return [by_name[name] for name in names]
