"""The figures of errors, consistency and bounds: what stands where, on hand-made traces."""

import sys

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import same_color
from matplotlib.figure import Figure

import robsim
from robsim.estimation import estimation_errors, nees_consistency, pose_errors
from robsim.plotting import plot_consistency, plot_ellipses, plot_errors, plot_parameters
from robsim.plotting import style as style

pytestmark = pytest.mark.kernels

NAN = np.nan


@pytest.fixture(scope="module", autouse=True)
def _no_pyplot():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "matplotlib.pyplot", None)
        yield


def make_trace(steps=50, *, first_step=0, **groups):
    """A robot that drives to the right and down, estimated 1 px beside its place."""
    k = np.arange(steps)
    true = np.column_stack((100.0 + 4 * k, 200.0 + 2 * k, np.full(steps, 0.5)))
    groups = {
        "pose_true": true,
        "u": np.zeros((steps, 2)),
        "bounced": np.zeros((steps, 1)),
        "pose_estimated": true + np.array((1.0, 0.0, 0.02)),
        "covariance": np.broadcast_to(np.diag([4.0, 1.0, 1e-4]), (steps, 3, 3)),
        **groups,
    }
    theta = robsim.RobotModel().theta
    info = robsim.trace.RunInfo(dt=0.2, theta_true=theta, boundary="unlimited")
    return robsim.Trace(groups, info, first_step=first_step)


def render(figure):
    """Draw everything: a warning on the way is an error."""
    assert isinstance(figure, Figure)
    figure.set_layout_engine("none")
    figure.draw_without_rendering()
    return figure


def line(axes, label):
    return next(line for line in axes.get_lines() if line.get_label() == label)


def labels(axes):
    return axes.get_legend_handles_labels()[1]


# errors


@pytest.mark.long
def test_errors_stand_beside_their_histograms():
    measured = make_trace().pose_true + np.array((1.0, 0.5, 0.02))
    measured[10:20] = NAN
    trace = make_trace(first_step=7, pose_measured=measured)
    figure = render(plot_errors(pose_errors(trace, of="measurement")))
    panels, histograms = figure.axes[::2], figure.axes[1::2]
    k = np.arange(7, 57)
    np.testing.assert_array_equal(line(panels[0], "error").get_xdata(), k)
    np.testing.assert_allclose(line(panels[0], "error").get_ydata()[20:], 1.0)
    np.testing.assert_allclose(line(panels[2], "error").get_ydata()[20:], np.rad2deg(0.02))
    for panel, histogram in zip(panels, histograms, strict=True):
        assert panel.get_ylim() == histogram.get_ylim()
        assert sum(bar.get_width() for bar in histogram.patches) == 40
    assert figure.get_suptitle() == "Measurement minus truth: known in 40 of 50 steps"


def test_the_claim_and_the_bound_are_drawn_at_two_standard_deviations():
    bound = np.broadcast_to(np.diag([0.25, 0.25, 1e-6]), (50, 3, 3))
    panel = plot_errors(pose_errors(make_trace()), bound=bound).axes[0]
    assert labels(panel) == ["reported (2 sd)", "error", "Cramér-Rao bound (2 sd)"]
    assert [top for _, _, top in spans_of(panel.collections[0])] == [4.0]
    np.testing.assert_allclose(line(panel, "Cramér-Rao bound (2 sd)").get_ydata(), 1.0)
    with pytest.raises(ValueError, match=r"^bound .*\(50, 3, 3\)"):
        plot_errors(pose_errors(make_trace()), bound=np.eye(3))


def spans_of(band):
    """Where a band is drawn: first and last x of each part, and its largest y."""
    parts = [path.vertices for path in band.get_paths()]
    return [(part[:, 0].min(), part[:, 0].max(), part[:, 1].max()) for part in parts]


