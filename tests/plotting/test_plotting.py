"""The figures: what stands where, on hand-made traces."""

import dataclasses
import math
import sys

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import same_color
from matplotlib.figure import Figure

import robsim
from robsim.plotting import plot_batch, plot_frame, plot_parameters, plot_traces
from robsim.plotting import style as style
from robsim.trace import RunInfo, Trace

pytestmark = pytest.mark.long

THETA_TRUE = (
    (1.9375, -0.9375, 0.20833, 0.20833, 8.3333e-06),
    (1.9375, -0.9375, 0.20833, 0.20833, 8.3333e-06),
    (1.8333, -0.83333, 0.030556, -0.030556, 0.0),
)


@pytest.fixture(scope="module", autouse=True)
def _no_pyplot():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "matplotlib.pyplot", None)
        yield


def make_trace(steps=60, *, seen=None, tracked=True, noise=0.3, more=None, change=None, **about):
    """A robot that turns on a circle by 10 degrees a step, seen where `seen` says so.

    `change` has functions that change a group of columns in place, by its name.
    """
    rng = np.random.default_rng(7)
    heading = np.deg2rad(10.0) * np.arange(steps) + 0.05
    true = np.column_stack(
        (600 + 200 * np.cos(heading), 500 + 200 * np.sin(heading), robsim.wrap_angle(heading))
    )
    groups = {"pose_true": true, "u": np.zeros((steps, 2)), "bounced": np.zeros(steps)}
    if tracked:
        seen = np.ones(steps, dtype=bool) if seen is None else np.asarray(seen)
        error = noise * rng.standard_normal((steps, 3)) * (1.0, 1.0, 0.01)
        measured = np.where(seen[:, None], true + error, np.nan)
        held = measured.copy()
        for k in range(1, steps):
            if not seen[k]:
                held[k] = held[k - 1]
        groups |= {"pose_measured": measured, "pose_held": held}
    groups |= more or {}
    for name, function in (change or {}).items():
        function(groups[name])
    first_step = about.pop("first_step", 0)
    info = RunInfo(**({"dt": 0.2, "theta_true": THETA_TRUE, "boundary": "bounce"} | about))
    return Trace(groups, info, first_step=first_step)


def render(figure, *, layout=True):
    """Draw everything: a warning on the way is an error. Without the layout it is much faster."""
    assert isinstance(figure, Figure)
    if not layout:
        figure.set_layout_engine("none")
    figure.draw_without_rendering()
    return figure


def plan(figure):
    return next(axes for axes in figure.axes if axes.get_xlabel() == "x (px)")


def panel(figure, label):
    panels = [axes for axes in figure.axes if axes is not plan(figure)]
    return next(axes for axes in panels if axes.get_ylabel() == label)


def histograms(figure):
    """The axes of the histograms: those without a label at their y axis."""
    return [axes for axes in figure.axes if not axes.get_ylabel()]


def lines(axes, color):
    """The lines of a colour that show something."""
    found = [line for line in axes.get_lines() if same_color(line.get_color(), color)]
    return [line for line in found if len(points(line))]


def points(line):
    places = line.get_xydata()
    return places[np.isfinite(places).all(axis=1)]


# traces


def make_blobs():
    """One blob in all 60 steps, a second one in step 5."""
    blobs = np.full((60, 4), np.nan)
    blobs[:, 0], blobs[:, 1] = 100, 200
    blobs[5, 2:] = 300, 400
    return {"blobs_red": blobs, "blobs_my_color": blobs}


@pytest.fixture(scope="module")
def usual():
    """A trace and its figure."""
    trace = make_trace(more=make_blobs())
    return trace, render(plot_traces(trace))


@pytest.fixture(scope="module")
def rich():
    """A trace with everything in it, the robot not seen or taken for another, and its figure."""
    seen = np.ones(60, dtype=bool)
    seen[[0, 1, 20, 21, 40]] = False

    def lose(measured):
        measured[30, 0] += 400
        measured[31, 0] -= 300

    more = {"pose_estimated": np.ones((60, 3)), **make_blobs()}
    trace = make_trace(seen=seen, more=more, change={"pose_measured": lose})
    return trace, render(plot_traces(trace, show_blobs=True), layout=False)


