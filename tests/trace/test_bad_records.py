"""What users get wrong about records, errors and covariances: a sentence names the argument."""

import numpy as np
import pytest

import robsim

pytestmark = pytest.mark.kernels

ERRORS = np.random.default_rng(3).normal(size=(12, 3))
RAGGED = [[1, 2], [3]]
ALIKE = np.eye(3)


def refuses(name, call, *arguments, **options):
    with pytest.raises((TypeError, ValueError), match=rf"\b{name} must ") as caught:
        call(*arguments, **options)
    assert "got" in str(caught.value)


@pytest.mark.parametrize("wrong", ["x", RAGGED, np.ones((12, 3), complex), [["a"] * 3] * 12])
def test_what_is_no_array_of_numbers_is_refused(wrong):
    refuses("error", robsim.evaluation.nees, wrong, ALIKE)
    refuses("covariance", robsim.evaluation.nees, ERRORS, wrong)
    refuses("innovation", robsim.evaluation.nis, wrong, ALIKE)
    refuses("S", robsim.evaluation.nis, ERRORS, wrong)
    refuses("error", robsim.evaluation.nees_consistency, wrong, ALIKE)
    refuses("innovation", robsim.evaluation.nis_consistency, wrong, ALIKE)
    refuses("innovation", robsim.evaluation.whiteness, wrong)
    refuses("S", robsim.evaluation.whiteness, ERRORS, wrong)
    refuses("estimate", robsim.evaluation.wrapped_error, wrong, ERRORS)
    refuses("truth", robsim.evaluation.estimation_errors, ERRORS, wrong)
    refuses("covariance", robsim.evaluation.estimation_errors, ERRORS, ERRORS, covariance=wrong)
    refuses("phi", robsim.evaluation.cramer_rao_bound, wrong, 1.0)
    refuses("sigma", robsim.evaluation.cramer_rao_bound, ERRORS, wrong)
    refuses("estimate", robsim.identification.convergence_time, wrong, 1.0, 1.0)


@pytest.mark.parametrize("name", ["F", "H", "Q", "R", "P0"])
def test_so_is_a_matrix_of_the_bound(name):
    matrices = dict.fromkeys(("F", "H", "Q", "R", "P0"), ALIKE)
    call = robsim.evaluation.posterior_cramer_rao_bound
    refuses(name, lambda: call(**{**matrices, name: "x"}, seen=[True] * 4))
    with pytest.raises(ValueError, match="must be of shape"):
        call(**{**matrices, name: 1.0}, seen=[True] * 4)


def test_a_single_number_is_no_row():
    with pytest.raises(ValueError, match="must be rows of n numbers, got 1"):
        robsim.evaluation.nees(1.0, ALIKE)


def test_shapes_that_do_not_fit_together():
    refuses("S", robsim.evaluation.nis_consistency, np.ones((10, 3)), np.tile(ALIKE, (5, 1, 1)))
    refuses("covariance", robsim.evaluation.nees, np.ones((2, 10, 3)), np.tile(ALIKE, (2, 1, 1)))
    refuses("estimate", robsim.evaluation.estimation_errors, np.ones((0, 3)), np.ones((0, 3)))


def test_none_in_an_array_is_not_known():
    assert np.isnan(robsim.evaluation.nees([[None, 1, 2], [0, 0, 0]], ALIKE)).tolist() == [
        True,
        False,
    ]


@pytest.mark.parametrize("wrong", [None, 1, "x"])
def test_names_units_and_angles_are_sequences(wrong):
    refuses("names", robsim.evaluation.estimation_errors, ERRORS, ERRORS, names=wrong)
    refuses("units", robsim.evaluation.estimation_errors, ERRORS, ERRORS, units=wrong)
    refuses("angles", robsim.evaluation.wrapped_error, ERRORS, ERRORS, angles=wrong)


@pytest.mark.parametrize("wrong", [None, 1, "x", ERRORS])
def test_what_is_no_trace_is_refused(wrong):
    refuses("trace", robsim.batch_estimate, wrong)
    refuses("trace", robsim.identifiability, wrong)
    refuses("trace", robsim.identification.regression_of, wrong)
    refuses("trace", robsim.identification.parameter_convergence, wrong)
    refuses("trace", robsim.evaluation.parameter_bounds, wrong, sigma=(1, 1, 1))
    refuses("traces", robsim.pose_errors, wrong)
    refuses("traces", robsim.pose_consistency, wrong)


def test_names_of_a_batch_estimate_are_texts():
    trace = robsim.Simulation(seed=1, resolution=(60, 60)).run(12)
    for name in ("method", "select", "identify_from"):
        for wrong in (["x"], 3):
            refuses(name, robsim.batch_estimate, trace, **{name: wrong})
    refuses("of", robsim.pose_errors, trace, of=["estimate"])


@pytest.mark.long
@pytest.mark.parametrize("wrong", ["a", 2.5, [3], True, 5, -1, 10**30])
def test_the_step_of_an_excitation_is_one_of_the_trace(wrong):
    trace = robsim.Simulation(estimate_parameters=True, seed=1, resolution=(60, 60)).run(5)
    refuses("k", robsim.identifiability, trace, k=wrong)
    refuses("noise", robsim.identifiability, trace, noise="a")


@pytest.mark.parametrize(
    "fit", [robsim.identification.instrumental_variables, robsim.identification.output_error]
)
def test_poses_and_inputs_beyond_all_sense_are_refused(fit):
    poses, u = np.cumsum(np.ones((30, 3)), axis=0), np.ones((30, 2))
    refuses("poses", fit, poses * 1e120, u)
    refuses("u", fit, poses, u * 1e150)
