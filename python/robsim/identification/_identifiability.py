"""How well each parameter is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim._base.checks import Floats, as_float_array, check_int
from robsim.identification._regression import regression_of
from robsim.trace import PARAMETER_NAMES, Trace
from robsim.trace._trace import check_trace

#: Standard deviation of the noise in the equations of x, y (px) and heading (rad) that true poses,
#: which have none, are taken to have.
ASSUMED_SIGMA = (0.1, 0.1, 0.005)

#: Up to this share of the parameter its standard error is that of one known well, or poorly.
WELL, POORLY = 0.05, 0.5

_AXES = ("X", "Y", "P")


@dataclass(frozen=True, kw_only=True, eq=False)
class Identifiability:
    """How well the samples so far determine each parameter.

    Attributes
    ----------
    standard_errors : array (3, 5)
        Standard errors of the parameters, rows X, Y, P (heading), columns a1, a2, b1, b2, d1: the
        Cramér-Rao bound for this noise. inf = not determined at all, NaN = no samples yet.
    relative : array (3, 5)
        The same as a share of the size of the parameter; of d1, which may be 0, as a share of the
        larger one of b1 and b2, what 1 V does.
    noise : array (3,)
        Standard deviation of the noise in the equations of x, y (px) and heading (rad).
    is_assumed : bool
        The noise is `ASSUMED_SIGMA`, since true poses have none; otherwise it was given, or comes
        from the prediction errors.
    """

    standard_errors: Floats
    relative: Floats
    noise: Floats
    is_assumed: bool

    @property
    def verdicts(self) -> NDArray[np.str_]:
        """Array (3, 5): ``"well"``, ``"poorly"`` or ``"not excited"``.

        Well: the standard error is at most 5 % of the parameter. Poorly: at most 50 %.
        """
        # Not a comparison the other way round: NaN is not excited.
        return np.select(
            [self.relative <= WELL, self.relative <= POORLY], ["well", "poorly"], "not excited"
        )

    def names(self, verdict: str) -> list[str]:
        """Return the names of the parameters with a verdict: ``["a1X", ...]``."""
        return [
            name
            for name, given in zip(PARAMETER_NAMES, self.verdicts.ravel(), strict=True)
            if given == verdict
        ]

    def __str__(self) -> str:
        x, y, heading = self.noise
        source = ", assumed" if self.is_assumed else ""
        title = f"Excitation (noise {x:.3g} px, {y:.3g} px, {heading:.3g} rad{source}):"
        return "\n".join([title, *(f"{axis}: {self._line(i)}" for i, axis in enumerate(_AXES))])

    def _line(self, axis: int) -> str:
        names = PARAMETER_NAMES[5 * axis : 5 * axis + 5]
        verdicts = self.verdicts[axis]
        parts = []
        for verdict in ("well", "poorly", "not excited"):
            found = [name for name, given in zip(names, verdicts, strict=True) if given == verdict]
            if len(found) == len(names):
                return verdict
            if found:
                parts.append(f"{verdict} {', '.join(found)}")
        return "; ".join(parts)


def judge(
    standard_errors_unscaled: ArrayLike, theta: ArrayLike, *, noise: ArrayLike | None = None
) -> Identifiability:
    """Return how well parameters are known.

    Parameters
    ----------
    standard_errors_unscaled : array (3, 5)
        Their standard errors in units of the standard deviation of the noise: the square roots of
        the diagonal of the inverse of phi' phi.
    theta : array (3, 5)
        The estimates.
    noise : array (3,), optional
        Standard deviation of the noise in the equations of x, y (px) and heading (rad). Default:
        `ASSUMED_SIGMA`.

    Raises
    ------
    ValueError
        If the noise is not three numbers of at least 0.
    """
    values = np.array(as_float_array("noise", ASSUMED_SIGMA if noise is None else noise))
    if values.shape != (3,) or not (np.isfinite(values) & (values >= 0)).all():
        raise ValueError(f"noise must be three numbers of at least 0 (px, px, rad), got {noise!r}")
    size = np.abs(np.asarray(theta, dtype=np.float64))
    size[:, 4] = size[:, 2:4].max(axis=1)
    errors = values[:, np.newaxis] * np.asarray(standard_errors_unscaled, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = errors / size
    return Identifiability(
        standard_errors=errors, relative=relative, noise=values, is_assumed=noise is None
    )


def identifiability(
    trace: Trace, *, k: int | None = None, noise: ArrayLike | None = None
) -> Identifiability:
    """Return how well the online estimate knew each parameter at a step.

    Parameters
    ----------
    trace : Trace
        A run with ``estimate_parameters=True``.
    k : int, optional
        The step. Default: the last one.
    noise : array (3,), optional
        Standard deviation of the noise in the equations of x, y (px) and heading (rad). Default:
        `ASSUMED_SIGMA` for an estimate from the truth, which has none; otherwise that of the
        prediction errors of the estimate, from the samples up to the step.

    Raises
    ------
    TypeError, ValueError
        If it is no trace, or has no standard errors: an estimator of your own gives none.
    """
    check_trace(trace)
    if not np.isfinite(trace.standard_errors_unscaled).any():
        raise ValueError(
            "the trace has no standard errors: run the simulation with estimate_parameters=True"
        )
    last = int(trace.k[-1])
    step = last if k is None else check_int("k", k, minimum=int(trace.k[0]), maximum=last)
    until = trace[: step - int(trace.k[0]) + 1]
    theta = until.parameters[-1]
    if noise is None and trace.info.identify_from != "truth":
        noise = _prediction_noise(until, theta)
    return judge(until.standard_errors_unscaled[-1], theta, noise=noise)


def _prediction_noise(trace: Trace, theta: Floats) -> Floats:
    """Return the standard deviations of the one-step prediction errors, (3,)."""
    found = regression_of(trace)
    errors = found.y - np.sum(found.phi * theta, axis=2)
    freedom = max(len(errors) - 5, 1)
    deviations: Floats = np.sqrt(np.sum(np.square(errors), axis=0) / freedom)
    return np.nan_to_num(deviations)