@pytest.fixture(scope="module")
def long():
    trace = make_trace(6000)
    return trace, plot_traces(trace)


def test_true_and_measured_values_and_their_errors_are_where_they_belong(usual):
    trace, figure = usual
    assert len(figure.axes) == 10
    (true,) = lines(panel(figure, "x (px)"), style.TRUE)
    np.testing.assert_array_equal(true.get_ydata(), trace.pose_true[:, 0])
    (measured,) = lines(panel(figure, "x (px)"), style.MEASURED)
    np.testing.assert_array_equal(measured.get_xdata(), trace.k)
    np.testing.assert_array_equal(measured.get_ydata(), trace.pose_measured[:, 0])
    (dx,) = lines(panel(figure, "x error\n(px)"), style.MEASURED)
    np.testing.assert_array_equal(dx.get_ydata(), trace.error[:, 0])
    (turn,) = lines(panel(figure, "heading error\n(deg)"), style.MEASURED)
    np.testing.assert_allclose(turn.get_ydata(), np.rad2deg(trace.error[:, 2]))
    (true,) = lines(panel(figure, "heading (deg)"), style.TRUE)
    heading = np.asarray(true.get_ydata())
    assert np.isnan(heading).sum() == 2  # 60 steps of 10 degrees: past 180 and past 540
    assert np.nanmax(np.abs(heading)) <= 180
    assert np.nanmax(np.abs(np.diff(heading))) < 11


def test_what_was_not_seen_is_black_where_it_was_last_seen(rich):
    trace, figure = rich
    (held,) = lines(panel(figure, "x (px)"), style.HELD)
    np.testing.assert_array_equal(points(held)[:, 0], [20, 21, 40])
    np.testing.assert_array_equal(points(held)[:, 1], trace.pose_measured[[19, 19, 39], 0])
    (measured,) = lines(panel(figure, "heading (deg)"), style.MEASURED)
    np.testing.assert_array_equal(points(measured)[:, 0], np.flatnonzero(trace.seen))
    (estimated,) = lines(panel(figure, "x (px)"), style.ESTIMATED)
    np.testing.assert_array_equal(estimated.get_ydata(), trace.pose_estimated[:, 0])


def test_blobs_are_drawn_only_when_asked_for(rich, usual):
    (dots,) = lines(panel(rich[1], "x (px)"), "red")
    values = np.asarray(dots.get_ydata())
    assert np.count_nonzero(values == 100) == 60
    assert dots.get_xdata()[values == 300] == [5]
    assert not lines(panel(usual[1], "x (px)"), "red")


def test_histograms_are_of_all_steps_in_which_the_robot_was_seen():
    seen = np.ones(300, dtype=bool)
    seen[[50, 250]] = False
    trace = make_trace(300, seen=seen, first_step=1000)
    for axis, axes in enumerate(histograms(plot_traces(trace))):
        bars = [bar for bar in axes.patches if bar.get_width() > 0]
        assert sum(bar.get_width() for bar in bars) == 298
        error = trace.error[trace.seen, axis] * (np.rad2deg(1.0) if axis == 2 else 1.0)
        height = bars[0].get_height()
        bottom, top = bars[0].get_y(), bars[-1].get_y() + height
        assert bottom <= error.min() < bottom + height
        assert top - height <= error.max() <= top


def test_many_errors_are_drawn_as_ranges_and_as_an_image(long):
    trace, figure = long
    axes = panel(figure, "x error\n(px)")
    assert not lines(axes, style.MEASURED)
    widest, inner = (band.get_paths()[0].vertices[:, 1] for band in axes.collections)
    error = trace.error[:, 0]
    assert (widest.min(), widest.max()) == (error.min(), error.max())
    assert 0.2 < np.median(inner[inner > 0]) < 0.4  # one standard deviation to either side
    assert all(line.get_rasterized() for line in panel(figure, "x (px)").get_lines())


