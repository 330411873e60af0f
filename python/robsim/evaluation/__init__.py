"""How good estimates are: errors, consistency, whiteness, bounds."""

from robsim.evaluation._chi_square import chi_square_band
from robsim.evaluation._consistency import (
    ConsistencyReport,
    nees,
    nees_report,
    nis,
    nis_report,
    pose_consistency,
)
from robsim.evaluation._cramer_rao import (
    cramer_rao_bound,
    parameter_bounds,
    pose_bounds,
    posterior_cramer_rao_bound,
)
from robsim.evaluation._errors import ErrorReport, error_report, pose_errors, wrapped_error
from robsim.evaluation._whiteness import WhitenessReport, whiteness_report

__all__ = [
    "ConsistencyReport",
    "ErrorReport",
    "WhitenessReport",
    "chi_square_band",
    "cramer_rao_bound",
    "error_report",
    "nees",
    "nees_report",
    "nis",
    "nis_report",
    "parameter_bounds",
    "pose_bounds",
    "pose_consistency",
    "pose_errors",
    "posterior_cramer_rao_bound",
    "whiteness_report",
    "wrapped_error",
]