@pytest.mark.long
def test_the_band_has_gaps_where_nothing_was_measured():
    covariance = np.broadcast_to(np.diag([1.0, 1.0, 25.0]), (50, 3, 3)).copy()
    covariance[10:12] = covariance[13:15] = np.nan  # step 12 stands alone
    trace = make_trace(covariance=covariance)
    panels = plot_errors(pose_errors(trace)).axes
    first = trace.k[0]
    for panel, top in ((panels[0], 2.0), (panels[4], 180.0)):  # 2 sd of 5 rad are more than all
        assert spans_of(panel.collections[0]) == [
            (first - 0.5, first + 9.5, pytest.approx(top)),
            (first + 11.5, first + 12.5, pytest.approx(top)),
            (first + 14.5, first + 49.5, pytest.approx(top)),
        ]


@pytest.mark.parametrize("variance", [4.0, 400.0])
def test_the_claim_of_a_conservative_filter_ends_in_the_panel_or_the_errors_can_be_seen(variance):
    covariance = np.broadcast_to(np.diag([variance, 1.0, 1e-4]), (50, 3, 3))
    panel = plot_errors(pose_errors(make_trace(covariance=covariance))).axes[0]
    low, high = panel.get_ylim()  # the errors are 1 px
    if variance == 4.0:
        assert low < -4 < 4 < high
    else:
        assert -10 < low < high < 10


@pytest.mark.long
def test_errors_of_runs_have_their_root_mean_square():
    rng = np.random.default_rng(1)
    errors = rng.normal(size=(10, 30, 1))
    report = estimation_errors(errors, np.zeros((10, 30, 1)), names=["z"], units=["m"])
    figure = Figure()
    axes = figure.subplots(1, 2, squeeze=False)
    assert plot_errors(report, axes=axes) is figure
    panel = axes[0, 0]
    rmse = np.sqrt(np.mean(errors[..., 0] ** 2, axis=0))
    np.testing.assert_allclose(line(panel, "2 rmse of the runs").get_ydata(), 2 * rmse)
    assert sum(len(one.get_xdata()) == 30 for one in panel.get_lines()) >= 12
    render(figure)
    with pytest.raises(ValueError, match=r"\baxes\b"):
        plot_errors(report, axes=panel)


def test_an_error_far_outside_is_marked_at_the_edge():
    trace = make_trace()
    estimated = trace.pose_estimated.copy()
    estimated[:, 0] += np.sin(np.arange(50))
    estimated[20, 0] += 1000
    panel = plot_errors(pose_errors(make_trace(pose_estimated=estimated))).axes[0]
    assert panel.get_ylim()[1] < 100
    assert panel.get_title(loc="right") == "1 error beyond the edge: triangle"


# NEES and NIS


@pytest.mark.long
def test_the_values_stand_with_their_band():
    # n = 1: the band is 0.00098..5.02
    report = nees_consistency(np.array([[1.0], [0.001], [NAN], [3.0], [1.5]]), [[1.0]])
    axes = plot_consistency(report)
    assert labels(axes) == ["95 % band", "50.0 % in", "25.0 % above", "25.0 % below"]
    np.testing.assert_array_equal(line(axes, "50.0 % in").get_xdata(), [0, 4])
    np.testing.assert_allclose(line(axes, "25.0 % above").get_xydata(), [[3, 9]])
    np.testing.assert_allclose(line(axes, "25.0 % below").get_xydata(), [[1, 1e-6]])
    assert axes.get_title(loc="left") == "NEES of 1 run of 5 steps: conservative"
    assert axes.get_yscale() == "log"
    assert axes.get_ylabel() == "NEES\n(1 expected)"
    render(axes.figure)


# ellipses


def drawn_ellipses(axes):
    collection = next(c for c in axes.collections if isinstance(c, PolyCollection))
    return np.array([path.vertices[:-1] for path in collection.get_paths()])