def test_the_bell_curve_has_the_area_of_the_histogram_and_its_numbers_are_printed(long):
    trace, figure = long
    axes = histograms(figure)[0]
    (curve,) = lines(axes, style.FITTED)
    height, place = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
    bar = axes.patches[0].get_height()
    assert np.sum(height[:-1] * np.diff(place)) == pytest.approx(6000 * bar, rel=0.01)
    error = trace.error[:, 0]
    assert place[np.argmax(height)] == pytest.approx(error.mean(), abs=0.02)
    assert axes.get_title(loc="left") == f"mean {error.mean():.3f}, sd {error.std():.3f} px"
    assert not axes.texts


def test_a_false_pose_does_not_hide_the_others(rich):
    axes = panel(rich[1], "x error\n(px)")
    low, high = axes.get_ylim()
    assert -2 < low < -0.5
    assert 0.5 < high < 2
    above, below = lines(axes, style.HELD)
    assert points(above).tolist() == [[30, high]]
    assert points(below).tolist() == [[31, low]]
    assert axes.get_title(loc="right") == "2 errors beyond the edge: triangles"


def test_plan_has_the_y_axis_downwards_and_equal_scales(usual):
    trace, figure = usual
    axes = plan(figure)
    assert axes.get_xlim() == (-0.5, 1199.5)
    assert axes.get_ylim() == (1199.5, -0.5)
    assert axes.get_aspect() == 1
    path, start = lines(axes, style.TRUE)
    np.testing.assert_array_equal(path.get_xydata(), trace.pose_true[:, :2])
    np.testing.assert_array_equal(start.get_xydata(), trace.pose_true[:1, :2])
    (measured,) = lines(axes, style.MEASURED)
    np.testing.assert_array_equal(measured.get_xydata(), trace.pose_measured[:, :2])


def test_without_tracking_there_are_the_upper_rows_only():
    figure = render(plot_traces(make_trace(tracked=False)), layout=False)
    assert len(figure.axes) == 4
    assert "not measured" in figure.get_suptitle()


def test_the_steps_also_have_their_time():
    sim = robsim.Simulation(seed=1)
    sim.run(11)
    figure = plot_traces(sim.trace)
    (seconds,) = figure.axes[0].child_axes
    figure.draw_without_rendering()
    assert seconds.get_xlabel() == "time (s)"
    assert seconds.get_xlim() == pytest.approx((-0.1, 2.1))
    assert not plot_traces(sim.trace[:1]).axes[0].child_axes


def test_one_valid_step_and_none():
    trace = make_trace(20, seen=np.arange(20) == 4)
    first = histograms(plot_traces(trace))[0]
    assert sum(bar.get_width() for bar in first.patches) == 1
    assert not lines(first, style.FITTED)
    figure = render(plot_traces(trace[5:]), layout=False)  # held, but not seen
    assert "never seen" in figure.get_suptitle()
    assert len(figure.axes) == 4


def test_a_single_step_is_a_dot_of_every_colour():
    trace = make_trace(1, more={"pose_estimated": np.ones((1, 3))}, boundary="unlimited")
    figure = render(plot_traces(trace, show_blobs=True), layout=False)
    for color in (style.TRUE, style.MEASURED, style.ESTIMATED):
        (dot,) = lines(panel(figure, "x (px)"), color)
        assert dot.get_marker() == "."


def test_what_is_drawn_lies_in_its_panel():
    def turn(poses):
        poses[:, 2] = robsim.wrap_angle(3.0 + 0.1 * np.arange(60))

    def hold(poses):
        poses[:, 2] = 3.0

    trace = make_trace(seen=np.arange(60) < 10, change={"pose_true": turn, "pose_held": hold})
    axes = panel(plot_traces(trace), "heading (deg)")
    (held,) = lines(axes, style.HELD)
    low, high = axes.get_ylim()
    assert len(points(held)) == 50
    assert low < points(held)[:, 1].min() <= points(held)[:, 1].max() < high
    change = {"pose_measured": lambda poses: np.add(poses, (14, 0, 0), out=poses)}
    figure = plot_traces(make_trace(noise=0.0, change=change))  # a constant error
    low, high = panel(figure, "x error\n(px)").get_ylim()
    assert low < 14 < high
    figure = plot_traces(make_trace(noise=1e-13))  # rounding errors do not look like errors
    low, high = panel(figure, "x error\n(px)").get_ylim()
    assert low < -1e-4 < 1e-4 < high
    change = {"pose_true": lambda poses: np.add(poses, (5000, 0, 0), out=poses)}
    axes = plan(plot_traces(make_trace(boundary="unlimited", tracked=False, change=change)))
    assert axes.yaxis_inverted()
    assert axes.get_xlim()[0] < 5400
    assert axes.get_xlim()[1] > 5800


