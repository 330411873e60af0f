"""What a measurement says of itself, and what a trace keeps of it."""

import copy

import numpy as np
import pytest

import robsim
from refusals import refuses
from robsim.vision import Blob, MarkerLayout, detect

COLORS = robsim.load_colors()
MARKERS = robsim.load_robot("lab").marker_layout()


def simulation(**options):
    options = {"resolution": (480, 480), "measure": True, "seed": 1} | options
    return robsim.Simulation(control=robsim.DriveAround(), **options)


def located(frame, markers=MARKERS, **options):
    blobs = robsim.find_blobs(frame, COLORS, markers=markers)
    return robsim.locate(blobs, markers, image=frame, **options)


def test_it_has_covariance_misfit_signal_to_noise_and_pair():
    sim = simulation(headings=None, noise=robsim.GaussianNoise(10))
    step = sim.step()
    measurement = step.measurement
    assert measurement == located(step.frame) == step.detection.measurement
    assert measurement.covariance.shape == (3, 3)
    assert (np.linalg.eigvalsh(measurement.covariance) > 0).all()
    assert 1 <= measurement.misfit < 1.5
    assert 15 < measurement.signal_to_noise < 25
    assert measurement.seen == step.detection.seen
    assert measurement.seen["right"] in step.blobs["red"]
    assert copy.deepcopy(measurement) == measurement
    assert hash(copy.copy(measurement)) == hash(measurement)


def test_what_is_not_known_is_none():
    plain = robsim.Measurement((1, 2, 3))
    assert (plain.covariance, plain.misfit, plain.signal_to_noise, plain.seen) == 4 * (None,)
    assert eval(repr(plain), {"Measurement": robsim.Measurement}) == plain
    blob = Blob("red", area=3, centroid=(1, 2), bounding_box=(0, 0, 3, 3))
    known = {"misfit": 1.5, "signal_to_noise": 9, "seen": {"right": blob, "left": blob}}
    measurement = robsim.Measurement((1, 2, 3), covariance=np.eye(3), **known)
    np.testing.assert_array_equal(measurement.covariance, np.eye(3))
    assert not measurement.covariance.flags.writeable
    assert {name: getattr(measurement, name) for name in known} == known


def test_drawn_headings_and_whole_pixels_are_part_of_the_covariance():
    drawn, exact = (simulation(headings=headings).step() for headings in (36, None))
    assert (drawn.frame.headings, exact.frame.headings) == (36, None)
    pixel = 1200 / 480
    shares = np.diag(drawn.measurement.covariance - exact.measurement.covariance)
    expected = (pixel**2 / 12, pixel**2 / 12, (2 * np.pi / 36) ** 2 / 12)
    np.testing.assert_allclose(shares, expected, rtol=0.02)


def test_the_errors_are_as_large_as_the_covariance_says():
    sim = simulation(headings=None, noise=robsim.GaussianNoise(10), boundary="unlimited", seed=7)
    trace = sim.run(120)
    error, covariance = trace.error[trace.seen], trace.covariance_measured[trace.seen]
    squared = robsim.estimation.nees(error, covariance)
    # the mean of chi-square of 3 degrees of freedom: 3 +- 4 standard deviations
    assert abs(np.mean(squared) - 3) < 4 * np.sqrt(6 / len(squared))


@pytest.mark.parametrize("resolution", [(480, 480), (1200, 1200)])
def test_a_clean_pose_is_exact_to_a_few_hundredths_of_a_frame_pixel(resolution):
    trace = simulation(headings=None, resolution=resolution).run(60)
    tracking, frame_px = trace.tracking(), 1200 / resolution[0]
    assert tracking.rmse_xy < 0.035 * frame_px  # the blobs' centroids: 0.05 to 0.08
    assert np.deg2rad(tracking.rmse_heading_deg) < 0.035 * frame_px / MARKERS.distance


def test_without_outlines_pixels_are_weighted_by_their_colour():
    places = MarkerLayout.from_positions(MARKERS.positions, areas=MARKERS.areas)
    assert places.polygons is None
    assert MARKERS.polygons["right"].shape == (24, 2)
    sim = simulation(headings=None)
    errors, squared = [], []
    for _ in range(20):
        step = sim.step()
        blobs = robsim.find_blobs(step.frame, COLORS, markers=places)
        weighted = robsim.locate(blobs, places, image=step.frame)
        assert weighted.misfit is None
        counted = robsim.locate(blobs, places, step.frame.plane_map)
        truth = sim.trace.pose_true[-1]
        squared.append(robsim.estimation.nees(weighted.pose - truth, weighted.covariance))
        errors.append([np.linalg.norm((one.pose - truth)[:2]) for one in (weighted, counted)])
    weighted, counted = np.sqrt(np.mean(np.square(errors), axis=0))
    assert weighted < 0.6 * counted
    assert 0.5 < np.mean(squared) < 9


def test_the_plane_map_is_that_of_the_frame():
    frame = simulation().frame
    blobs = robsim.find_blobs(frame, COLORS, markers=MARKERS)
    assert robsim.locate(blobs, MARKERS, image=frame) == located(frame, plane_map=frame.plane_map)
    # pixels alone have none
    assert detect(blobs, MARKERS, image=frame.image).measurement is None


