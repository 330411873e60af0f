"""What is no record, no trace and no step of one is refused in its name by all fits."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import robsim
from refusals import INF, MUST, NAN, NO_SAMPLE, Refusal, options, refusals, refuses
from robsim import identification
from robsim.identification import regression

pytestmark = pytest.mark.kernels

POSES, INPUTS = np.zeros((4, 3)), np.zeros((4, 2))
NO_POSES = (
    *(None, "abc", 5, [], POSES[0], POSES[:, :2], POSES * NAN),
    *(POSES[None], [["a"] * 3] * 4, POSES.T),
)
NO_INPUTS = (
    *(None, "abc", 5, [], INPUTS[:3], INPUTS[0], INPUTS.T),
    *(np.full((4, 2), INF), INPUTS[None], [["a"] * 2] * 4),
)
FAR, DRIVEN = np.cumsum(np.ones((30, 3)), axis=0), np.ones((30, 2))
FITS = (identification.instrumental_variables, identification.output_error)
TRACE_TAKERS = (
    *(robsim.batch_estimate, robsim.identifiability),
    *(identification.regression_of, identification.parameter_convergence),
)


@cache
def driven(steps, **options):
    return robsim.Simulation(**options, seed=1, resolution=(60, 60)).run(steps)


@refusals(
    Refusal(lambda value: regression(value, INPUTS), "poses", NO_POSES),
    Refusal(lambda value: regression(POSES, value), "u", NO_INPUTS),
    options(
        identification.convergence_time,
        {"estimate": NO_SAMPLE},
        says=MUST,
        truth=1.0,
        tolerance=1.0,
    ),
    *(
        options(
            fit, {"poses": (FAR * 1e120,), "u": (DRIVEN * 1e150,)}, says=MUST, poses=FAR, u=DRIVEN
        )
        for fit in FITS
    ),
    [
        Refusal(call, "trace", (None, 1, "x", np.random.default_rng(3).normal(size=(12, 3))), MUST)
        for call in TRACE_TAKERS
    ],
    [
        Refusal(
            lambda value, name=name: robsim.batch_estimate(driven(20), **{name: value}),
            name,
            (bad,),
            says,
            ValueError,
        )
        for name, bad, says in (
            ("identify_from", "magic", "'truth', 'measurement', 'estimate', got 'magic'"),
            ("select", "some", "'valid', 'longest', 'all', got 'some'"),
            ("method", "guess", "method must be one of 'least_squares', 'instrumental_v"),
        )
    ],
    Refusal(
        robsim.batch_estimate, "trace", ("a run",), "trace must be a Trace, got 'a run'", TypeError
    ),
    options(
        lambda **values: robsim.batch_estimate(driven(12), **values),
        {"method select identify_from": (["x"], 3)},
        says=MUST,
    ),
)
def test_records(refusal):
    refusal()


@pytest.mark.long
@refusals(
    options(
        lambda **values: robsim.identifiability(driven(5, estimate_parameters=True), **values),
        {"k": ("a", 2.5, [3], True, 5, -1, 10**30), "sigma": ("a",)},
        says=MUST,
    )
)
def test_steps_of_an_excitation(refusal):
    refusal()


@given(rows=st.integers(0, 6), others=st.integers(0, 6))
def test_as_many_inputs_as_poses(rows, others):
    if rows == others:
        phi, y = regression(np.zeros((rows, 3)), np.zeros((rows, 2)))
        assert phi.shape == (max(rows - 2, 0), 3, 5)
        assert y.shape == (max(rows - 2, 0), 3)
    else:
        refuses("u", regression, np.zeros((rows, 3)), np.zeros((others, 2)))