# all figures


def test_the_users_settings_stay():
    before = matplotlib.rcParams.copy()
    plot_traces(make_trace(3, tracked=False))
    plot_parameters(make_parameters(1))
    plot_batch(make_report())
    plot_frame(make_frame())
    assert matplotlib.rcParams.copy() == before


# parameters


def make_parameters(steps=400, **changes):
    """Estimates that jump at the start and then converge, but d1Y to a wrong value."""
    rng = np.random.default_rng(11)
    decay = np.exp(-np.arange(steps) / 10.0)[:, None, None]
    parameters = np.array(THETA_TRUE) + 1e3 * decay * rng.standard_normal((steps, 3, 5))
    parameters[:, 1, 4] = 31.9
    return make_trace(steps, more={"parameters": parameters.reshape(steps, 15)}, **changes)


@pytest.fixture(scope="module")
def estimated():
    """A trace with online estimates and its figure."""
    trace = make_parameters()
    return trace, render(plot_parameters(trace), layout=False)


def errors_of(axes):
    """The curves of a1, a2, b1, b2, d1."""
    return [line for line in axes.get_lines() if len(line.get_xdata()) > 2]


def written(axes):
    return [text.get_text() for text in axes.texts]


def test_parameters_are_errors_on_a_logarithmic_axis(estimated):
    trace, figure = estimated
    for axis, axes in enumerate(figure.axes):
        assert axes.get_yscale() == "log"
        true = np.array(THETA_TRUE[axis])
        errors = np.abs(trace.parameters[:, axis] - true)
        scale = [*np.abs(true[:4]), 1]  # that of d1 is absolute
        for i, curve in enumerate(errors_of(axes)):
            expected = errors[:, i] / scale[i]
            np.testing.assert_allclose(curve.get_ydata(), np.where(expected > 0, expected, np.nan))
    low, high = figure.axes[0].get_ylim()
    assert low < np.nanquantile(errors_of(figure.axes[0])[0].get_ydata(), 0.1)
    assert 100 <= high < 1000  # 10 000 %; the first estimates are worse


def test_true_values_and_last_estimates_stand_beside_the_curves(estimated):
    assert written(estimated[1].axes[1])[-3:] == ["d1Y (px)", "8.3333e-06", "31.9"]

    def forget(parameters):
        parameters[:30] = np.nan
        parameters[:, 10:] = np.nan

    figure = plot_parameters(make_parameters(40, change={"parameters": forget}))
    assert written(figure.axes[2])[2:5] == ["a1P", "1.8333", "none"]
    with pytest.raises(robsim.trace.NotRecordedError, match="parameters"):
        plot_parameters(make_trace())


def test_figures_are_drawn_into_given_axes():
    nested = Figure()
    axes = nested.subfigures(1, 2)[1].subplots(3)
    assert plot_parameters(make_parameters(50), axes=axes) is nested
    assert len(nested.axes) == 3
    assert len(errors_of(axes[2])) == 5
    with pytest.raises(ValueError, match=r"\baxes\b.*3.*\(2,\)"):
        plot_parameters(make_parameters(50), axes=axes[:2])
    given = Figure().add_subplot()
    assert plot_batch(make_report(), ax=given) is given
    assert len(drawn(given, style.BATCH)) == 15
    given = Figure().add_subplot()
    assert plot_frame(make_frame(), ax=given) is given
    assert given.images


def test_parameters_without_a_truth_show_the_way_to_the_last_estimate():
    unknown = tuple((math.nan,) * 5 for _ in range(3))
    trace = make_parameters(40, theta_true=unknown, boundary="recorded")
    figure = plot_parameters(trace)
    axes = figure.axes[0]
    assert axes.get_ylabel() == "x: deviation\nfrom the last"
    assert "true" not in written(axes)
    first, last = trace.parameters[[5, -1], 0, 0]
    (shown,) = [y for x, y in points(axes.get_lines()[0]) if x == trace.k[5]]
    assert shown == pytest.approx(abs(first - last) / abs(last))


