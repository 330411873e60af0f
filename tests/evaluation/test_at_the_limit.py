"""A verdict on the edge says so, with the spread that it used."""

import numpy as np
import pytest
from scipy import special

import robsim
from robsim.estimation import ConvergenceReport, nees_consistency, nis_consistency, whiteness

pytestmark = pytest.mark.kernels


def said(report):
    return " ".join(report.remarks)


def values_with_a_share_inside(share, steps=100):
    """Errors (steps, 1) of which a share is in the band of chi2(1), the others above it."""
    rng = np.random.default_rng(1)
    return rng.permutation(np.where(np.arange(steps) < share * steps, 1.0, 3.0))[:, None]


@pytest.mark.parametrize(
    ("share", "heading"),
    [
        (0.5, "optimistic"),
        (0.79, "optimistic, at the limit"),
        (0.80, "consistent, at the limit"),
        (0.95, "consistent"),
        (1.0, "consistent"),
    ],
)
def test_the_share_of_the_nees(share, heading):
    report = nees_consistency(values_with_a_share_inside(share), np.eye(1))
    assert report.headline.endswith(f": {heading}")
    assert report.share == pytest.approx(share)
    assert report.at_limit == ("limit" in heading)
    assert ("limit 80 %" in said(report)) == report.at_limit
    assert report.to_dict()["at_limit"] == report.at_limit
    assert report.verdict == heading.split(",")[0]


def test_the_verdict_is_that_of_the_95_percent_band_whatever_is_shown():
    rng = np.random.default_rng(2)
    errors, innovations = rng.normal(size=(20, 200, 3)), rng.normal(size=(200, 2))
    for level in (0.5, 0.99):
        right = nees_consistency(errors, np.eye(3), level=level)
        assert (right.verdict, right.at_limit) == ("consistent", False)
        assert right.inside == pytest.approx(level, abs=0.1)
        assert right.share == pytest.approx(0.95, abs=0.05)
        assert nis_consistency(innovations, np.eye(2), level=level).verdict == "consistent"


def test_the_mean_of_the_nees():
    rng = np.random.default_rng(3)
    errors = rng.normal(size=(20, 500, 3))
    scale = 1 / np.sqrt(nees_consistency(errors, np.eye(3)).mean / 3)
    for factor, verdict, at_limit in (
        (1, "consistent", False),
        (0.903, "consistent", True),
        (0.897, "conservative", True),
        (0.80, "conservative", False),
    ):
        report = nees_consistency(errors * scale * np.sqrt(factor), np.eye(3))
        assert (report.verdict, report.at_limit) == (verdict, at_limit), factor
    edge = nees_consistency(errors * scale * np.sqrt(0.903), np.eye(3))
    assert "limit 0.3" in said(edge)


def test_the_mean_of_the_nis():
    # 50 values of chi2(2): the mean varies by sqrt(2 2/50) = 0.28
    low, high = 2 * special.gammaincinv(50, [0.025, 0.975]) / 50
    for mean, verdict, at_limit in (
        (2.0, "consistent", False),
        (high - 0.2, "consistent", True),
        (high + 0.2, "optimistic", True),
        (high + 0.4, "optimistic", False),
        (low - 0.2, "conservative", True),
        (low - 0.4, "conservative", False),
    ):
        report = nis_consistency(np.full((50, 2), np.sqrt(mean / 2)), np.eye(2))
        assert (report.verdict, report.at_limit) == (verdict, at_limit), mean
        assert ("varies by 0.28" in said(report)) == at_limit


def test_whiteness():
    rng = np.random.default_rng(4)
    seen = set()
    for _ in range(300):
        report = whiteness(rng.normal(size=(100, 1)))
        assert report.degrees_of_freedom == 10
        assert report.ljung_box_limit == pytest.approx(2 * special.gammaincinv(5, 0.95))
        assert report.is_white == (report.ljung_box <= report.ljung_box_limit)
        assert report.at_limit == (
            abs(report.ljung_box - report.ljung_box_limit) <= np.sqrt(2 * 10)
        )
        assert report.at_limit == ("its random spread 4.5" in said(report))
        seen.add((report.is_white, report.at_limit))
    assert seen >= {(True, False), (True, True), (False, True)}


def test_the_default_number_of_lags():
    for shape, lags in (
        *(((20, 3), 2), ((60, 3), 6), ((100, 1), 10)),
        *(((5000, 1), 10), ((5, 12, 2), 3), ((4, 1), 1)),
    ):
        innovation = np.random.default_rng(5).normal(size=shape)
        assert len(whiteness(innovation).autocorrelation) == lags


def test_convergence():
    for error, heading in (
        (0.5, "converged"),
        (0.9, "converged, at the limit"),
        (1.1, "not converged, at the limit"),
        (1.5, "not converged"),
        (np.nan, "not converged"),
    ):
        last, time = np.zeros((2, 3, 5))
        last[0, 1] = error
        time[0, 1] = 0.0 if error <= 1 else np.nan
        report = ConvergenceReport(
            theta_true=np.zeros((3, 5)),
            last=last,
            tolerance=np.ones((3, 5)),
            time=time,
            spread=np.full((3, 5), 0.2),
        )
        assert report.headline.endswith(f": {heading}")
        assert ("a2X" in said(report)) == report.at_limit


def test_a_run_says_how_far_its_online_estimates_vary():
    def run(**options):
        control = robsim.DriveAround()
        sim = robsim.Simulation(control=control, estimate_parameters=True, seed=1, **options)
        return robsim.estimation.parameter_convergence(sim.run(60))

    assert (run().spread < 1e-7).all()  # the truth has no noise
    measured = run(
        measure=lambda step: (600 + step.k, 600, 0.01 * step.k % 1), identify_from="measurement"
    )
    assert (measured.spread > 0).all()


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_the_standard_error_of_a_share_of_correlated_values(memory):
    rng = np.random.default_rng(6)
    series = np.empty((300, 400))
    series[:, 0] = rng.normal(size=300)
    for k in range(1, 400):
        series[:, k] = memory * series[:, k - 1] + np.sqrt(1 - memory**2) * rng.normal(size=300)
    errors = np.where(series < 0.5, 1.0, 3.0)  # inside and above the band
    reports = [nees_consistency(one[:, None], np.eye(1)) for one in errors]
    reported = np.mean([report.share_standard_error for report in reports])
    # that of 300 runs is itself random by 4 %
    assert reported == pytest.approx((series < 0.5).mean(axis=1).std(), rel=0.2)


def test_the_standard_error_of_few_values():
    for values, expected in (([1.0], np.nan), ([1.0, np.nan], np.nan), ([1.0, 1.0, 1.0], 0)):
        report = nees_consistency(np.array(values)[:, None], np.eye(1))
        np.testing.assert_equal(report.share_standard_error, expected)