@pytest.mark.long
def test_ellipses_lie_on_the_path_as_the_camera_sees_it():
    axes = plot_ellipses(make_trace(), every=10, magnify=1, level=0.95)
    drawn = drawn_ellipses(axes)
    assert len(drawn) == 5
    np.testing.assert_allclose(drawn.mean(axis=1), make_trace().pose_estimated[::10, :2])
    # sqrt(5.99) times the standard deviations 2 and 1
    size = 2 * np.sqrt(5.9915) * np.array([2, 1])
    np.testing.assert_allclose(np.ptp(drawn, axis=1)[0], size, rtol=1e-4)
    turned = np.tile(np.diag([4.0, 1.0, 1e-4]), (50, 1, 1))
    turned[:, 0, 1] = turned[:, 1, 0] = 1.5
    drawn = drawn_ellipses(plot_ellipses(make_trace(covariance=turned), every=50, magnify=1))[0]
    # all corners at the same e' P^-1 e, the chi-square quantile of 2 degrees of freedom
    corners = drawn - make_trace().pose_estimated[0, :2]
    values = np.einsum("ki,ij,kj->k", corners, np.linalg.inv(turned[0, :2, :2]), corners)
    np.testing.assert_allclose(values, 5.991464547)
    np.testing.assert_allclose(line(axes, "true path").get_xydata(), make_trace().pose_true[:, :2])
    assert axes.yaxis_inverted()
    assert axes.get_aspect() == 1
    assert axes.get_title(loc="left") == "0 of 5 ellipses miss the true position"
    render(axes.figure)


def test_larger_ellipses_leave_the_paths_and_the_verdict_as_they_are():
    estimated = make_trace().pose_estimated.copy()
    estimated[10, 0] += 4.5  # 5.5 px off; the ellipse ends at 2 sqrt(5.99) = 4.9 px
    trace = make_trace(pose_estimated=estimated)
    sizes = []
    for magnify in (1, 5):
        axes = plot_ellipses(trace, every=10, magnify=magnify)
        np.testing.assert_allclose(line(axes, "true path").get_xydata(), trace.pose_true[:, :2])
        assert axes.get_title(loc="left").startswith("1 of 5 ellipses miss the true position")
        inside, missed = axes.collections
        assert same_color(missed.get_edgecolor()[0], style.WRONG)
        assert (len(inside.get_paths()), len(missed.get_paths())) == (4, 1)
        sizes.append(np.ptp(drawn_ellipses(axes), axis=1))
    np.testing.assert_allclose(sizes[1], 5 * sizes[0])
    small = make_trace(covariance=np.broadcast_to(1e-6 * np.eye(3), (50, 3, 3)))
    assert "2000 times as large" in plot_ellipses(small).get_title(loc="left")


def test_ellipses_are_drawn_where_the_covariance_is_known_and_not_huge():
    covariance = np.tile(np.diag([4.0, 1.0, 1e-4]), (50, 1, 1))
    covariance[:13] = NAN
    covariance[13] = np.diag([600.0**2, 600.0**2, 3.0])  # not seen yet
    drawn = drawn_ellipses(plot_ellipses(make_trace(covariance=covariance), every=10, magnify=1))
    np.testing.assert_allclose(drawn.mean(axis=1)[:, 0], 101.0 + 4 * np.array([23, 33, 43]))
    for wrong in (np.full((50, 3, 3), NAN), np.tile(2 - np.eye(3), (50, 1, 1))):
        with pytest.raises(ValueError, match=r"no covariance|positive definite"):
            plot_ellipses(make_trace(covariance=wrong))
    for wrong in ({"every": 0}, {"level": 1.0}, {"magnify": 0.0}):
        with pytest.raises(ValueError, match=f"^{next(iter(wrong))} must"):
            plot_ellipses(make_trace(), **wrong)


# parameters


@pytest.mark.long
def test_two_standard_errors_are_dashed_lines():
    theta = robsim.RobotModel().theta
    trace = make_trace(parameters=np.broadcast_to(theta, (50, 3, 5)))
    errors = np.full((50, 3, 5), 0.01)
    errors[:5] = np.inf
    figure = render(plot_parameters(trace, standard_errors=errors))
    assert figure.get_suptitle().endswith("dashed: two standard errors")
    dashed = [one for one in figure.axes[0].get_lines() if one.get_linestyle() == "--"]
    assert len(dashed) == 5
    values = np.asarray(dashed[0].get_ydata())
    assert np.isnan(values[:5]).all()
    np.testing.assert_allclose(values[5:], 0.02 / theta[0, 0])
    shown = plot_parameters(trace).axes[0].get_lines()
    assert not [one for one in shown if one.get_linestyle() == "--"]
    with pytest.raises(ValueError, match="standard_errors"):
        plot_parameters(trace, standard_errors=errors[:, 0])
