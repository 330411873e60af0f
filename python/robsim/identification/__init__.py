"""Parameters from records: batch estimates, what a record determines, convergence."""

from robsim.identification._batch import BatchEstimate, batch_estimate
from robsim.identification._convergence import (
    ConvergenceReport,
    convergence_time,
    parameter_convergence,
)
from robsim.identification._fits import ModelFit, instrumental_variables, output_error
from robsim.identification._identifiability import Identifiability, identifiability
from robsim.identification._regression import Regression, regression_of

__all__ = [
    "BatchEstimate",
    "ConvergenceReport",
    "Identifiability",
    "ModelFit",
    "Regression",
    "batch_estimate",
    "convergence_time",
    "identifiability",
    "instrumental_variables",
    "output_error",
    "parameter_convergence",
    "regression_of",
]
