"""A trace in px, mm, cm and m: all that is computed from it is the same, in that unit."""

import numpy as np
import pytest

import robsim
from robsim.estimation import parameter_bounds, parameter_convergence
from robsim.estimation.reference import ConstantVelocityKalmanFilter
from robsim.plotting import annotated_frames
from robsim.vision import Calibration, PlaneMap, save_image

MM_PER_PX = 2.5
LENGTHS = {"px": 1.0, "mm": MM_PER_PX, "m": MM_PER_PX / 1000}
THETA = np.array(
    [[1.0, 1.0, 2.0, 2.0, 2.0], [1.0, 1.0, 2.0, 2.0, 2.0], [1.0, 1.0, 1.0, 1.0, 1.0]]
)  # 2 where a parameter has a length in it


@pytest.fixture(scope="module")
def simulation():
    sim = robsim.Simulation(
        area=(400, 300),
        seed=1,
        measure=True,
        control=robsim.DriveAround(),
        estimate_parameters=True,
        identify_from="measurement",
        estimate_state=ConstantVelocityKalmanFilter(),
    )
    sim.run(150)
    return sim


@pytest.fixture(scope="module", params=["mm", "m"])
def converted(request, simulation):
    return simulation.trace.in_unit(request.param, mm_per_px=MM_PER_PX)


def of_parameters(length):
    return np.where(THETA == 2, length, 1.0)


def test_poses_covariances_and_blobs_are_lengths(simulation, converted):
    trace, length = simulation.trace, LENGTHS[converted.info.unit]
    pose = np.array([length, length, 1.0])
    for name in ("pose_true", "pose_measured", "pose_held", "pose_estimated", "error"):
        np.testing.assert_allclose(getattr(converted, name), getattr(trace, name) * pose)
    covariance = trace.covariance * np.outer(pose, pose)
    np.testing.assert_allclose(converted.covariance, covariance)
    np.testing.assert_allclose(converted.blobs["red"], trace.blobs["red"] * length)
    for same in ("u", "t", "k", "seen", "bounced", "is_false", "state"):
        np.testing.assert_array_equal(getattr(converted, same), getattr(trace, same))
    assert converted.info.area == trace.info.area


def test_units_tell_of_it(converted, tmp_path):
    unit = converted.info.unit
    units = converted.units
    assert units["x_true"] == units["d1X"] == units["red1_x"] == unit
    assert units["b1X"] == f"{unit}/V"
    assert units["cov_x_heading"] == f"{unit} rad"
    assert units["heading_true"] == "rad"
    assert units["standard_error_unscaled_a1X"] == f"1/{unit}"
    assert converted.to_pandas().attrs["units"] == units
    assert unit in str(converted.summary()).split("pose_true")[1].splitlines()[0]


def test_a_converted_trace_is_saved_and_converted_back(simulation, converted, tmp_path):
    converted.save(tmp_path / "run.npz")
    loaded = robsim.Trace.load(tmp_path / "run.npz")
    assert loaded == converted
    assert (loaded.info.unit, loaded.info.mm_per_px) == (converted.info.unit, MM_PER_PX)
    back = loaded.in_unit("px")
    np.testing.assert_allclose(back.pose_true, simulation.trace.pose_true, rtol=1e-15)
    np.testing.assert_allclose(back.info.theta_true, simulation.trace.info.theta_true)


@pytest.mark.long
@pytest.mark.parametrize(
    ("method", "source"),
    [
        ("least_squares", "truth"),
        ("instrumental_variables", "measurement"),
        ("output_error", "measurement"),
    ],
)
def test_batch_estimates_are_the_same(simulation, converted, method, source):
    one = robsim.batch_estimate(simulation.trace, method=method, identify_from=source)
    other = robsim.batch_estimate(converted, method=method, identify_from=source)
    factor = of_parameters(LENGTHS[other.unit])
    for name in ("theta_true", "batch", "online", "standard_errors"):
        found, expected = getattr(other, name) / factor, getattr(one, name)
        np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9)
    assert other.is_model_exact
    np.testing.assert_array_equal(other.identifiability.verdicts, one.identifiability.verdicts)
    assert f"lengths in {other.unit}" in other.title
    assert "lengths in" not in one.title


def test_reports_say_the_unit(simulation, converted):
    trace, unit = simulation.trace, converted.info.unit
    length = LENGTHS[unit]
    tracking = converted.tracking()
    assert tracking.rmse_xy == pytest.approx(trace.tracking().rmse_xy * length)
    assert tracking.false_poses == trace.tracking().false_poses
    assert f"rmse of the position ({unit})" in str(tracking)
    errors = robsim.pose_errors(converted)
    assert errors.units == (unit, unit, "rad")
    np.testing.assert_allclose(errors.rmse[:2], robsim.pose_errors(trace).rmse[:2] * length)
    consistency = robsim.pose_consistency(converted)
    assert consistency.verdict == robsim.pose_consistency(trace).verdict
    sigma = np.array([1.0, 1.0, 0.1])
    bound = parameter_bounds(converted, sigma=sigma * (length, length, 1))[-1]
    np.testing.assert_allclose(
        bound / of_parameters(length), parameter_bounds(trace, sigma=sigma)[-1]
    )
    times = parameter_convergence(converted, tolerance=0.5, offset_tolerance=0.1).time
    expected = parameter_convergence(trace, tolerance=0.5, offset_tolerance=0.1).time
    np.testing.assert_array_equal(times, expected)