def test_what_does_not_stand_out_of_the_noise_is_no_measurement():
    sim = simulation(resolution=(320, 320), headings=None, noise=robsim.GaussianNoise(45), seed=3)
    with pytest.warns(robsim.vision.SmallMarkersWarning, match=r"7\.8 px"):
        trace = sim.run(60)
    reasons = trace.missed_reasons
    assert (reasons[trace.seen] == "").all()
    assert (reasons[~trace.seen] != "").all()
    assert "noise" in reasons
    assert (trace.signal_to_noise[trace.seen] >= 3).all()
    missed = {one.reason: one for one in sim.missed_detections}["noise"]
    assert missed.steps == np.sum(reasons == "noise")
    assert "signal to noise 2." in missed.first.explanation


def test_the_trace_keeps_it(tmp_path):
    sim = simulation(noise=robsim.GaussianNoise(10))
    trace = sim.run(5)
    last = sim.last_step.measurement
    np.testing.assert_array_equal(trace.covariance_measured[-1], last.covariance)
    assert (trace.misfit[-1], trace.signal_to_noise[-1]) == (last.misfit, last.signal_to_noise)
    assert trace.units["cov_measured_x_heading"] == "px rad"
    assert trace.in_unit("mm", mm_per_px=2).covariance_measured[0, 0, 0] == pytest.approx(
        4 * trace.covariance_measured[0, 0, 0]
    )
    trace.save(tmp_path / "run.npz")
    assert robsim.Trace.load(tmp_path / "run.npz") == trace


def test_a_measure_that_says_only_the_pose_records_no_more():
    trace = simulation(measure=lambda step: (1, 2, 3)).run(3)
    assert np.isnan(trace.covariance_measured).all()
    assert "misfit" not in trace.names
    assert (trace.missed_reasons == "").all()
    with pytest.raises(robsim.trace.NotRecordedError, match="covariance_measured"):
        trace.require("covariance_measured")


@pytest.mark.long
def test_reports_and_figures_show_what_measurements_say():
    trace = simulation(headings=None, noise=robsim.GaussianNoise(10), seed=2).run(30)
    report = robsim.pose_errors(trace, of="measurement")
    expected = np.sqrt(np.diagonal(trace.covariance_measured, axis1=1, axis2=2))
    np.testing.assert_allclose(report.reported_sd[0], expected)
    assert robsim.plot_traces(trace).axes[4].collections
    # a measure of one's own says nothing, and no band is drawn
    plain = simulation(measure=lambda step: step.detection or (600, 600, 0)).run(3)
    assert robsim.pose_errors(plain, of="measurement").reported_sd is None
    assert not robsim.plot_traces(plain).axes[4].collections


def test_outlines_must_be_those_of_the_markers():
    right, left = MARKERS.polygons["right"], MARKERS.polygons["left"]
    for polygons, words in (
        ({"right": right}, "polygons"),
        ({"right": right + 3, "left": left}, r"right marker.*centroid.*4\.24"),
    ):
        with pytest.raises(ValueError, match=words):
            MarkerLayout.from_positions(MARKERS.positions, polygons=polygons)


def test_what_is_no_covariance_is_refused():
    for covariance in (
        np.eye(2),
        [[1, 2, 0], [0, 1, 0], [0, 0, 1]],
        [[1, 5, 0], [5, 1, 0], [0, 0, 1]],
        # each pair is in order, but not the three: x - y - heading has a variance below 0
        [[1, 0.9, 0.9], [0.9, 1, -0.9], [0.9, -0.9, 1]],
        np.full((3, 3), np.nan),
    ):
        refuses("covariance", robsim.Measurement, (1, 2, 3), covariance=covariance)
    for figure in ("misfit", "signal_to_noise"):
        for value in (-1, np.inf, np.nan):
            refuses(figure, robsim.Measurement, (1, 2, 3), **{figure: value})


@pytest.mark.long
def test_huge_figures_break_neither_filters_nor_reports_nor_plots():
    def measure(step):
        return robsim.Measurement(
            (600 + step.k, 600, 0.1), covariance=1e300 * np.eye(3), misfit=1e300,
            signal_to_noise=1e300,
        )  # fmt: skip

    for reference in (
        robsim.estimation.reference.ExtendedKalmanFilter,
        robsim.estimation.reference.UnscentedKalmanFilter,
        robsim.estimation.reference.ParticleFilter,
    ):
        sim = simulation(measure=measure, estimate_state=reference(), resolution=(240, 240))
        trace = sim.run(3)
        assert np.isfinite(trace.pose_estimated).all()
        assert str(trace.tracking())
    robsim.plotting.plot_errors(robsim.pose_errors(trace))
    robsim.plotting.plot_traces(trace)


def test_the_batch_table_says_what_its_standard_errors_do_not_cover():
    trace = simulation(headings=None, identify_from="measurement").run(100)
    tracked = robsim.batch_estimate(trace, method="output_error")
    assert any("neighbouring errors are similar" in remark for remark in tracked.remarks)
    true = robsim.batch_estimate(trace, identify_from="truth", method="output_error")
    assert not any("neighbouring errors are similar" in remark for remark in true.remarks)


def test_covariances_of_any_size_and_of_less_than_full_rank():
    for scale in (0, 1e-300, 1, 1e300):
        for covariance in (np.eye(3), np.ones((3, 3)), np.outer((1, -2, 3), (1, -2, 3))):
            measurement = robsim.Measurement((1, 2, 3), covariance=scale * covariance)
            np.testing.assert_array_equal(measurement.covariance, scale * covariance)
