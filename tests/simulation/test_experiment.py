"""The robot half on frames that come from elsewhere."""

import sys

import numpy as np
import pytest

import robsim


@pytest.fixture(scope="module")
def run():
    """Return a simulated run: its frames and its trace."""
    sim = robsim.Simulation(
        measure=True,
        headings=None,
        resolution=(600, 600),
        control=robsim.DriveAround(),
        seed=3,
    )
    frames = [sim.step().frame for _ in range(20)]
    return frames, sim.trace


def test_the_same_frames_give_the_same_measurements(run):
    frames, simulated = run
    trace = robsim.Experiment(frames).run()
    np.testing.assert_array_equal(trace.pose_measured, simulated.pose_measured)
    np.testing.assert_array_equal(trace.pose_held, simulated.pose_held)
    for color, centroids in simulated.blobs.items():
        np.testing.assert_array_equal(trace.blobs[color], centroids)


def test_the_truth_is_not_known(run, tmp_path):
    trace = robsim.Experiment(run[0]).run()
    assert trace.info.boundary == "recorded"
    assert np.isnan(trace.pose_true).all()
    assert np.isnan(trace.u).all()
    assert not trace.bounced.any()
    assert np.isnan(np.array(trace.info.theta_true)).all()
    assert not {"x_true", "u1", "bounced"} & set(trace.names)
    with pytest.raises(robsim.trace.NotRecordedError, match=r"\bu\b.*Replay"):
        robsim.batch_estimate(trace)
    trace.save(tmp_path / "trace.npz")
    again = robsim.Trace.load(tmp_path / "trace.npz")
    np.testing.assert_array_equal(again.pose_measured, trace.pose_measured)
    assert again.info.boundary == "recorded"


def test_a_run_goes_on_where_the_one_before_ended_and_ends_with_the_frames(run):
    frames, simulated = run
    sim = robsim.Experiment(frames)
    assert len(sim.run(5)) == 5
    assert sim.step().k == 5
    with pytest.warns(UserWarning, match="14 of 100 steps"):
        assert len(sim.run(100)) == 20
    with pytest.raises(EOFError):
        sim.run(1)
    assert len(sim.run()) == 20
    with pytest.raises(EOFError):
        sim.step()
    sim.reset()
    np.testing.assert_array_equal(sim.run().pose_measured, simulated.pose_measured)