# batch

NOTHING = np.full((3, 5), np.nan)


def make_report(*, batch=None, online=NOTHING):
    theta_true = np.array(THETA_TRUE)
    return robsim.estimation.BatchEstimate(
        theta_true=theta_true,
        batch=theta_true * (1 + 1e-12) if batch is None else batch,
        online=online,
        identify_from="truth",
        start=120,
        stop=800,
        rank=np.full(3, 5),
        condition=np.ones(3),
        residual_rms=np.zeros(3),
    )


def drawn(axes, color):
    """Row and deviation of the markers of a colour."""
    return {
        round(float(y), 1): float(x)
        for line in lines(axes, color)
        if line.get_marker() != "None"
        for x, y in points(line)
    }


def test_batch_shows_the_relative_deviation_and_of_d1_the_absolute_one():
    online = np.array(THETA_TRUE) * 1.1
    online[1, 4] = 31.9
    axes = plot_batch(make_report(online=online))
    batch, off = drawn(axes, style.BATCH), drawn(axes, style.ESTIMATED)
    assert len(batch) == len(off) == 15
    assert batch[0.0] == pytest.approx(1e-12, rel=1e-3)
    assert off[3.0] == pytest.approx(0.1)
    assert off[9.6] == pytest.approx(31.9)
    low, high = axes.get_xlim()
    assert batch[14 + 1.2] == low  # exact: it points to the left edge
    assert high > 31.9
    hollow = [line for line in axes.get_lines() if line.get_markerfacecolor() == "white"]
    assert sorted(len(points(line)) for line in hollow) == [2, 2]  # d1P is exact
    printed = written(axes)
    assert printed.count("8.3333e-06") == 4  # true and batch, X and Y
    assert printed.count("31.9") == 1
    axes = plot_batch(make_report(batch=NOTHING))
    render(axes.figure)
    assert not drawn(axes, style.BATCH)
    assert "not determined" in written(axes)
    assert axes.figure._repr_png_().startswith(b"\x89PNG")  # as a notebook shows it


def test_batch_without_a_truth_shows_the_relative_standard_errors():
    report = dataclasses.replace(
        make_report(batch=np.full((3, 5), 2.0)),
        theta_true=NOTHING,
        standard_errors=np.full((3, 5), 0.1),
        identify_from="measurement",
    )
    axes = plot_batch(report)
    assert axes.get_xlabel().startswith("standard errors")
    (_, high) = axes.patches[0].get_bbox().intervalx
    assert high == pytest.approx(0.1)  # two standard errors of 0.1, relative to 2
    assert not drawn(axes, style.BATCH)
    assert not {"true", "not determined"} & set(written(axes))


# frame

AT_AN_ANGLE = robsim.vision.PlaneMap([[2.0, 0.3, 10.0], [0.1, 2.2, -5.0], [1e-3, 2e-3, 1.0]])


def make_frame(plane_map=None, *, marker=None):
    """A camera with a pixel for 20 x 20 of the work area; a red marker of 3 x 3 pixels."""
    image = np.full((40, 60, 3), 200, dtype=np.uint8)
    if marker is not None:
        u, v = marker
        image[v - 1 : v + 2, u - 1 : u + 2] = (255, 0, 0)
    plane_map = plane_map or robsim.vision.PlaneMap.scaled((60, 40), (1200, 800))
    return robsim.Frame(image, t=2.4, index=12, plane_map=plane_map)


def blobs_of(frame):
    return robsim.find_blobs(frame, robsim.load_colors(), minimum_area=1)


