"""Colour classes in training: regions of pictures, ranges, found blobs and pixels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim._core import ColorClass, Frame, MarkerLayout, PlaneMap, classify, detect, find_blobs
from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.gui._link import boxes_of, numbers
from robsim.gui.tools.history import History
from robsim.vision.imaging import images
from robsim.vision.markers.painting import paint_of
from robsim.vision.markers.training import Sample

Region = tuple[int, int, int, int]
Counts = NDArray[np.int64]

_MOST_CLASSES = 32  # the limit of `find_blobs`
_MOST_SAMPLES = 100  # of a class
OPTIONS = ("percentile", "margin", "limit_y")
_ONE_PIXEL = np.eye(1, 256, 128, dtype=np.int64).repeat(3, axis=0)


@dataclass(frozen=True, eq=False)
class TrainedClass:
    """A class and its training data."""

    color: ColorClass
    samples: tuple[Sample, ...] = ()  # empty if the ranges were loaded or set by hand
    percentile: float = 33.0
    margin: int = 52
    limit_y: bool = False

    @property
    def histograms(self) -> Counts:
        """The histograms of all samples together."""
        zero = np.zeros((3, 256), np.int64)
        return sum((sample.histograms for sample in self.samples), zero)

    @property
    def around(self) -> Floats | None:
        """Chroma around the samples: median of all pictures, the largest spread; None = unknown."""
        known = [sample.around for sample in self.samples if sample.around is not None]
        if not known or len(known) < len(self.samples):
            return None
        medians, spreads = np.swapaxes(known, 0, 1)
        return np.array([np.median(medians, axis=0), np.max(spreads, axis=0)])

    def remade(self) -> TrainedClass:
        """Return the class recomputed from its samples; ValueError if they are grey."""
        if not self.samples:
            return self
        color = ColorClass.from_histograms(
            self.histograms,
            name=self.color.name,
            percentile=self.percentile,
            margin=self.margin,
            limit_y=self.limit_y,
            around=self.around,
        )
        return replace(self, color=color)


class ColorTraining(History[Mapping[str, TrainedClass]]):
    """Several colour classes during training."""

    def __init__(self, colors: Iterable[ColorClass] = ()) -> None:
        super().__init__({color.name: TrainedClass(color) for color in colors})
        self._next: dict[str, dict[str, Any]] = {}  # options of classes without samples

    @property
    def classes(self) -> Mapping[str, TrainedClass]:
        """The classes by name, in the order of the file."""
        return self._now

    @property
    def value(self) -> tuple[ColorClass, ...]:
        return tuple(one.color for one in self.classes.values())

    def train(
        self,
        name: str,
        image: images.Pixels,
        region: Region,
        *,
        picture: str = "",
        keep: int = 0,
        goes_on: bool = False,
    ) -> None:
        """Make a class from a region of a picture and the first `keep` previous regions.

        `goes_on`, here and below: the change extends the previous one; one undo reverts both.
        ValueError: the region is outside or grey, or there are too many; nothing changes.
        """
        sample = Sample.of(image, region, picture)
        before = self.classes.get(name)
        samples = (*(before.samples[:keep] if before else ()), sample)
        if len(samples) > _MOST_SAMPLES:
            raise ValueError(f"a colour must have at most {_MOST_SAMPLES} regions")
        made = TrainedClass(ColorClass(name), samples, **self.options(name))
        self._put(made.remade(), goes_on=goes_on)

    def adjust(self, name: str, *, goes_on: bool = False, **options: float | bool) -> None:
        """Set `percentile`, `margin` or `limit_y` of a class, and recompute it from its samples.

        A class without samples, or a new name, gets the options with its first samples. ValueError:
        an option is out of range; nothing changes.
        """
        chosen = self.options(name) | options
        ColorClass.from_histograms(_ONE_PIXEL, name=name, **(chosen | {"limit_y": True}))
        before = self.classes.get(name)
        if before is None:
            self._next[name] = chosen
            return
        made = TrainedClass(before.color, before.samples, **chosen)
        self._put(made.remade(), goes_on=goes_on)

    def options(self, name: str) -> dict[str, Any]:
        """Return `percentile`, `margin` and `limit_y` of a class, even before its first sample."""
        one = self.classes.get(name) or TrainedClass(ColorClass(name), **self._next.get(name, {}))
        return {key: getattr(one, key) for key in OPTIONS}

    def put(self, color: ColorClass, *, goes_on: bool = False) -> None:
        """Set the ranges of a class by hand, or add a class; samples are kept for comparison."""
        self._put(self._with(color), goes_on=goes_on)

    def replace(self, colors: Iterable[ColorClass]) -> None:
        """Replace all classes by `colors`; classes with the same name keep their samples.

        ValueError: too many classes; nothing changes.
        """
        colors = tuple(colors)
        _check_count(len(colors))
        self.go_to({color.name: self._with(color) for color in colors})

    def remove(self, name: str) -> None:
        gone = self._known(name)
        self.go_to({key: one for key, one in self.classes.items() if one is not gone})

    def drift(self, name: str) -> list[tuple[str, Floats, float]]:
        """Return picture, medians of Y, U, V and the share in the class, of each sample."""
        one = self._known(name)
        return [
            (sample.picture, sample.medians, sample.share_in(one.color)) for sample in one.samples
        ]

    def _with(self, color: ColorClass) -> TrainedClass:
        """Return the named class with other ranges; regions and options stay."""
        return replace(self.classes.get(color.name, TrainedClass(color)), color=color)

    def _put(self, made: TrainedClass, *, goes_on: bool) -> None:
        classes = {**self.classes, made.color.name: made}
        _check_count(len(classes))
        self.go_to(classes, goes_on=goes_on)

    def _known(self, name: str) -> TrainedClass:
        if name not in self.classes:
            raise ValueError(f"unknown colour {quoted(name)}")
        return self.classes[name]


def _check_count(count: int) -> None:
    if count > _MOST_CLASSES:
        raise ValueError(f"there must be at most {_MOST_CLASSES} colours, got {count}")


def ranges_of(color: ColorClass) -> tuple[tuple[int, int], ...]:
    return color.y, color.u, color.v


_LARGEST = 1600  # px along a side of a mask


def found_in(frame: Frame, colors: Sequence[ColorClass], markers: MarkerLayout) -> dict[str, Any]:
    """Return the boxes of the blobs, and the pose of the robot or the reason for its absence."""
    blobs = find_blobs(frame, list(colors), markers=markers)
    found = detect(blobs, markers, plane_map=frame.plane_map, image=frame, colors=list(colors))
    pose = None if found.measurement is None else numbers(found.measurement.pose)
    missed = found.explanation if found.by_second_chance or pose is None else None
    return {"boxes": boxes_of(blobs), "found": pose, "missed": missed}


def painted(
    frame: Frame, colors: Sequence[ColorClass], markers: MarkerLayout
) -> tuple[NDArray[np.uint8], list[tuple[int, ...]]]:
    """Return the class number of each pixel, from 1, and the RGB of each class.

    A large picture is reduced to every second pixel, every third, and so on.
    """
    step = -(-max(frame.image.shape[:2]) // _LARGEST)
    if step > 1:
        to_area = frame.plane_map.matrix @ np.diag((step, step, 1.0))
        pixels = np.ascontiguousarray(frame.image[::step, ::step])
        frame = Frame(pixels, plane_map=PlaneMap(to_area))
    masks = classify(frame, list(colors), markers=markers)  # as in finding blobs
    index = np.zeros(frame.image.shape[:2], np.uint8)
    for number, mask in enumerate(masks.values(), start=1):
        index[mask] = number
    inks = [paint_of(name, number) for number, name in enumerate(masks)]
    return index, inks
