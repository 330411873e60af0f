import numpy as np
import pytest

import robsim
from robsim import identifiability
from robsim.estimation.identification.determined import ASSUMED_SIGMA, judge

pytestmark = pytest.mark.kernels

THETA = np.array(
    [[1.9, -0.9, 0.2, 0.1, 0.0], [1.9, -0.9, 0.2, 0.1, 0.0], [1.8, -0.8, 0.03, 0.03, 0]]
)


def run(steps, **options):
    options = {"boundary": "unlimited", "estimate_parameters": True, "seed": 1, **options}
    return robsim.Simulation(**options).run(steps)


def test_a_verdict_compares_the_standard_error_with_the_parameter():
    errors = np.full((3, 5), 1e-9)
    errors[0] = (0.94, 0.46, 0.101, 0.051, 0.009)
    sigma = (0.1, 1.0, 1.0)
    found = judge(errors, THETA, sigma=sigma)
    np.testing.assert_allclose(found.standard_errors[0], 0.1 * errors[0])
    # d1 is 0: it is compared with the larger one of b1 and b2.
    np.testing.assert_allclose(
        found.relative[0], 0.1 * errors[0] / (1.9, 0.9, 0.2, 0.1, 0.2), rtol=1e-12
    )
    assert found.verdicts[0].tolist() == ["well", "poorly", "poorly", "poorly", "well"]
    assert (found.verdicts[1:] == "well").all()
    assert found.names("poorly") == ["a2X", "b1X", "b2X"]
    assert not found.is_assumed
    assert found.verdict == "poorly"
    rows = {line.split()[0]: line.split()[1:] for line in str(found).splitlines()}
    assert rows["a1X"] == ["0.094", "4.9", "%", "well"]
    assert rows["b1X"] == ["0.01", "5.1", "%", "poorly"]


def test_a_verdict_on_the_edge_says_so():
    theta = np.array([[1.9, -0.9, 0.2, 0.1, 0.0]] * 3)
    errors = np.full((3, 5), 1e-9)
    errors[0, 2:4] = (0.0102, 0.5)  # 5.1 and 500 % of the parameters
    exact = judge(errors, theta, sigma=(1, 1, 1))
    assert not exact.are_at_limit.any()
    found = judge(errors, theta, sigma=(1, 1, 1), freedom=100, identify_from="measurement")
    assert found.verdicts[0].tolist() == ["well", "well", "poorly", "not excited", "well"]
    assert found.are_at_limit[0].tolist() == [False, False, True, False, False]
    # the parameter is 19.6 +- 1 standard errors, and these vary by 1/sqrt(200)
    spread = np.sqrt(1 + (1 / 0.051) ** 2 / 200)
    np.testing.assert_allclose(
        found.relative_range[:, 0, 2], (1 / (1 / 0.051 + spread), 1 / (1 / 0.051 - spread))
    )
    assert not found.at_limit  # the worst one is not on the edge
    assert "poorly, at the limit" in str(found)
    errors[0, 3] = 0.04
    found = judge(errors, theta, sigma=(1, 1, 1), freedom=100, identify_from="measurement")
    assert found.headline.endswith("poorly, at the limit")
    errors[0, 2:4] = np.inf
    unknown = judge(errors, theta, sigma=(1, 1, 1), freedom=100, identify_from="measurement")
    assert (unknown.verdict, unknown.at_limit) == ("not excited", False)


def test_what_is_not_known_is_not_excited():
    for unknown in (np.inf, np.nan, 1e9):
        found = judge(np.full((3, 5), unknown), np.where(np.isnan(unknown), np.nan, THETA))
        assert (found.verdicts == "not excited").all()
        assert found.verdict == "not excited"
        np.testing.assert_array_equal(found.sigma, ASSUMED_SIGMA)
        assert found.is_assumed
        assert "assumed" in str(found)


def test_a_spinning_robot_says_nothing_of_x_and_y_and_driving_around_changes_it():
    def control(step):
        return robsim.Spin()(step) if step.k < 200 else robsim.DriveAround()(step)

    trace = run(1000, control=control)
    spinning = identifiability(trace, k=199)
    assert (spinning.verdicts[:2] == "not excited").all()
    assert spinning.verdict == "not excited"
    driving = identifiability(trace)
    assert (driving.verdicts == "well").all()
    np.testing.assert_array_equal(driving.relative, identifiability(trace, k=999).relative)
    np.testing.assert_array_equal(
        identifiability(trace[100:500], k=199).relative, spinning.relative
    )


def test_from_measurements_the_noise_is_that_of_the_prediction_errors(rng):
    path = run(600, control=robsim.DriveAround()).pose_true

    def measure(step):
        return robsim.Measurement(path[step.k] + rng.normal(size=3) * (0.3, 0.3, 0.01))

    trace = run(600, control=robsim.DriveAround(), measure=measure, identify_from="measurement")
    found = identifiability(trace)
    assert not found.is_assumed
    report = robsim.batch_estimate(trace)
    np.testing.assert_allclose(found.sigma, report.identifiability.sigma, rtol=0.01)
    np.testing.assert_allclose(found.standard_errors, report.standard_errors, rtol=0.02)
    # Noise of three measurements meets in an equation.
    assert (found.sigma > (0.3, 0.3, 0.01)).all()


def test_a_step_or_sigma_beyond_its_limits_is_named():
    trace = run(20)
    for k in (-1, 20):
        with pytest.raises(ValueError, match="k must"):
            identifiability(trace, k=k)
    for sigma in ((1, 2), (1, 2, -1)):
        with pytest.raises(ValueError, match="sigma"):
            identifiability(trace, sigma=sigma)
    with pytest.raises(ValueError, match="standard_errors_unscaled"):
        identifiability(run(20, estimate_parameters=False))


def test_an_estimator_of_ones_own_gives_no_standard_errors():
    class Own:
        def update(self, phi, y):
            return np.ones((3, 5))

    trace = run(20, init_parameter_estimator=lambda model: Own())
    assert np.isnan(trace.standard_errors_unscaled).all()
    assert "standard_error_unscaled_a1X" not in trace.names


def test_the_default_estimator_in_a_callback_gives_standard_errors():
    def estimate_parameters(step):
        return step.sample and step.estimator.update(step.sample.phi, step.sample.y)

    own, default = run(50, estimate_parameters=estimate_parameters), run(50)
    np.testing.assert_array_equal(own.standard_errors_unscaled, default.standard_errors_unscaled)
    assert np.isnan(run(50, estimate_parameters=lambda step: None).standard_errors_unscaled).all()