def test_progress_and_no_frames_at_all(run, capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    assert len(robsim.Experiment(run[0]).run(progress="look")) == 20
    assert "look" in capsys.readouterr().err
    sim = robsim.Experiment([])
    with pytest.warns(UserWarning, match="no frame"):
        assert len(sim.run()) == 0
    with pytest.raises(RuntimeError, match="no frame"):
        _ = sim.frame


def camera():
    """A generator of frames."""
    yield None


@pytest.mark.parametrize(
    ("frames", "options", "error", "told"),
    [
        (camera, {}, TypeError, r"frames=camera\(\)"),
        (robsim.Frame(np.zeros((4, 4, 3), np.uint8)), {}, TypeError, r"frames.*\[frame\]"),
        (np.zeros((4, 4, 3), np.uint8), {}, TypeError, "frames.*robsim.Frame"),
        ("run.mkv", {}, TypeError, r"robsim.Recording\('run.mkv'\)"),
        ([None, np.zeros((4, 4, 3), np.uint8)], {}, TypeError, "frames.*at step 1"),
        ([], {"estimate_parameters": True}, ValueError, "estimate_parameters.*inputs"),
        ([], {"send": 3}, TypeError, "send"),
        ([], {"frame_timeout": 0}, ValueError, "frame_timeout"),
        ([], {"area": (0, 5)}, ValueError, "area"),
        ([], {"noise": robsim.GaussianNoise(5)}, TypeError, "'noise'"),
    ],
)
def test_wrong_use(frames, options, error, told):
    with pytest.raises(error, match=told):
        robsim.Experiment(frames, **options).run()


@pytest.mark.long
def test_parameters_can_be_estimated_when_the_inputs_are_known():
    options = {
        "measure": True,
        "resolution": (600, 600),
        "boundary": "unlimited",
        "control": robsim.DriveAround(),
        "seed": 3,
    }
    sim = robsim.Simulation(**options)
    frames = [sim.step().frame for _ in range(20)]
    control = robsim.Replay(sim.trace.u)
    again = robsim.Experiment(frames, control=control, estimate_parameters=True).run()
    expected = robsim.Simulation(
        **options, estimate_parameters=True, identify_from="measurement"
    ).run(20)
    np.testing.assert_array_equal(again.parameters, expected.parameters)
    assert np.isfinite(again.parameters[-1]).all()


@pytest.mark.long
def test_a_model_with_another_time_step_than_the_frames_is_refused(run, tmp_path):
    robsim.vision.save_video(tmp_path / "run.mkv", run[0][:3], fps=10)
    recording = robsim.Recording(tmp_path / "run.mkv", area=(1200, 1200))

    def define_model():
        return robsim.RobotModel(robsim.RobotParameters(dt=dt))

    dt = 0.2
    sim = robsim.Experiment(recording, define_model=define_model)
    with pytest.raises(ValueError, match=r"dt .*0\.2 s.*0\.1 s"):
        sim.run()
    dt = 0.1
    sim.reset()
    assert sim.run().info.dt == 0.1


def timed(frames, times):
    image = frames[0].image
    return [
        robsim.Frame(image, t=t, index=i, plane_map=frames[0].plane_map)
        for i, t in enumerate(times)
    ]


@pytest.mark.long
def test_the_frames_own_times_are_those_of_the_steps_and_of_the_trace(run, tmp_path):
    seen = []

    def estimate_state(step):
        seen.append((step.t, step.dt))
        return robsim.Estimate((0, 0, 0), np.eye(3))

    sim = robsim.Experiment(timed(run[0], (0.1, 0.8, 1.5, 2.5)), estimate_state=estimate_state)
    trace = sim.run()
    np.testing.assert_allclose(seen, [(0.1, 0.2), (0.8, 0.7), (1.5, 0.7), (2.5, 1.0)])
    np.testing.assert_array_equal(trace.t, [0.1, 0.8, 1.5, 2.5])
    np.testing.assert_array_equal(trace["t"][1:3], trace[1:3].t)
    trace.save(tmp_path / "trace.npz")
    np.testing.assert_array_equal(robsim.Trace.load(tmp_path / "trace.npz").t, trace.t)
    assert trace.to_pandas()["t"].tolist() == trace.t.tolist()
    # Those that are dt apart are so to the last digit.
    seen.clear()
    frames = timed(run[0], [0.2 * k for k in range(8)])
    robsim.Experiment(frames, estimate_state=estimate_state).run()
    assert [dt for _, dt in seen] == [0.2] * 8


def test_times_that_are_in_no_order_are_refused_and_the_steps_before_are_kept(run):
    trace = robsim.Experiment(timed(run[0], (-0.5, 0.0, 0.7))).run()
    np.testing.assert_array_equal(trace.t, [-0.5, 0, 0.7])
    for times, step in (((0.5, 1.0, 0.9), 2), ((0.0, 0.0), 1), ((5.0, None), 1)):
        sim = robsim.Experiment(timed(run[0], times))
        with pytest.raises(ValueError, match=rf"\bstep {step}\b"):
            sim.run()
        np.testing.assert_array_equal(sim.trace.t, times[:step])


def test_a_frame_before_the_guessed_time_of_a_step_without_one_is_refused(run):
    first, last = timed(run[0], (0.5, 0.6))
    sim = robsim.Experiment([first, None, last])
    with pytest.raises(ValueError, match=r"t = 0\.7\d* s.*Observation"):
        sim.run()
    np.testing.assert_allclose(sim.trace.t, [0.5, 0.7])


def test_frames_that_come_only_once_cannot_be_reset(run):
    sim = robsim.Experiment(iter(run[0][:3]))
    sim.reset()
    assert sim.step_stage() == "world"
    with pytest.raises(RuntimeError, match="once"):
        sim.reset()
    assert len(sim.run()) == 3
    with pytest.raises(RuntimeError, match="once"):
        sim.reset()
    assert len(sim.trace) == 3


def test_a_step_without_a_frame_is_not_measured(run):
    frames, simulated = run
    seen = []

    def estimate_state(step):
        seen.append((step.frame, step.measurement, step.blobs))
        return robsim.Estimate((0, 0, 0), np.eye(3))

    measured = []

    def measure(step):
        measured.append(step.k)
        return robsim.locate(step.blobs, step.markers, image=step.frame)

    given = [frames[0], None, robsim.Observation(None, t=0.4), frames[3]]
    sim = robsim.Experiment(given, measure=measure, estimate_state=estimate_state)
    trace = sim.run()
    assert measured == [0, 3]
    assert seen[1] == seen[2] == (None, None, {"blue": [], "red": []})
    assert seen[3][0].index == 3
    np.testing.assert_allclose(trace.t, [0, 0.2, 0.4, 0.6])
    np.testing.assert_array_equal(trace.seen, [True, False, False, True])
    np.testing.assert_array_equal(trace.pose_held[1:3], trace.pose_measured[[0, 0]])
    np.testing.assert_array_equal(trace.pose_measured[3], simulated.pose_measured[3])
    for centroids in trace.blobs.values():
        np.testing.assert_array_equal(np.isnan(centroids).all(axis=(1, 2)), [0, 1, 1, 0])


def test_frames_of_another_size_are_refused_and_the_run_goes_on_behind_them(run):
    frames = run[0]
    small = robsim.Frame(frames[0].image[:40, :50])
    sim = robsim.Experiment([frames[0], None, small, frames[3]])
    with pytest.raises(ValueError, match=r"step 2 is 50 x 40 px.*600 x 600 px"):
        sim.run()
    trace = sim.run()
    np.testing.assert_array_equal(trace.pose_measured[2], run[1].pose_measured[3])
    lower = robsim.Frame(frames[0].image[:599])
    with pytest.raises(ValueError, match="step 1 is 600 x 599 px"):
        robsim.Experiment([frames[0], lower]).run()


def test_frames_of_another_size_than_the_area_without_a_map_are_told_once(run):
    small = robsim.Frame(run[0][0].image[:40, :50])
    sim = robsim.Experiment([small, small])
    with pytest.warns(UserWarning, match=r"50 x 40 px.*PlaneMap\.scaled.*area=\(50, 40\)") as told:
        assert not sim.run().seen.any()
    assert [one.filename for one in told] == [__file__]
    robsim.Experiment([small], area=(50, 40)).run()
    lens = robsim.vision.Intrinsics([[40, 0, 25], [0, 40, 20], [0, 0, 1]])
    mapped = robsim.vision.PlaneMap(intrinsics=lens)
    robsim.Experiment([robsim.Frame(small.image, plane_map=mapped)]).run()


def test_a_part_of_the_frames_has_times(run):
    untimed, late = timed(run[0], (None, 0.7))
    observe = robsim.Observation
    for frames, times in (
        ([untimed] * 3, [0, 0.2, 0.4]),
        ([untimed, late], [0, 0.7]),
        ([None, late, None, observe(t=1.1)], [0, 0.7, 0.9, 1.1]),  # no frame needs no time
        ([observe(late, t=0.1), observe(t=0.3), late], [0.1, 0.3, 0.7]),
    ):
        np.testing.assert_allclose(robsim.Experiment(frames).run().t, times)
    sim = robsim.Experiment([late, observe(untimed), observe(untimed, t=0.9)])
    with pytest.raises(ValueError, match="step 1 has none"):
        sim.run()
    np.testing.assert_allclose(sim.run().t, [0.7, 0.9])


def test_a_reset_repeats_the_run_with_its_own_inputs(run):
    sim = robsim.Experiment(run[0], control=robsim.DriveAround(), seed=1)
    u = sim.run(5).u
    sim.reset()
    np.testing.assert_array_equal(sim.run(5).u, u)
    sim.reset(seed=2)
    assert not np.array_equal(sim.run(5).u, u)


def test_a_recording_is_no_live_camera():
    for source in (0, "rtsp://camera/1", "/dev/video0"):
        with pytest.raises(ValueError, match=r"source .*live camera"):
            robsim.Recording(source)