def test_paths_are_scored_in_that_unit(simulation, converted):
    waypoints = [(220, 160), (300, 200)]
    one = robsim.control.score_path(simulation.trace, waypoints)
    other = robsim.control.score_path(converted, waypoints)
    length = LENGTHS[converted.info.unit]
    assert (other.reached, other.verdict) == (one.reached, one.verdict)
    assert other.final_distance == pytest.approx(one.final_distance * length)
    assert f"cross-track error, rmse ({converted.info.unit})" in str(other)


@pytest.mark.long
def test_figures_are_labelled(converted):
    unit, length = converted.info.unit, LENGTHS[converted.info.unit]
    figure = robsim.plot_traces(converted)
    labels = {axes.get_ylabel(): axes for axes in figure.axes}
    assert {f"x ({unit})", f"y ({unit})", f"x error\n({unit})"} < labels.keys()
    plan = next(axes for axes in figure.axes if axes.get_xlabel() == f"x ({unit})")
    np.testing.assert_allclose(plan.get_xlim(), (-0.5 * length, 399.5 * length))
    assert f" {unit} and " in figure.get_suptitle()
    axes = robsim.plot_batch(robsim.batch_estimate(converted))
    assert f"b1X ({unit}/V)" in [label.get_text() for label in axes.get_yticklabels()]
    assert f"100 % = 1 {unit}" in axes.get_xlabel()
    assert f"100 % = 1 {unit}" in robsim.plot_parameters(converted).get_suptitle()
    assert robsim.plotting.plot_ellipses(converted).get_xlabel() == f"x ({unit})"


def test_pictures_show_the_same(simulation, converted):
    """What is drawn on a frame lies there, whatever the unit; the caption has the other one."""
    frame = simulation.frame
    of_px, of_other = (robsim.plot_frame(frame, trace=t) for t in (simulation.trace, converted))
    for one, other in zip(of_px.lines, of_other.lines, strict=True):
        np.testing.assert_allclose(one.get_xydata(), other.get_xydata(), rtol=1e-12)
    caption = 60  # px, at the lower edge
    pictures = [
        next(annotated_frames([simulation.render_step(149)], t[-1:], simulation=simulation))
        for t in (simulation.trace, converted)
    ]
    np.testing.assert_array_equal(*(picture[:-caption] for picture in pictures))
    assert (pictures[0] != pictures[1]).any()


def test_a_calibrated_experiment_knows_the_length_of_a_px(simulation, tmp_path):
    calibration = Calibration(
        size=(400, 300), floor=PlaneMap(np.eye(3)), area=(400, 300), mm_per_px=MM_PER_PX
    )
    (tmp_path / "frames").mkdir()
    for k in range(5):
        save_image(tmp_path / "frames" / f"{k}.png", simulation.render_step(k).image)
    frames = robsim.Recording(tmp_path / "frames", calibration=calibration)
    experiment = robsim.Experiment(frames, record=tmp_path / "session")
    trace = experiment.run()
    assert trace.info.mm_per_px == MM_PER_PX
    assert trace.in_unit("mm").pose_measured[0, 0] == MM_PER_PX * trace.pose_measured[0, 0]
    session = robsim.trace.Session(tmp_path / "session")
    assert session.mm_per_px == session.trace.info.mm_per_px == MM_PER_PX
    again = robsim.Experiment(session).run()
    assert again.info.mm_per_px == MM_PER_PX


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda t: t.in_unit("mm"), "unit"),
        (lambda t: t.in_unit("inch"), "unit"),
        (lambda t: t.in_unit("mm", mm_per_px=0), "mm_per_px"),
        (lambda t: t.in_unit("mm", mm_per_px=2).in_unit("mm", mm_per_px=3), "mm_per_px must be 2"),
        (lambda t: robsim.pose_errors([t, t.in_unit("mm", mm_per_px=2)]), "traces .*mm, px"),
    ],
)
def test_wrong_units(simulation, change, name):
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        change(simulation.trace)


def test_a_cm_is_ten_mm(simulation):
    cm = simulation.trace.in_unit("cm", mm_per_px=MM_PER_PX)
    np.testing.assert_allclose(cm.pose_true[:, 0], simulation.trace.pose_true[:, 0] * 0.25)
