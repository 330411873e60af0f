"""The result of `instrumental_variables` and `output_error`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.report import Column, Quantity, Report, Table
from robsim.estimation.identification._parameter_table import noise_remarks, parameter_table

# A parameter is determined if its standard error is below this fraction of the axis's scale.
_MAXIMUM_ERROR = 0.3


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelFit(Report):
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
    input_delay, input_delay_error : float
        How late the inputs act (steps), and the standard error; 0 if it was given.
    """

    theta: Floats
    standard_errors: Floats
    residual_rms: Floats
    iterations: int
    converged: bool
    input_delay: float = 0.0
    input_delay_error: float = 0.0

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Which parameters the recording determines, (3, 5)."""
        return np.asarray(np.isfinite(self.theta))

    @property
    def title(self) -> str:
        """What was fitted."""
        return "Parameters fitted to measured poses"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The delay of the inputs, if there is one."""
        return delay_quantities(self.input_delay, self.input_delay_error)

    @property
    def tables(self) -> tuple[Table, ...]:
        """Estimate and standard error of each parameter."""
        errors = np.where(self.determined, self.standard_errors, np.nan)
        columns = {
            Column("estimate", "estimate", format=".5g"): self.theta,
            Column("standard_error", "standard error", format=".2g"): errors,
        }
        return (parameter_table(columns),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What limits the fit."""
        remarks = []
        if not self.determined.all():
            remarks.append(
                "parameters without a value are not determined by the run; excite the robot more, "
                "or longer"
            )
        if not self.converged:
            remarks.append(f"not converged after {self.iterations} iterations: do not trust it")
        return (*remarks, *noise_remarks("measurement"))


def delay_quantities(delay: float, error: float) -> tuple[Quantity, ...]:
    """Return what a report says of a delay of the inputs (steps); nothing without one."""
    quantities = (
        Quantity("input_delay", "input delay", delay, "steps", ".4g"),
        Quantity("input_delay_error", "its standard error", error, "steps", ".2g"),
    )
    return quantities if error else quantities[: bool(delay)]


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