def test_a_frame_is_in_work_area_pixels_with_boxes_of_blobs_and_the_heading():
    frame = make_frame(marker=(30, 10))
    measurement = robsim.Measurement((600.0, 400.0, np.deg2rad(30)))
    axes = plot_frame(frame, blobs=blobs_of(frame), measurement=measurement)
    render(axes.figure, layout=False)
    assert axes.get_xlim() == (-0.5, 1199.5)
    assert axes.get_ylim() == (799.5, -0.5)
    assert tuple(axes.images[0].get_extent()) == (-0.5, 1199.5, 799.5, -0.5)
    assert axes.get_title(loc="left") == "frame 12, t = 2.40 s"
    (box,) = axes.patches
    assert same_color(box.get_edgecolor(), "red")
    corners = box.get_xy()[:4]
    # Columns 29..31, rows 9..11, each 20 work-area pixels wide.
    np.testing.assert_allclose(corners.min(axis=0), (29 * 20 - 0.5, 9 * 20 - 0.5))
    np.testing.assert_allclose(corners.max(axis=0), (32 * 20 - 0.5, 12 * 20 - 0.5))
    (cross,) = [line for line in lines(axes, "white") if len(points(line)) == 1]
    np.testing.assert_allclose(cross.get_xydata(), [[30.5 * 20 - 0.5, 10.5 * 20 - 0.5]])
    start, end = lines(axes, style.MEASURED)[0].get_xydata()
    np.testing.assert_allclose(start, (600, 400))
    np.testing.assert_allclose(end - start, 80 * np.array((np.cos(np.pi / 6), 0.5)))
    title = plot_frame(make_frame(), blobs={"red": []}).get_title(loc="left")
    assert title.endswith(", not seen")


@pytest.mark.parametrize(("width", "height"), [(640, 360), (400, 400), (300, 400)])
def test_a_frame_fills_its_figure(width, height):
    axes = plot_frame(robsim.Frame(np.zeros((height, width, 3), np.uint8)))
    figure = axes.figure
    figure.draw_without_rendering()
    assert axes.get_window_extent().height > 0.7 * figure.get_window_extent().height
    assert axes.get_window_extent().width > 0.7 * figure.get_window_extent().width


def test_outline_stands_at_the_measured_pose():
    measurement = robsim.Measurement((600.0, 400.0, np.pi / 2))
    outline = [(50, 0), (0, 30), (0, -30)]
    axes = plot_frame(make_frame(), measurement=measurement, outline=outline)
    (polygon,) = axes.patches
    assert same_color(polygon.get_edgecolor(), style.MEASURED)
    # Heading down: forward is +y, the robot's right is -x.
    np.testing.assert_allclose(
        polygon.get_xy(), [(600, 450), (570, 400), (630, 400), (600, 450)], atol=1e-9
    )
    with pytest.raises(ValueError, match="outline"):
        plot_frame(make_frame(), measurement=measurement, outline=[1, 2, 3])


def test_the_robot_stands_at_the_end_of_its_path_with_its_outline():
    trace = make_trace(robot="lab")
    (outline,) = plot_frame(make_frame(), trace=trace, k=20).patches
    pose, lab = trace.pose_measured[20], robsim.load_robot("lab")
    offsets = outline.get_xy()[:-1] - pose[:2]
    expected = np.linalg.norm(lab.to_robot_frame(lab.outline), axis=1)
    np.testing.assert_allclose(np.linalg.norm(offsets, axis=1), expected)
    unseen = make_trace(seen=np.arange(60) < 59, robot="lab")
    (outline,) = plot_frame(make_frame(), trace=unseen).patches
    assert same_color(outline.get_edgecolor(), style.TRUE)
    assert not plot_frame(make_frame(), trace=make_trace(robot="gone")).patches


def test_goals_are_rings_and_their_headings_arrows():
    axes = plot_frame(make_frame(), trace=make_trace(), goals=[(900, 300), (100, 200)])
    (ring,) = [line for line in lines(axes, style.GOAL) if line.get_marker() == "o"]
    np.testing.assert_array_equal(ring.get_xydata(), [(900, 300), (100, 200)])
    assert not axes.texts
    with pytest.raises(ValueError, match="goals"):
        plot_frame(make_frame(), goals=(900, 300, 0, 0))
    (arrow,) = plot_frame(make_frame(), goals=(900, 300, np.pi / 2)).texts
    assert arrow.xy == pytest.approx((900, 300 + 80))  # its tip
    assert arrow.get_position() == pytest.approx((900, 300))


