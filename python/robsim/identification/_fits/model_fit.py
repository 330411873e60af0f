"""The result of a fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats
from robsim.trace import PARAMETER_NAMES

# A parameter is given if its standard error is below this share of the axis's scale.
_MAXIMUM_ERROR = 0.3


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelFit:
    """The parameters of the robot model, fitted to measured poses.

    Attributes
    ----------
    theta : array (3, 5)
        Rows X, Y, P (heading), columns a1, a2, b1, b2, d1. NaN = the record does not determine it.
    standard_errors : array (3, 5)
        Their standard errors, if the errors of the measured poses are white; inf where theta is
        NaN.
    residual_rms : array (3,)
        Root mean square of what the fit leaves over: measured minus fitted pose (px, px, rad).
    iterations : int
        Iterations that it took.
    converged : bool
        Whether it came to an end; if not, theta is only as far as it got.
    """

    theta: Floats
    standard_errors: Floats
    residual_rms: Floats
    iterations: int
    converged: bool

    @property
    def determined(self) -> NDArray[np.bool_]:
        """The parameters (3, 5) that the record determines."""
        return np.asarray(np.isfinite(self.theta))

    def __str__(self) -> str:
        lines = [f"{'':<6}{'Estimate':>14}{'Standard error':>18}"]
        for name, value, error in zip(
            PARAMETER_NAMES, self.theta.flat, self.standard_errors.flat, strict=True
        ):
            texts = (f"{value:.5g}", f"{error:.2g}") if np.isfinite(value) else ("-", "-")
            lines.append(f"{name:<6}{texts[0]:>14}{texts[1]:>18}")
        if not self.determined.all():
            lines.append("-: not determined by the record; excite the robot more, or longer")
        if not self.converged:
            lines.append(f"not converged after {self.iterations} iterations: do not trust it")
        return "\n".join(lines)


def given(theta: Floats, standard_errors: Floats) -> tuple[Floats, Floats]:
    """Return theta and its standard errors (3, 5), NaN and inf where the record says too little.

    The scale of a1 and a2 is 1, that of b1, b2 and d1 the larger one of b1 and b2: what 1 V does.
    """
    gain = np.abs(theta[:, 2:4]).max(axis=1)
    scale = np.column_stack([np.ones((3, 2)), gain, gain, gain])
    # NaN is not enough either.
    enough = standard_errors < _MAXIMUM_ERROR * scale
    # Without a force that shows, or with an a1 that no robot has, noise has been fitted.
    a1 = theta[:, 0]
    enough &= (enough[:, 2:].any(axis=1) & (a1 > 0) & (a1 < 2))[:, None]
    return np.where(enough, theta, np.nan), np.where(enough, standard_errors, np.inf)
