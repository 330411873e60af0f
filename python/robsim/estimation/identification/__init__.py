"""Parameter estimation: recursive and batch estimates, identifiability and convergence."""

from robsim._core import LeastSquaresFit, RecursiveLeastSquares, Sample, least_squares, regression
from robsim.estimation.identification.batch import BatchEstimate, batch_estimate
from robsim.estimation.identification.convergence import (
    ConvergenceReport,
    convergence_time,
    parameter_convergence,
)
from robsim.estimation.identification.determined import Identifiability, identifiability
from robsim.estimation.identification.fits import ModelFit, instrumental_variables, output_error
from robsim.estimation.identification.regressions import Regression, regression_of

__all__ = [
    "BatchEstimate",
    "ConvergenceReport",
    "Identifiability",
    "LeastSquaresFit",
    "ModelFit",
    "RecursiveLeastSquares",
    "Regression",
    "Sample",
    "batch_estimate",
    "convergence_time",
    "identifiability",
    "instrumental_variables",
    "least_squares",
    "output_error",
    "parameter_convergence",
    "regression",
    "regression_of",
]