def test_path_up_to_a_step():
    trace = make_trace(60)[10:]
    axes = plot_frame(make_frame(), trace=trace, k=30)
    render(axes.figure, layout=False)
    (path,) = lines(axes, style.TRUE)
    np.testing.assert_array_equal(path.get_xydata(), trace.pose_true[:21, :2])
    (path,) = lines(plot_frame(make_frame(), trace=trace), style.TRUE)
    assert len(path.get_xydata()) == 50
    assert axes.get_xlim() == (-0.5, 1199.5)
    for step in (9, 60):
        with pytest.raises(ValueError, match=rf"^k must .*10..59.*{step}"):
            plot_frame(make_frame(), trace=trace, k=step)
    with pytest.raises(ValueError, match="k requires a trace"):
        plot_frame(make_frame(), k=3)


def test_a_camera_at_an_angle_is_shown_in_its_own_pixels():
    frame = make_frame(AT_AN_ANGLE, marker=(30, 10))
    measurement = robsim.Measurement((*AT_AN_ANGLE.to_world((20, 10)), 0.0))
    # Never seen: there is no measured place to map.
    trace = make_trace(seen=np.zeros(60, dtype=bool))
    axes = plot_frame(frame, blobs=blobs_of(frame), measurement=measurement, trace=trace)
    render(axes.figure, layout=False)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("u (pixels)", "v (pixels)")
    assert axes.get_ylim() == (39.5, -0.5)
    np.testing.assert_allclose(axes.patches[0].get_xy().max(axis=0), (31.5, 11.5))
    np.testing.assert_allclose(lines(axes, style.MEASURED)[0].get_xydata()[0], (20, 10))
    (path,) = lines(axes, style.TRUE)
    np.testing.assert_allclose(path.get_xydata(), AT_AN_ANGLE.to_pixel(trace.pose_true[:, :2]))


def test_frame_of_a_camera_from_the_side_shows_the_path_of_a_run_without_truth():
    image = robsim.Simulation(seed=1, resolution=(400, 400)).frame.image
    pixels, positions = [(0, 0), (399, 0), (390, 399), (5, 399)], [(0, 0), (9, 0), (9, 9), (0, 9)]
    plane_map = robsim.vision.PlaneMap.from_points(pixels, 133 * np.array(positions))
    experiment = robsim.Experiment([robsim.Frame(image, plane_map=plane_map)])
    trace = experiment.run()
    assert trace.seen.all()
    lines = plot_frame(experiment.frame, trace=trace).lines
    measured = next(line for line in lines if line.get_label() == "measured path")
    position = trace.pose_measured[0, :2]
    np.testing.assert_allclose(measured.get_xydata()[0], plane_map.to_pixel(position))


def test_the_parameters_say_how_well_they_are_excited():
    def shown(controller):
        options = {"boundary": "unlimited", "estimate_parameters": True, "seed": 1}
        trace = robsim.Simulation(control=controller, **options).run(300)
        return [
            text
            for axes in plot_parameters(trace).axes
            for text in written(axes)
            if "excited" in text
        ]

    assert shown(robsim.Spin()).count("not excited") > 8
    assert "not excited" not in shown(robsim.DriveAround())


def test_traces_are_drawn_into_given_axes():
    trace = make_trace()
    errors = ["dx", "dy", "dheading"]
    names = ["x", "y", "heading", "path", *errors, *(f"{name} bins" for name in errors)]
    given = Figure().subplot_mosaic([names])
    assert plot_traces(trace, axes=given) is given["x"].figure
    assert all(panel.has_data() for panel in given.values())
    assert given["x"].get_legend()
    with pytest.raises(ValueError, match=r"axes .*dheading, dx"):
        plot_traces(trace, axes={name: given[name] for name in names if name not in errors[::2]})


def test_before_a_run_there_is_nothing_to_draw():
    sim = robsim.Simulation(seed=1, measure=True, estimate_parameters=True)
    for plot in (plot_traces, plot_parameters, robsim.plotting.plot_ellipses):
        with pytest.raises(ValueError, match="no steps"):
            plot(sim.trace)
    assert plot_frame(make_frame(), trace=sim.trace).images
