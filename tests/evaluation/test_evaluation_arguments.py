"""What is no error, no covariance and no trace is refused in its name by all metrics."""

import numpy as np
import pytest

import robsim
from refusals import MUST, NO_SAMPLE, Refusal, options, refusals
from robsim.evaluation import (
    cramer_rao_bound,
    estimation_errors,
    nees,
    nees_consistency,
    nis,
    nis_consistency,
    parameter_bounds,
    posterior_cramer_rao_bound,
    whiteness,
    wrapped_error,
)

pytestmark = pytest.mark.kernels

ERRORS = np.random.default_rng(3).normal(size=(12, 3))
NO_ROWS = np.ones((0, 3))
ALIKE = np.eye(3)
MATRICES = dict.fromkeys(("F", "H", "Q", "R", "P0"), ALIKE)
NO_TRACE = (None, 1, "x", ERRORS)
NO_SEQUENCE = (None, 1, "x")


@pytest.mark.long
@refusals(
    options(nees, {"error covariance": NO_SAMPLE}, says=MUST, error=ERRORS, covariance=ALIKE),
    options(nis, {"innovation S": NO_SAMPLE}, says=MUST, innovation=ERRORS, S=ALIKE),
    options(nees_consistency, {"error": NO_SAMPLE}, says=MUST, covariance=ALIKE),
    options(nis_consistency, {"innovation": NO_SAMPLE}, says=MUST, S=ALIKE),
    Refusal(whiteness, "innovation", NO_SAMPLE, MUST),
    options(whiteness, {"S": NO_SAMPLE}, ERRORS, says=MUST),
    options(wrapped_error, {"estimate": NO_SAMPLE}, says=MUST, truth=ERRORS),
    options(estimation_errors, {"truth": NO_SAMPLE}, ERRORS, says=MUST),
    options(estimation_errors, {"covariance": NO_SAMPLE}, ERRORS, ERRORS, says=MUST),
    options(cramer_rao_bound, {"phi sigma": NO_SAMPLE}, says=MUST, phi=ERRORS, sigma=1.0),
    options(
        posterior_cramer_rao_bound,
        {" ".join(MATRICES): ("x",)},
        says=MUST,
        seen=[True] * 4,
        **MATRICES,
    ),
    [
        Refusal(
            lambda wrong, name=name: posterior_cramer_rao_bound(
                **MATRICES | {name: wrong}, seen=[True] * 4
            ),
            "",  # the matrix that is named may be one that it is compared with
            (1.0,),
            "must be of shape",
            ValueError,
        )
        for name in MATRICES
    ],
    Refusal(
        lambda wrong: nees(wrong, ALIKE),
        "errors",
        (1.0,),
        "must be rows of n numbers, got 1",
        ValueError,
    ),
)
def test_what_is_no_array_of_numbers(refusal):
    refusal()


@refusals(
    options(nis_consistency, {"S": (np.tile(ALIKE, (5, 1, 1)),)}, np.ones((10, 3)), says=MUST),
    options(nees, {"covariance": (np.tile(ALIKE, (2, 1, 1)),)}, np.ones((2, 10, 3)), says=MUST),
    Refusal(lambda rows: estimation_errors(rows, rows), "estimate", [NO_ROWS], MUST),
)
def test_shapes_that_do_not_fit_together(refusal):
    refusal()


@refusals(
    options(estimation_errors, {"names units": NO_SEQUENCE}, ERRORS, ERRORS, says=MUST),
    options(wrapped_error, {"angles": NO_SEQUENCE}, ERRORS, ERRORS, says=MUST),
    options(parameter_bounds, {"trace": NO_TRACE}, says=MUST, sigma=(1, 1, 1)),
    Refusal(robsim.pose_errors, "traces", NO_TRACE, MUST),
    Refusal(robsim.pose_consistency, "traces", NO_TRACE, MUST),
    Refusal(
        lambda wrong: robsim.pose_errors(robsim.Simulation(seed=1).run(2), of=wrong),
        "of",
        (["estimate"],),
        says=MUST,
    ),
)
def test_what_is_no_sequence_and_no_trace(refusal):
    refusal()


def test_none_in_an_array_is_not_known():
    known = nees([[None, 1, 2], [0, 0, 0]], ALIKE)
    assert np.isnan(known).tolist() == [True, False]
