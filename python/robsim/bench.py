"""Speed against what else there is."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim._core import Frame, VisualNoise, cpu_path, find_blobs
from robsim.colors import load_colors
from robsim.opencv import load_opencv
from robsim.pictures import Pixels
from robsim.simulation import Simulation

SIZES = (1200, 480)
NOISE_PERCENT = 40.0
LOOP_STEPS = 300
MINIMUM_AREA = 12  # px, of a blob

Call = Callable[[], Any]


@dataclass(frozen=True, kw_only=True)
class Case:
    """What was timed: medians of one run, side by side (ms).

    Attributes
    ----------
    name : str
        What was done, with the size of the frame.
    ours_ms : float
        Time that robsim needs.
    others_ms : dict of str to float
        Time that others need for the same.
    """

    name: str
    ours_ms: float
    others_ms: dict[str, float]

    def to_dict(self) -> dict[str, float]:
        """Return the times, and for each other one how many times as long it takes."""
        numbers = {"ours_ms": self.ours_ms}
        for other, milliseconds in self.others_ms.items():
            numbers[f"{other}_ms"] = milliseconds
            if other != "memory_read":
                name = "ratio" if other == "opencv" else f"{other}_ratio"
                numbers[name] = milliseconds / self.ours_ms
        return numbers


@dataclass(frozen=True, kw_only=True)
class BenchResult:
    """All that was timed.

    Attributes
    ----------
    cpu_path : str
        The instructions that the hot loops used.
    cases : tuple of Case
        The cases.
    frames_per_second : float
        Of `Simulation.run` with tracking, without noise.
    """

    cpu_path: str
    cases: tuple[Case, ...]
    frames_per_second: float

    def to_dict(self) -> dict[str, Any]:
        """Return name -> numbers."""
        return {
            "cpu_path": self.cpu_path,
            "frames_per_second": self.frames_per_second,
            **{case.name: case.to_dict() for case in self.cases},
        }

    def __str__(self) -> str:
        lines = [
            f"one thread, path {self.cpu_path}, medians in ms; in brackets how many times ours",
            f"{'':24}{'robsim':>9}{'OpenCV':>18}{'numpy':>18}{'memory read':>18}",
        ]
        for case in self.cases:
            line = f"{case.name:24}{case.ours_ms:9.3f}"
            for other in ("opencv", "numpy", "memory_read"):
                value = case.others_ms.get(other)
                text = "" if value is None else f"{value:.3f} ({value / case.ours_ms:.2f} x)"
                line += f"{text:>18}"
            lines.append(line)
        lines.append(
            f"tracking loop: {self.frames_per_second:.0f} frames of 1200 x 1200 per second"
        )
        return "\n".join(lines)


def run_bench(*, rounds: int = 25) -> BenchResult:
    """Time robsim and what a user would take instead, on the same frames.

    Parameters
    ----------
    rounds : int
        How often each is timed; the median counts.

    Returns
    -------
    BenchResult
        The times.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    RuntimeError
        If both sides do not find the same blobs.
    """
    cv2 = load_opencv("the comparison")
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        cases = [
            case(cv2, size, rounds) for size in SIZES for case in (_detect, _gaussian, _uniform)
        ]
    finally:
        cv2.setNumThreads(threads)
    return BenchResult(cpu_path=cpu_path(), cases=tuple(cases), frames_per_second=_loop())


def _timed(calls: dict[str, Call], rounds: int) -> dict[str, float]:
    """Return the median time of each call (ms), taken in turns."""
    times: dict[str, list[float]] = {name: [] for name in calls}
    for round_ in range(rounds + 2):  # two to warm up
        for name, call in calls.items():
            start = time.perf_counter()
            call()
            if round_ >= 2:
                times[name].append(1e3 * (time.perf_counter() - start))
    return {name: statistics.median(values) for name, values in times.items()}


def _case(name: str, calls: dict[str, Call], rounds: int) -> Case:
    times = _timed(calls, rounds)
    return Case(name=name, ours_ms=times.pop("ours"), others_ms=times)


def _frame(size: int) -> Frame:
    return Simulation(robot="lab", camera=(size, size), start=(450, 700, 0.5), seed=1).frame


def _detect(cv2: Any, size: int, rounds: int) -> Case:
    frame, colors = _frame(size), load_colors()
    pixels = frame.image.copy()
    limits = [
        # Y, Cr, Cb: OpenCV's order
        (np.array([c.y[0], c.v[0], c.u[0]]), np.array([c.y[1], c.v[1], c.u[1]]))
        for c in colors
    ]

    def opencv() -> list[list[tuple[float, float]]]:
        converted = cv2.cvtColor(pixels, cv2.COLOR_RGB2YCrCb)
        found = []
        for lower, upper in limits:
            mask = cv2.inRange(converted, lower, upper)
            outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            moments = [cv2.moments(outline) for outline in outlines]
            found.append(
                [
                    (m["m10"] / m["m00"], m["m01"] / m["m00"])
                    for m in moments
                    if m["m00"] >= MINIMUM_AREA
                ]
            )
        return found

    _check_same(find_blobs(frame, colors, minimum_area=MINIMUM_AREA), opencv(), colors)
    words = pixels.reshape(-1).view(np.uint64)
    calls: dict[str, Call] = {
        "ours": lambda: find_blobs(frame, colors, minimum_area=MINIMUM_AREA),
        "opencv": opencv,
        "memory_read": words.max,
    }
    return _case(f"detect_clean_{size}", calls, rounds)


def _check_same(ours: Any, theirs: list[list[tuple[float, float]]], colors: Any) -> None:
    for color, found in zip(colors, theirs, strict=True):
        mine = sorted(blob.centroid.tolist() for blob in ours[color.name])
        others = sorted(map(list, found))
        if len(mine) != len(others) or not np.allclose(mine, others, atol=1.0):
            raise RuntimeError(
                f"robsim and OpenCV must find the same {color.name} blobs, got {mine} and {others}"
            )


def _noise_case(kind: str, clean: Pixels, rounds: int, *, opencv: Call, numpy: Call) -> Case:
    noise = VisualNoise(kind, NOISE_PERCENT)
    calls = {"ours": lambda: noise.add(clean, 1, 1), "opencv": opencv, "numpy": numpy}
    return _case(f"noise_{kind}_{clean.shape[1]}", calls, rounds)


def _gaussian(cv2: Any, size: int, rounds: int) -> Case:
    clean = _frame(size).image.copy()
    noise, noisy = np.empty(clean.shape, np.int16), np.empty_like(clean)
    random, scale = np.random.default_rng(1), 2.55 * NOISE_PERCENT

    def opencv() -> None:
        cv2.randn(noise, 0, scale)
        cv2.add(clean, noise, noisy, dtype=cv2.CV_8U)

    def numpy() -> Pixels:
        values = random.standard_normal(clean.shape, dtype=np.float32)
        values *= np.float32(scale)
        values += clean
        return np.clip(np.rint(values, out=values), 0, 255, out=values).astype(np.uint8)

    return _noise_case("gaussian", clean, rounds, opencv=opencv, numpy=numpy)


def _uniform(cv2: Any, size: int, rounds: int) -> Case:
    clean = _frame(size).image.copy()
    noise, noisy = np.empty(clean.shape, np.int16), np.empty_like(clean)
    random, reach = np.random.default_rng(1), round(2.55 * NOISE_PERCENT)

    def opencv() -> None:
        cv2.randu(noise, -reach, reach + 1)
        cv2.add(clean, noise, noisy, dtype=cv2.CV_8U)

    def numpy() -> Pixels:
        values = random.integers(-reach, reach, clean.shape, dtype=np.int16, endpoint=True)
        values += clean
        return np.clip(values, 0, 255, out=values).astype(np.uint8)

    return _noise_case("uniform", clean, rounds, opencv=opencv, numpy=numpy)


def _loop() -> float:
    """Return the frames per second of the loop with tracking, in its second run."""
    simulation = Simulation(robot="lab", measure=True, seed=1)
    simulation.run(LOOP_STEPS)
    simulation.reset()
    start = time.perf_counter()
    simulation.run(LOOP_STEPS)
    return LOOP_STEPS / (time.perf_counter() - start)
