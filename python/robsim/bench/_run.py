"""`run_bench`: all benchmark cases in one run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from robsim._base.checks import check_int
from robsim._base.text import quoted
from robsim._core import cpu_path
from robsim.bench._cases import BenchResult, Call, Case, timed
from robsim.bench._estimation import (
    RECURSIVE_SAMPLES,
    batch_calls,
    loops,
    recursive_calls,
    steps_per_second,
)
from robsim.bench._noise import gaussian_calls, uniform_calls
from robsim.bench._noisy_step import step_calls
from robsim.bench._render import render_calls
from robsim.bench._set_up import STEPS as STEPS_OF_A_RUN
from robsim.bench._set_up import set_up_calls
from robsim.bench._vision import detect_calls, scene
from robsim.imaging._opencv import load_opencv
from robsim.simulation._simulation import Simulation

SIZES = (1200, 480)
FRAMES = 300
STEPS = 200_000
LOOP_ROUNDS = 5


def run_bench(
    *, rounds: int = 25, sizes: tuple[int, ...] = SIZES, frames: int = FRAMES, steps: int = STEPS
) -> BenchResult:
    """Time robsim and the alternatives, OpenCV and numpy, on the same frames and data.

    Parameters
    ----------
    rounds : int
        Number of timed rounds of each case; the result is the median.
    sizes : tuple of int
        Widths and heights of the frames (px).
    frames, steps : int
        Number of steps of the runs with and without tracking.

    Returns
    -------
    BenchResult
        The times and rates; print it.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    RuntimeError
        If the blobs, the images or the estimates of both sides differ.
    TypeError, ValueError
        If an argument has the wrong type or is out of range.
    """
    check_int("rounds", rounds, minimum=1, maximum=10**6)
    check_int("frames", frames, minimum=1, maximum=10**6)
    check_int("steps", steps, minimum=1, maximum=10**9)
    if not isinstance(sizes, (tuple, list)):
        raise TypeError(f"sizes must be a tuple of ints (px), got {quoted(sizes)}")
    for size in sizes:
        check_int("sizes", size, minimum=16, maximum=16384)
    cv2 = load_opencv("the comparison")
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        cases = [case for size in sizes for case in _frame_cases(cv2, size, rounds)]
    finally:
        cv2.setNumThreads(threads)
    cases += _estimation_cases(rounds) + _set_up_cases(rounds)
    rates = {**_tracking_rates(frames), **_loop_rates(steps)}
    return BenchResult(cpu_path=cpu_path(), cases=tuple(cases), rates=rates)


def _frame_cases(cv2: Any, size: int, rounds: int) -> Iterator[Case]:
    clean = scene("none", size, smoothing=1)
    words = clean.frame.image.copy().reshape(-1).view(np.uint64)
    calls: dict[str, Call] = {**detect_calls(cv2, clean), "memory_read": words.max}
    yield timed(f"detect_clean_{size}", calls, rounds)
    for kind in ("uniform", "gaussian"):
        noisy = scene(kind, size)
        yield timed(f"detect_{kind}_{size}", detect_calls(cv2, noisy), rounds)
        raw = scene(kind, size, smoothing=1)
        yield timed(f"detect_{kind}_raw_{size}", detect_calls(cv2, raw), max(1, rounds // 5))
    pixels = clean.frame.image.copy()
    yield timed(f"noise_uniform_{size}", uniform_calls(cv2, pixels), rounds)
    yield timed(f"noise_gaussian_{size}", gaussian_calls(cv2, pixels), rounds)
    yield timed(f"render_{size}", render_calls(cv2, size), 10 * rounds)
    yield timed(f"step_gaussian_{size}", step_calls(cv2, noisy), rounds)


def _estimation_cases(rounds: int) -> list[Case]:
    recursive = timed(
        "recursive_update", recursive_calls(), rounds, unit="ns", repeats=RECURSIVE_SAMPLES
    )
    return [recursive, timed("batch_10000x5", batch_calls(), 4 * rounds, unit="us")]


def _set_up_cases(rounds: int) -> list[Case]:
    return [
        timed(f"{name}_run_{STEPS_OF_A_RUN}", set_up_calls(is_new=is_new), 10 * rounds, unit="us")
        for name, is_new in (("new", True), ("reset", False))
    ]


def _tracking_rates(frames: int) -> dict[str, float]:
    """Return the rates with tracking, without noise, with 36 drawn headings."""
    options: dict[str, Any] = {"robot": "lab", "measure": True, "seed": 1}
    simulations = {
        "tracking_smoothing_off": Simulation(smoothing=1, **options),
        "tracking_default": Simulation(**options),
    }
    return {
        name: steps_per_second(simulation, steps=frames, rounds=LOOP_ROUNDS)
        for name, simulation in simulations.items()
    }


def _loop_rates(steps: int) -> dict[str, float]:
    """Return the rates without tracking."""
    return {
        f"loop_{name}": steps_per_second(simulation, steps=steps, rounds=LOOP_ROUNDS)
        for name, simulation in loops().items()
    }
