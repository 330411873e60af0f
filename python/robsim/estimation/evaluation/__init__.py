"""The quality of estimates: errors, consistency (NEES, NIS), whiteness, and their lower bounds.

A result is a `Report`; a custom metric is a subclass of `Report`.
"""

from robsim.base.report import Column, Quantity, Report, Row, Table, percent
from robsim.estimation.evaluation._measurement_bound import MeasurementBound, measurement_bound
from robsim.estimation.evaluation._whiteness import WhitenessReport, whiteness
from robsim.estimation.evaluation.chi_square import chi_square_band
from robsim.estimation.evaluation.consistency import (
    ConsistencyReport,
    nees,
    nees_consistency,
    nis,
    nis_consistency,
    pose_consistency,
)
from robsim.estimation.evaluation.cramer_rao import (
    cramer_rao_bound,
    parameter_bounds,
    pose_bounds,
    posterior_cramer_rao_bound,
)
from robsim.estimation.evaluation.errors import (
    ErrorReport,
    estimation_errors,
    pose_errors,
    wrapped_error,
)

__all__ = [
    "Column",
    "ConsistencyReport",
    "ErrorReport",
    "MeasurementBound",
    "Quantity",
    "Report",
    "Row",
    "Table",
    "WhitenessReport",
    "chi_square_band",
    "cramer_rao_bound",
    "estimation_errors",
    "measurement_bound",
    "nees",
    "nees_consistency",
    "nis",
    "nis_consistency",
    "parameter_bounds",
    "percent",
    "pose_bounds",
    "pose_consistency",
    "pose_errors",
    "posterior_cramer_rao_bound",
    "whiteness",
    "wrapped_error",
]
