"""The result of `instrumental_variables` and `output_error`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats
from robsim.trace import PARAMETER_NAMES

# A parameter is determined if its standard error is below this fraction of the axis's scale.
_MAXIMUM_ERROR = 0.3


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelFit:
    """The parameters of the robot model, fitted to measured poses.

    Attributes
    ----------
    theta : array (3, 5)
        Rows X, Y, P (heading), columns a1, a2, b1, b2, d1. NaN = not determined by the run.
    standard_errors : array (3, 5)
        Standard errors of theta, if the errors of the measured poses are white; inf where theta is
        NaN.
    residual_rms : array (3,)
        Root mean square residual: measured minus fitted pose (px, px, rad).
    iterations : int
        Number of iterations.
    converged : bool
        Whether the iteration converged; if not, theta is that of the last iteration.
    """

    theta: Floats
    standard_errors: Floats
    residual_rms: Floats
    iterations: int
    converged: bool

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Which parameters the recording determines, (3, 5)."""
        return np.asarray(np.isfinite(self.theta))

    def __str__(self) -> str:
        lines = [f"{'':<6}{'Estimate':>14}{'Standard error':>18}"]
        for name, value, error in zip(
            PARAMETER_NAMES, self.theta.flat, self.standard_errors.flat, strict=True
        ):
            texts = (f"{value:.5g}", f"{error:.2g}") if np.isfinite(value) else ("-", "-")
            lines.append(f"{name:<6}{texts[0]:>14}{texts[1]:>18}")
        if not self.determined.all():
            lines.append("-: not determined by the run; excite the robot more, or longer")
        if not self.converged:
            lines.append(f"not converged after {self.iterations} iterations: do not trust it")
        return "\n".join(lines)


def with_undetermined(theta: Floats, standard_errors: Floats) -> tuple[Floats, Floats]:
    """Return theta and its standard errors (3, 5), NaN and inf where theta is not determined.

    The scale of a1 and a2 is 1, that of b1, b2 and d1 is the larger of b1 and b2: the effect of
    1 V.
    """
    gain = np.abs(theta[:, 2:4]).max(axis=1)
    scale = np.column_stack([np.ones((3, 2)), gain, gain, gain])
    # False for NaN, too
    is_determined = standard_errors < _MAXIMUM_ERROR * scale
    # Without a determined b1, b2 or d1, or with an a1 that no robot has, noise has been fitted.
    a1 = theta[:, 0]
    is_determined &= (is_determined[:, 2:].any(axis=1) & (a1 > 0) & (a1 < 2))[:, None]
    return (
        np.where(is_determined, theta, np.nan),
        np.where(is_determined, standard_errors, np.inf),
    )
