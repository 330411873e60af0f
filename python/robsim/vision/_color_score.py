"""Robustness score of a colour."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from robsim._base.checks import Floats, check_int
from robsim._core import Blob, ColorClass, Frame, color_histograms, find_blobs
from robsim.imaging._images import Pixels
from robsim.imaging._noise import native_noise
from robsim.imaging._shading import darkened

Region = tuple[int, int, int, int]

# Factors of the brightness, of that in the shadow; levels of the noise (%).
_NOISE = (10, 20, 30, 40)
_LEVELS: dict[str, tuple[float, ...]] = {
    "brightness": (0.4, 0.6, 0.8, 1, 1.25, 1.6),
    "shadow": (0.8, 0.6, 0.4),
    "uniform noise": _NOISE,
    "gaussian noise": _NOISE,
    "gaussian noise in shadow": _NOISE,
}
_UNITS = {"brightness": "factor", "shadow": "factor"}

_MARGINS = tuple(range(-20, 45, 5))

# A blob has the right area if it lies within this factor of the region's area. So the region may
# be drawn around a round marker or a square within it.
_AREA_FACTOR = 3.0


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """How often a colour was found under one kind of change.

    Attributes
    ----------
    name : str
        What was changed: ``"brightness"``, ``"shadow"``, ``"uniform noise"``,
        ``"gaussian noise"`` or ``"gaussian noise in shadow"``.
    levels : tuple of float
        Factors of the brightness, factors of that in the shadow, or levels of the noise (%).
    rates : tuple of float
        How often the colour was found at each level, 0..1.
    widened_rates : tuple of float
        The same for the colour with the proposed widening.
    """

    name: str
    levels: tuple[float, ...]
    rates: tuple[float, ...]
    widened_rates: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class ColorScore:
    """How robustly a colour is found: what `score_color` found.

    Attributes
    ----------
    color : ColorClass
        The colour that was scored.
    margin : int
        The widening (levels) with the highest rate, as in `ColorClass.widened`: 0 = none is
        better, negative = narrower.
    sweeps : tuple of Sweep
        How often it was found, as it is and so widened.
    """

    color: ColorClass
    margin: int
    sweeps: tuple[Sweep, ...]

    @property
    def rate(self) -> float:
        """float: mean over all levels of all sweeps, 0..1."""
        return float(np.mean([rate for sweep in self.sweeps for rate in sweep.rates]))

    @property
    def widened_rate(self) -> float:
        """float: the same for the colour so widened."""
        return float(np.mean([rate for sweep in self.sweeps for rate in sweep.widened_rates]))

    @property
    def proposed(self) -> ColorClass:
        """ColorClass: the colour so widened."""
        return self.color.widened(self.margin)

    def __str__(self) -> str:
        how = f"{'widened' if self.margin > 0 else 'narrowed'} by {abs(self.margin)}"
        lines = [f"{self.color.name}, found in % of the images:"]
        for sweep in self.sweeps:
            lines.append(_row(f"  {sweep.name} ({_UNITS.get(sweep.name, '%')})", sweep.levels))
            lines.append(_row("    as it is", _percents(sweep.rates)))
            if self.margin:
                lines.append(_row(f"    {how}", _percents(sweep.widened_rates)))
        mean = f"mean: {100 * self.rate:.1f} %"
        if self.margin:
            mean += f", {how}: {100 * self.widened_rate:.1f} %"
        return "\n".join([*lines, mean])

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers: color, rate, margin, widened_rate, sweeps by their names."""
        sweeps = [asdict(sweep) for sweep in self.sweeps]
        return {
            "color": self.color.name,
            "rate": self.rate,
            "margin": self.margin,
            "widened_rate": self.widened_rate,
            "sweeps": {sweep.pop("name"): sweep for sweep in sweeps},
        }


def _row(title: str, numbers: Iterable[float]) -> str:
    return f"{title:<32}" + "".join(f"{number:6g}" for number in numbers)


def _percents(rates: Iterable[float]) -> list[int]:
    return [round(100 * rate) for rate in rates]


def score_color(
    image: Frame | Pixels,
    color: ColorClass,
    regions: Sequence[Region],
    *,
    smoothing: int = 7,
    repeats: int = 5,
    seed: int = 0,
) -> ColorScore:
    """Score how robustly a colour is found in an image under other light and in noise.

    It is found if each region has a blob of it, with its centroid there and a third to three times
    the region's area, and there is no other blob so large. The image is made darker and
    brighter, gets a shadow whose edge runs through the first region, and gets noise of the camera,
    in the light and in the shadow.

    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB, with little noise of its own.
    color : ColorClass
        The colour.
    regions : sequence of tuples of four ints
        Where the colour is, all of it: (left, top, right, bottom), both ends included, around each
        marker, or most of it.
    smoothing : int
        Window against noise (px), as in `find_blobs`.
    repeats : int
        How many noisy images of a level are looked at.
    seed : int
        Of the noise.

    Returns
    -------
    ColorScore
        The rates, and the widening that gives the highest.

    Raises
    ------
    TypeError, ValueError
        For values of another kind, and for a region that does not lie within the image.
    """
    pixels = image.image if isinstance(image, Frame) else image
    if not isinstance(color, ColorClass):
        raise TypeError(f"color must be a ColorClass, got {color!r}")
    boxes = _checked(pixels, regions)
    repeats = check_int("repeats", repeats, minimum=1, maximum=10_000)
    seed = check_int("seed", seed, minimum=0, maximum=2**64 - 1)
    classes = _widenings(color)
    rates = {}  # of the sweep: (level, widening)
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
        raise TypeError(f"regions must be a list of (left, top, right, bottom), got {regions!r}")
    for region in regions:
        color_histograms(image, region)  # says what is wrong with it
    return list(regions)


def _widenings(color: ColorClass) -> dict[int, ColorClass]:
    """Return the colour by its widening; those that leave nothing of a range are left out."""
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
    """Yield the image as it looks at a level of a sweep."""
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
    """Return the pixels in so much of the light."""
    values = np.minimum(np.rint(np.arange(256) * factor), 255).astype(np.uint8)
    lit: Pixels = values[pixels]
    return lit


def _rates(
    images: Iterable[Pixels],
    classes: dict[int, ColorClass],
    regions: Sequence[Region],
    smoothing: int,
) -> Floats:
    """Return in what share of the images each of the classes is found."""
    found = [
        [_is_found(shown, color, regions, smoothing) for color in classes.values()]
        for shown in images
    ]
    rates: Floats = np.mean(found, axis=0)
    return rates


def _is_found(image: Pixels, color: ColorClass, regions: Sequence[Region], smoothing: int) -> bool:
    """Return whether each region has its blob, and there is no other."""
    least = max(1, round(min(_area(region) for region in regions) / _AREA_FACTOR))
    blobs = find_blobs(
        image, [color], minimum_area=least, maximum_count=len(regions) + 1, smoothing=smoothing
    )[color.name]
    return len(blobs) == len(regions) and all(
        any(_fits(blob, region) for blob in blobs) for region in regions
    )


def _fits(blob: Blob, region: Region) -> bool:
    left, top, right, bottom = region
    u, v = blob.centroid
    is_there = left <= u <= right and top <= v <= bottom
    return is_there and blob.area <= _AREA_FACTOR * _area(region)


def _area(region: Region) -> int:
    left, top, right, bottom = region
    return (right - left + 1) * (bottom - top + 1)
