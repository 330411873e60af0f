"""The Ljung-Box test of innovations, with the number of lags that it chooses itself."""

import numpy as np

from robsim.evaluation import whiteness
from size_and_power.row import Row, counted

# shape -> promised rate
_SHAPES = ((20, 3), (40, 1), (60, 3), (100, 1), (100, 3), (200, 3), (400, 3), (1000, 3), (5, 12, 3))
_SIZE = (0.04, 0.07)


def rows(seeds: range) -> list[Row]:
    """Return the rates of innovations that are called not white."""
    found = []
    for shape in _SHAPES:
        reports = [whiteness(_noise(seed, shape)) for seed in seeds]
        not_white = [not report.is_white for report in reports]
        found.append(counted("whiteness", "white", _record(shape), "not white", _SIZE, not_white))
    gaps = [not whiteness(_with_gaps(_noise(seed, (200, 3)), seed)).is_white for seed in seeds]
    found.append(
        counted("whiteness", "white", "200 steps of 3, 20 % missing", "not white", _SIZE, gaps)
    )
    for memory, promised in ((0.2, (0.95, 1)), (0.5, (0.99, 1))):
        colored = [not whiteness(_autoregressive(seed, memory)).is_white for seed in seeds]
        hypothesis = f"autoregressive, {memory:g}"
        found.append(
            counted("whiteness", hypothesis, "400 steps of 3", "not white", promised, colored)
        )
    edge = [whiteness(_noise(seed, (400, 3))).at_limit for seed in seeds]
    # 3 x 10 degrees of freedom: from 36.0 to 51.5
    found.append(
        counted("whiteness", "white", "400 steps of 3", "at the limit", (0.15, 0.25), edge)
    )
    return found


def _noise(seed: int, shape: tuple[int, ...]) -> np.ndarray:
    return np.random.default_rng([seed, *shape]).normal(size=shape)


def _with_gaps(values: np.ndarray, seed: int) -> np.ndarray:
    missing = np.random.default_rng([seed, 1]).random(len(values)) < 0.2
    return np.where(missing[:, None], np.nan, values)


def _autoregressive(seed: int, memory: float) -> np.ndarray:
    values = _noise(seed, (400, 3))
    for k in range(1, len(values)):
        values[k] += memory * values[k - 1]
    return values


def _record(shape: tuple[int, ...]) -> str:
    *runs, steps, n = shape
    return f"{runs[0]} runs of {steps} steps of {n}" if runs else f"{steps} steps of {n}"
