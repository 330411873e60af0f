"""Robustness score of a colour class against lighting and noise; `robsim colors test` calls it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robsim._core import Blob, ColorClass, Frame, color_histograms, find_blobs
from robsim.base import report
from robsim.base.checks import Floats, check_int, check_kind, is_int
from robsim.base.text import quoted
from robsim.vision.imaging.images import Pixels, darkened
from robsim.vision.imaging.noise import native_noise

Region = tuple[int, int, int, int]

# Factors of the brightness, factors of the brightness in the shadow, noise levels (%).
_NOISE = (10, 20, 30, 40)
_LEVELS: dict[str, tuple[float, ...]] = {
    "brightness": (0.4, 0.6, 0.8, 1, 1.25, 1.6),
    "shadow": (0.8, 0.6, 0.4),
    "uniform noise": _NOISE,
    "gaussian noise": _NOISE,
    "gaussian noise in shadow": _NOISE,
}
_FACTORS = ("brightness", "shadow")

_MARGINS = tuple(range(-20, 45, 5))

# Largest ratio of the areas of a blob and its region, either way: the region may be drawn around a
# round marker or as a square inside it.
_AREA_FACTOR = 3.0
_MOST_OTHERS = 8  # more blobs than regions, such as the red square


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Detection rates of a colour, 0..1, at each level of one kind of change.

    The name is ``"brightness"``, ``"shadow"``, ``"uniform noise"``, ``"gaussian noise"`` or
    ``"gaussian noise in shadow"``. Levels are factors of brightness, factors in the shadow, or
    noise (%). `widened_rates` are for the colour with the proposed margin.
    """

    name: str
    levels: tuple[float, ...]
    rates: tuple[float, ...]
    widened_rates: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class ColorScore(report.Report):
    """Robustness of a colour's detection: the result of `score_color`.

    Attributes
    ----------
    color : ColorClass
        The scored colour.
    margin : int
        The margin (levels) with the highest detection rate, as in `ColorClass.widened`: 0 = no
        change, negative = narrower.
    sweeps : tuple of Sweep
        Detection rates of the colour, unchanged and widened by `margin`.

    Examples
    --------
    >>> frame = robsim.Simulation(seed=1).step().frame
    >>> [blue] = [color for color in robsim.load_colors() if color.name == "blue"]
    >>> score = robsim.vision.score_color(frame, blue, [(570, 560, 600, 595)])
    >>> [sweep.name for sweep in score.sweeps]
    ['brightness', 'shadow', 'uniform noise', 'gaussian noise', 'gaussian noise in shadow']
    """

    color: ColorClass
    margin: int
    sweeps: tuple[Sweep, ...]

    @property
    def rate(self) -> float:
        """float: mean detection rate over all levels of all sweeps, 0..1."""
        return float(np.mean([rate for sweep in self.sweeps for rate in sweep.rates]))

    @property
    def widened_rate(self) -> float:
        """float: mean detection rate of the colour widened by `margin`, 0..1."""
        return float(np.mean([rate for sweep in self.sweeps for rate in sweep.widened_rates]))

    @property
    def proposed(self) -> ColorClass:
        """ColorClass: the colour widened by `margin`."""
        return self.color.widened(self.margin)

    @property
    def title(self) -> str:
        """The subject of the report: the detection of a colour."""
        return "Detection of a colour in other light and noise"

    @property
    def _change(self) -> str:
        return f"{'widened' if self.margin > 0 else 'narrowed'} by {abs(self.margin)}"

    @property
    def quantities(self) -> tuple[report.Quantity, ...]:
        """Mean detection rates, and the proposed margin."""
        name = report.Quantity("color", "colour", self.color.name)
        rate = report.Quantity("rate", "mean detection rate", self.rate, format=report.percent)
        margin = report.Quantity("margin", "proposed margin", self.margin, "levels")
        if not self.margin:
            return name, rate, margin
        title = f"mean detection rate, {self._change}"
        return (
            name,
            rate,
            margin,
            report.Quantity("widened_rate", title, self.widened_rate, format=report.percent),
        )

    @property
    def tables(self) -> tuple[report.Table, ...]:
        """Detection rate at each level of each sweep."""
        columns = [report.Column("rate", "unchanged", format=_percent)]
        if self.margin:
            columns.append(report.Column("widened_rate", self._change, format=_percent))
        rows = [
            report.Row(_described(sweep.name, level), rates[: len(columns)])
            for sweep in self.sweeps
            for level, *rates in zip(sweep.levels, sweep.rates, sweep.widened_rates, strict=True)
        ]
        return (report.Table(key="levels", columns=columns, rows=rows, row_title="detection rate"),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """A doubt about the regions."""
        if any(rate for sweep in self.sweeps for rate in sweep.rates):
            return ()
        return (
            f"nothing was detected: check that each region has a box of {self.color.name} "
            "pixels, within the ranges of the colour",
        )


def _percent(rate: float) -> str:
    return report.percent(rate, 0)


def _described(sweep: str, level: float) -> str:
    return f"{sweep} x {level:g}" if sweep in _FACTORS else f"{sweep}, {level:g} %"


def score_color(
    image: Frame | Pixels,
    color: ColorClass,
    regions: Sequence[Region],
    *,
    smoothing: int = 7,
    repeats: int = 5,
    seed: int = 0,
) -> ColorScore:
    """Score the robustness of a colour's detection against changed light and noise.

    The colour counts as detected under two conditions. Each region contains the centroid of a blob
    whose area is a third to three times the region's area; no other blob has such an area. The
    image is made darker and brighter. It also gets a shadow with an edge through the first region,
    and camera noise in light and in shadow.

    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB, with little noise.
    color : ColorClass
        The colour.
    regions : sequence of tuples of four ints
        All regions of the colour in the image (px): (left, top, right, bottom), both ends included,
        each around a marker or most of it.
    smoothing : int
        Window width (px), as in `find_blobs`.
    repeats : int
        Number of noisy images at each noise level.
    seed : int
        Seed of the noise, 0 <= seed < 2**64.

    Returns
    -------
    ColorScore
        The detection rates, and the margin with the highest rate.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or a region does not lie within the image.

    Examples
    --------
    >>> frame = robsim.Simulation(seed=1).step().frame
    >>> [blue] = [color for color in robsim.load_colors() if color.name == "blue"]
    >>> robsim.vision.score_color(frame, blue, [(570, 560, 600, 595)]).margin
    5
    """
    pixels = image.image if isinstance(image, Frame) else image
    check_kind("color", color, ColorClass)
    boxes = _checked(pixels, regions)
    if not is_int(smoothing):
        raise TypeError(f"smoothing must be an int, got {quoted(smoothing)}")
    repeats = check_int("repeats", repeats, minimum=1, maximum=10_000)
    seed = check_int("seed", seed, minimum=0, maximum=2**64 - 1)
    classes = _widenings(color)
    rates = {}  # by sweep: array (level, margin)
    for name, levels in _LEVELS.items():
        images = [_varied_images(pixels, boxes[0], name, level, repeats, seed) for level in levels]
        rates[name] = np.array([_rates(shown, classes, boxes, smoothing) for shown in images])
    means = np.concatenate(list(rates.values())).mean(axis=0).round(6)
    margins = list(classes)
    # Of several that are best, the smallest change.
    best = min(range(len(margins)), key=lambda i: (-means[i], abs(margins[i])))
    now = margins.index(0)
    sweeps = [
        Sweep(
            name=name,
            levels=_LEVELS[name],
            rates=tuple(rates[name][:, now].tolist()),
            widened_rates=tuple(rates[name][:, best].tolist()),
        )
        for name in _LEVELS
    ]
    return ColorScore(color=color, margin=margins[best], sweeps=tuple(sweeps))


def _checked(image: Pixels, regions: Sequence[Region]) -> list[Region]:
    if not isinstance(regions, Sequence) or not regions or np.ndim(regions[0]) != 1:
        raise TypeError(
            f"regions must be a list of (left, top, right, bottom), got {quoted(regions)}"
        )
    for region in regions:
        color_histograms(image, region)  # raises for a region outside the image
    return list(regions)


def _widenings(color: ColorClass) -> dict[int, ColorClass]:
    """Return the widened colours by margin, without those whose ranges would be empty."""
    classes = {}
    for margin in _MARGINS:
        try:
            classes[margin] = color.widened(margin)
        except ValueError:
            continue
    return classes


def _varied_images(
    image: Pixels, region: Region, sweep: str, level: float, repeats: int, seed: int
) -> Iterator[Pixels]:
    """Yield the image as changed by one level of a sweep; several times for noise."""
    if sweep == "brightness":
        yield _lit(image, level)
    elif sweep == "shadow":
        shown = image.copy()
        edge = (region[0] + region[2]) // 2
        shown[:, edge:] = _lit(image[:, edge:], level)
        yield shown
    else:
        clean = darkened(image) if sweep.endswith("in shadow") else image
        noise = native_noise(sweep.split()[0], level)
        for i in range(repeats):
            yield noise.add(clean, seed, i)


def _lit(pixels: Pixels, factor: float) -> Pixels:
    """Return the pixels with the brightness multiplied by a factor."""
    values = np.minimum(np.rint(np.arange(256) * factor), 255).astype(np.uint8)
    lit: Pixels = values[pixels]
    return lit


def _rates(
    images: Iterable[Pixels],
    classes: dict[int, ColorClass],
    regions: Sequence[Region],
    smoothing: int,
) -> Floats:
    """Return the fraction of the images in which each of the classes is detected."""
    found = [
        [_is_found(shown, color, regions, smoothing) for color in classes.values()]
        for shown in images
    ]
    rates: Floats = np.mean(found, axis=0)
    return rates


def _is_found(image: Pixels, color: ColorClass, regions: Sequence[Region], smoothing: int) -> bool:
    """Return whether each region has its blob, and no other one could be a marker."""
    areas = [_area(region) for region in regions]
    minimum_area = max(1, round(min(areas) / _AREA_FACTOR))
    blobs = find_blobs(
        image,
        [color],
        minimum_area=minimum_area,
        maximum_count=len(regions) + _MOST_OTHERS,
        smoothing=smoothing,
    )[color.name]
    blobs = [blob for blob in blobs if blob.area <= _AREA_FACTOR * max(areas)]
    return len(blobs) == len(regions) and all(
        any(_fits(blob, region) for blob in blobs) for region in regions
    )


def _fits(blob: Blob, region: Region) -> bool:
    left, top, right, bottom = region
    u, v = blob.centroid
    is_inside = left <= u <= right and top <= v <= bottom
    return is_inside and blob.area <= _AREA_FACTOR * _area(region)


def _area(region: Region) -> int:
    left, top, right, bottom = region
    return (right - left + 1) * (bottom - top + 1)
