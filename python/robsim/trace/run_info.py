"""Facts about a recorded run as a whole: the trace has them as `info`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim.base.checks import check_int, check_mm_per_px, check_text
from robsim.base.text import quoted
from robsim.trace.columns import as_numbers
from robsim.trace.units import px_length

_MOST_HEADINGS = 2**31 - 1
_SEED_KEYS = {"entropy", "spawn_key"}


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """The properties of a whole run in a trace.

    Parameters
    ----------
    dt : float
        Sample time (s).
    theta_true : array_like (3, 5)
        True parameters of the robot model, rows X, Y, P (heading), columns a1, a2, b1, b2, d1.
        NaN = not known, as with recorded frames.
    seed : dict
        ``entropy`` and ``spawn_key`` of the run's `numpy.random.SeedSequence`. Default: an empty
        dict, for an unknown seed, as with recorded frames.
    identify_from : str
        The source of the online estimate: truth, measurement or estimate.
    area : tuple of int
        Width and height of the work area (px).
    boundary : str
        ``"bounce"`` or ``"unlimited"``, or ``"recorded"``: the frames were not simulated.
    robot : str
        Name of the robot definition.
    marker_colors : tuple of str
        Names of the colours of its two markers, right before left, or front before back. Default:
        not known, as in an old file.
    scenario : Scenario or str, optional
        The scenario of the run, or its TOML text; see `robsim.Scenario.of`.
    callbacks : tuple of str
        The slots filled with Python code, which is not part of the scenario.
    changed : tuple of str
        Options changed in the middle of the run; the scenario has the last values.
    mm_per_px : float, optional
        Length of a px of the work area on the floor (mm), from the camera's calibration. Default:
        not known.
    headings : int, optional
        Number of drawn headings of the robot, at whole pixels, in a simulation. Default: any
        heading is possible, as in a camera's view, or the number is not known.
    unit : str
        The unit of all lengths of the trace, and of theta_true: ``"px"``, or, after
        `Trace.in_unit`, ``"mm"``, ``"cm"``, ``"m"``.

    Examples
    --------
    >>> trace = robsim.Simulation(seed=1, area=(800, 600)).run(1)
    >>> trace.info.area, trace.info.dt, trace.info.boundary
    ((800, 600), 0.2, 'bounce')
    """

    dt: float
    theta_true: ArrayLike
    seed: Mapping[str, Any] = field(default_factory=dict)
    identify_from: str = "truth"
    area: tuple[int, int] = (1200, 1200)
    boundary: str = "bounce"
    robot: str = ""
    marker_colors: tuple[str, ...] = ()
    scenario: Any = field(default=None, compare=False, repr=False)
    callbacks: tuple[str, ...] = field(default=(), compare=False, repr=False)
    changed: tuple[str, ...] = field(default=(), compare=False, repr=False)
    mm_per_px: float | None = None
    headings: int | None = None
    unit: str = "px"

    def __post_init__(self) -> None:
        for name in ("identify_from", "boundary", "robot"):
            check_text(name, getattr(self, name))
        is_number = isinstance(self.dt, (int, float)) and not isinstance(self.dt, bool)
        if not is_number or not 0 < self.dt < 1e9:
            raise ValueError(f"dt must be a positive number (s), got {quoted(self.dt)}")
        theta = as_numbers("theta_true", self.theta_true)
        is_unknown = self.boundary == "recorded" and bool(np.isnan(theta).all())
        if theta.shape != (3, 5) or not (np.isfinite(theta).all() or is_unknown):
            raise ValueError(
                f"theta_true must be 3 x 5 finite numbers, got {quoted(self.theta_true)}"
            )
        object.__setattr__(self, "theta_true", tuple(map(tuple, theta.tolist())))
        if not isinstance(self.seed, Mapping) or set(self.seed) not in (_SEED_KEYS, set()):
            raise ValueError(
                f"seed must have entropy and spawn_key, or be empty, got {quoted(self.seed)}"
            )
        area = self.area if isinstance(self.area, tuple) else ()
        if len(area) != 2 or not all(type(size) is int and size > 0 for size in area):
            raise ValueError(f"area must be (width, height), two ints, got {quoted(self.area)}")
        if self.mm_per_px is not None:
            object.__setattr__(self, "mm_per_px", check_mm_per_px(self.mm_per_px))
        if self.headings is not None:
            object.__setattr__(
                self,
                "headings",
                check_int("headings", self.headings, minimum=1, maximum=_MOST_HEADINGS),
            )
        px_length(self.unit, self.mm_per_px)
        for name in ("callbacks", "changed", "marker_colors"):
            texts = getattr(self, name)
            if not isinstance(texts, tuple) or not all(isinstance(text, str) for text in texts):
                raise ValueError(f"{name} must be a tuple of texts, got {quoted(texts)}")
        if not (self.scenario is None or isinstance(self.scenario, str) or self._has_text()):
            raise ValueError(
                f"scenario must be a Scenario or its text, got {quoted(self.scenario)}"
            )

    @property
    def px_length(self) -> float:
        """Length of a px of the work area in `unit`."""
        return px_length(self.unit, self.mm_per_px)

    def _has_text(self) -> bool:
        return callable(getattr(self.scenario, "to_toml", None))

    def as_record(self) -> dict[str, Any]:
        """Return the values as a file stores them."""
        record = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        if self.scenario is not None and self._has_text():
            record["scenario"] = self.scenario.to_toml()
        return record


def is_same_run(one: RunInfo, other: RunInfo) -> bool:
    """Return whether two are equal, with unknown parameters equal to unknown ones."""
    known = np.zeros((3, 5))
    return replace(one, theta_true=known) == replace(other, theta_true=known) and bool(
        np.array_equal(one.theta_true, other.theta_true, equal_nan=True)
    )
