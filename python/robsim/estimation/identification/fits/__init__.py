"""Parameter fits made for measurement noise, which `batch_estimate` calls by name."""

from collections.abc import Callable

from robsim.estimation.identification.fits.instrumental_variables import instrumental_variables
from robsim.estimation.identification.fits.model_fit import ModelFit
from robsim.estimation.identification.fits.output_error import output_error

__all__ = ["METHODS", "ModelFit", "instrumental_variables", "output_error"]

METHODS: dict[str, Callable[..., ModelFit]] = {
    "instrumental_variables": instrumental_variables,
    "output_error": output_error,
}
"""The fits by name; each takes poses (N, 3), u (N, 2) and ``breaks=`` (N,)."""
