"""What is identified from a run of which the camera lost frames."""

import functools

import numpy as np
import pytest

import robsim

pytestmark = pytest.mark.long

DT = 0.2
B1X = 2
METHODS = ("least_squares", "instrumental_variables", "output_error")


@functools.cache
def driven(steps):
    """Return the frames of a drive around, and its inputs."""
    sim = robsim.Simulation(
        headings=None,
        resolution=(300, 300),
        # errors that do not depend on the place, as the standard errors take them to be
        noise=robsim.GaussianNoise(10),
        control=robsim.DriveAround(),
        seed=3,
    )
    frames = [sim.step().frame for _ in range(steps)]
    assert not sim.trace.bounced.any()
    return frames, sim.trace


def without(lost, steps):
    """Return the trace of the frames that are left; their times start at one dt."""
    frames, simulated = driven(steps)
    kept = np.setdiff1d(np.arange(steps), lost)
    timed = [
        robsim.Frame(frames[k].image, t=DT * (k + 1), index=k, plane_map=frames[k].plane_map)
        for k in kept
    ]
    sim = robsim.Experiment(timed, control=lambda step: simulated.u[step.frame.index])
    return sim.run()


def exact(lost, steps):
    """Return a run with true poses that has lost steps."""
    run = robsim.Simulation(boundary="unlimited", control=robsim.DriveAround(), seed=3).run(steps)
    kept = np.setdiff1d(np.arange(steps), lost)
    groups = {"t": run.t, "pose_true": run.pose_true, "u": run.u, "bounced": run.bounced}
    return robsim.Trace({name: rows[kept] for name, rows in groups.items()}, run.info)


def tenth_of(steps):
    return np.random.default_rng(1).choice(np.arange(1, steps), steps // 10, replace=False)


def check_b1x(report, share):
    b1x = robsim.RobotModel().theta[0, B1X]
    error = abs(report.batch[0, B1X] - b1x)
    assert error < share * b1x
    assert error < 4 * report.standard_errors[0, B1X]


@pytest.mark.parametrize(
    ("method", "share"), [("output_error", 0.02), ("instrumental_variables", 0.05)]
)
def test_lost_frames_do_not_spoil_the_unbiased_methods(method, share):
    report = robsim.batch_estimate(without(tenth_of(600), 600), method=method)
    assert report.converged
    check_b1x(report, share)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("select", ["valid", "all"])
def test_exact_poses_with_gaps_give_back_the_parameters(method, select):
    report = robsim.batch_estimate(exact(tenth_of(600), 600), method=method, select=select)
    np.testing.assert_allclose(report.batch, robsim.RobotModel().theta, atol=1e-6)


def test_a_lost_frame_costs_the_samples_that_span_it():
    trace = without([20], 40)
    found = robsim.estimation.regression_of(trace)
    # Of 39 steps 0..38, step 20 comes two dt after step 19.
    np.testing.assert_array_equal(found.k, np.setdiff1d(np.arange(2, 39), [20, 21]))
    assert found.left_out == 2
    longest = robsim.estimation.regression_of(trace, select="longest")
    np.testing.assert_array_equal(longest.k, np.arange(2, 20))
    assert "2 samples with a bounce, a missing pose or lost frames" in str(
        robsim.batch_estimate(trace)
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_time_that_is_no_multiple_of_dt_is_refused(method):
    trace = exact([], 40)
    times = trace.t + np.where(trace.k < 20, 0, DT / 3)
    groups = {"t": times, "pose_true": trace.pose_true, "u": trace.u, "bounced": trace.bounced}
    trace = robsim.Trace(groups, trace.info)
    with pytest.raises(ValueError, match=r"must be a multiple of the model's dt, 0.2 s, got 0.266"):
        robsim.batch_estimate(trace, method=method)
