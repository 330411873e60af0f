"""The robot half on frames that come from elsewhere."""

import math
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


def test_frames_may_have_features_that_are_none_of_a_camera(run, tmp_path):
    class Corners(list):
        features = ("corner", 3)

    trace = robsim.Experiment(Corners(run[0]), record=tmp_path / "session").run()
    assert len(trace) == 20


def test_the_truth_is_not_known(run, tmp_path):
    trace = robsim.Experiment(run[0]).run()
    assert trace.info.boundary == "recorded"
    assert np.isnan(trace.pose_true).all()
    assert np.isnan(trace.u).all()
    assert not trace.bounced.any()
    assert np.isnan(np.array(trace.info.theta_true)).all()
    assert not {"x_true", "u1", "bounced"} & set(trace.names)
    trace.save(tmp_path / "trace.npz")
    again = robsim.Trace.load(tmp_path / "trace.npz")
    np.testing.assert_array_equal(again.pose_measured, trace.pose_measured)
    assert again.info.boundary == "recorded"


def test_callbacks_get_what_they_get_in_a_simulation(run):
    frames, simulated = run
    seen = []

    def estimate_state(step):
        seen.append((step.k, step.t, step.frame.index, step.measurement.pose[0]))
        return robsim.Estimate(step.measurement.pose, np.eye(3))

    sim = robsim.Experiment(frames, estimate_state=estimate_state, control=lambda step: (0.1, 0.2))
    trace = sim.run()
    assert [k for k, *_ in seen] == list(range(20))
    assert [t for _, t, *_ in seen] == pytest.approx([0.2 * k for k in range(20)])
    np.testing.assert_array_equal([x for *_, x in seen], simulated.pose_measured[:, 0])
    np.testing.assert_array_equal(trace.pose_estimated, simulated.pose_measured)
    np.testing.assert_array_equal(trace.u, np.tile((0.1, 0.2), (20, 1)))


def test_a_run_goes_on_where_the_one_before_ended_and_ends_with_the_frames(run):
    frames, simulated = run
    sim = robsim.Experiment(frames)
    assert len(sim.run(5)) == 5
    assert sim.step().k == 5
    with pytest.warns(UserWarning, match="the frames ended after 14 of 100 steps"):
        assert len(sim.run(100)) == 20
    with pytest.raises(EOFError, match="there are no more frames"):
        sim.run(1)
    assert len(sim.run()) == 20
    with pytest.raises(EOFError, match="there are no more frames"):
        sim.step()
    sim.reset()
    np.testing.assert_array_equal(sim.run().pose_measured, simulated.pose_measured)


def test_an_error_of_the_source_ends_the_run_and_keeps_the_trace(run):
    def broken():
        yield from run[0][:7]
        raise ValueError("frame 7 is damaged")

    sim = robsim.Experiment(broken())
    with pytest.raises(ValueError, match="frame 7 is damaged"):
        sim.run()
    assert len(sim.trace) == 7
    assert sim.trace.seen.all()


def test_progress_and_no_frames_at_all(run, capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    assert len(robsim.Experiment(run[0]).run(progress="look")) == 20
    assert "look" in capsys.readouterr().err
    sim = robsim.Experiment([])
    with pytest.warns(UserWarning, match="frames gave no frame: there was nothing to run"):
        assert len(sim.run()) == 0
    with pytest.raises(RuntimeError, match="there is no frame yet"):
        _ = sim.frame


@pytest.mark.parametrize(
    ("frames", "options", "error", "message"),
    [
        (5, {}, TypeError, "frames must be an iterable of Frame"),
        ([], {"area": 0}, TypeError, "area must be .width, height. in px, got 0"),
        ([], {"stop_input": 3}, ValueError, "stop_input must be .u1, u2., finite"),
        ("run.mkv", {}, TypeError, "folder of images, give robsim.Recording\\('run.mkv'\\)"),
        (
            [np.zeros((4, 4, 3), np.uint8)],
            {},
            TypeError,
            r"frames must give Frame or Observation objects, or None, got a uint8 array of shape",
        ),
        ([], {"estimate_parameters": True}, ValueError, "estimate_parameters needs the inputs"),
        ([], {"send": 3}, TypeError, "send must be callable, got 3"),
        ([], {"send": print, "stop_input": (1,)}, ValueError, r"stop_input must be \(u1, u2\)"),
        ([], {"frame_timeout": 0}, ValueError, "frame_timeout must be above 0 .s., or inf"),
        ([], {"area": (0, 5)}, ValueError, "area must"),
    ],
)
def test_wrong_use(frames, options, error, message):
    with pytest.raises(error, match=message):
        robsim.Experiment(frames, **options).run()


def test_the_slots_of_the_world_half_are_not_there():
    experiment = robsim.Experiment([])
    with pytest.raises(
        AttributeError, match="Experiment has no slot 'evaluate_model': it is an op"
    ):
        experiment.evaluate_model = robsim.Unicycle()
    with pytest.raises(TypeError, match="Experiment has no option 'noise': it is an option of"):
        robsim.Experiment([], noise=robsim.GaussianNoise(5))


def test_a_simulated_world_needs_a_number_of_steps():
    with pytest.raises(TypeError, match="steps must be an int: a simulated world has no end"):
        robsim.Simulation().run()


@pytest.mark.long
def test_parameters_can_be_estimated_when_the_inputs_are_known():
    sim = robsim.Simulation(
        measure=True,
        resolution=(600, 600),
        boundary="unlimited",
        control=robsim.DriveAround(),
        seed=3,
    )
    frames = [sim.step().frame for _ in range(40)]
    u = sim.trace.u
    again = robsim.Experiment(
        frames, control=lambda step: u[step.k], estimate_parameters=True
    ).run()
    expected = robsim.Simulation(
        measure=True,
        resolution=(600, 600),
        boundary="unlimited",
        control=robsim.DriveAround(),
        seed=3,
        estimate_parameters=True,
        identify_from="measurement",
    ).run(40)
    np.testing.assert_array_equal(again.parameters, expected.parameters)
    assert math.isfinite(again.parameters[-1, 0, 0])


@pytest.mark.long
def test_a_model_with_another_time_step_than_the_frames_is_refused(run, tmp_path):
    robsim.imaging.save_video(tmp_path / "run.mkv", run[0][:3], fps=10)
    recording = robsim.Recording(tmp_path / "run.mkv", area=(1200, 1200))

    def define_model():
        return robsim.RobotModel(robsim.RobotParameters(dt=dt))

    dt = 0.2
    sim = robsim.Experiment(recording, define_model=define_model)
    with pytest.raises(ValueError, match=r"model's dt is 0\.2 s, but that of the frames is 0\.1 s"):
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


def test_the_frames_own_times_are_those_of_the_steps_and_of_the_trace(run, tmp_path):
    seen = []
    sim = robsim.Experiment(
        timed(run[0], (0.1, 0.8, 1.5, 2.5)),
        estimate_state=lambda step: seen.append((step.t, step.dt)) or estimate,
    )
    estimate = robsim.Estimate((0, 0, 0), np.eye(3))
    trace = sim.run()
    np.testing.assert_allclose(seen, [(0.1, 0.2), (0.8, 0.7), (1.5, 0.7), (2.5, 1.0)])
    np.testing.assert_array_equal(trace.t, [0.1, 0.8, 1.5, 2.5])
    np.testing.assert_array_equal(trace["t"][1:3], trace[1:3].t)
    trace.save(tmp_path / "trace.npz")
    np.testing.assert_array_equal(robsim.Trace.load(tmp_path / "trace.npz").t, trace.t)
    assert trace.to_pandas()["t"].tolist() == trace.t.tolist()


def test_frames_without_times_are_one_dt_apart(run):
    trace = robsim.Experiment(timed(run[0], (None, None, None))).run()
    np.testing.assert_allclose(trace.t, [0, 0.2, 0.4])


def test_zero_is_a_time_like_any_other(run):
    trace = robsim.Experiment(timed(run[0], (-0.5, 0.0, 0.7))).run()
    np.testing.assert_array_equal(trace.t, [-0.5, 0, 0.7])
    with pytest.raises(ValueError, match=r"that of step 1 is of t = 0 s"):
        robsim.Experiment(timed(run[0], (0.0, 0.0))).run()


def test_frames_in_another_order_are_refused_and_the_steps_before_are_kept(run):
    sim = robsim.Experiment(timed(run[0], (0.5, 1.0, 0.9)))
    with pytest.raises(ValueError, match=r"order of their times: that of step 2 is of t = 0\.9"):
        sim.run()
    np.testing.assert_array_equal(sim.trace.t, [0.5, 1.0])


def test_a_frame_before_the_guessed_time_of_a_step_without_one_is_refused(run):
    first, last = timed(run[0], (0.5, 0.6))
    sim = robsim.Experiment([first, None, last])
    with pytest.raises(ValueError, match=r"one before of t = 0\.7\d* s, for want of its own: give"):
        sim.run()
    np.testing.assert_allclose(sim.trace.t, [0.5, 0.7])


def test_frames_that_come_only_once_cannot_be_reset(run):
    sim = robsim.Experiment(iter(run[0][:3]))
    sim.reset()
    assert len(sim.run()) == 3
    with pytest.raises(RuntimeError, match="can be read only once: give a list or a Recording"):
        sim.reset()
    assert len(sim.trace) == 3


def test_frames_that_are_dt_apart_are_so_to_the_last_digit(run):
    seen = []
    sim = robsim.Experiment(
        timed(run[0], [0.2 * k for k in range(8)]),
        estimate_state=lambda step: seen.append(step.dt) or robsim.Estimate((0, 0, 0), np.eye(3)),
    )
    sim.run()
    assert seen == [0.2] * 8


def test_a_frame_without_a_time_after_later_ones_is_refused(run):
    sim = robsim.Experiment(timed(run[0], (5.0, None)))
    with pytest.raises(
        ValueError, match=r"must all have a time t, or none of them: that of step 1 has none"
    ):
        sim.run()


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


def test_a_time_that_is_observed_stands_before_that_of_the_frame(run):
    frame = timed(run[0], (7.0,))[0]
    observed = [robsim.Observation(frame, t=0.1), robsim.Observation(t=0.3), frame]
    seen = []
    sim = robsim.Experiment(
        observed,
        estimate_state=lambda step: seen.append(step.t) or robsim.Estimate((0, 0, 0), np.eye(3)),
    )
    np.testing.assert_array_equal(sim.run().t, [0.1, 0.3, 7.0])
    assert seen == [0.1, 0.3, 7.0]


def test_frames_of_another_size_are_refused_and_the_run_goes_on_behind_them(run):
    frames = run[0]
    small = robsim.Frame(frames[0].image[:40, :50])
    sim = robsim.Experiment([frames[0], None, small, frames[3]])
    with pytest.raises(ValueError, match="that of step 2 is 50 x 40 px, those before 600 x 600 px"):
        sim.run()
    trace = sim.run()
    np.testing.assert_array_equal(trace.pose_measured[2], run[1].pose_measured[3])
    lower = robsim.Frame(frames[0].image[:599])
    with pytest.raises(ValueError, match="that of step 1 is 600 x 599 px, those before 600 x 600"):
        robsim.Experiment([frames[0], lower]).run()
    sim = robsim.Experiment([small, small])
    with pytest.warns(UserWarning, match="have 50 x 40 px and no plane map, but the area") as told:
        assert not sim.run().seen.any()
    assert len(told) == 1
    assert told[0].filename == __file__
    assert str(told[0].message).endswith("((50, 40), (1200, 1200)), or Experiment area=(50, 40)")
    robsim.Experiment([small], area=(50, 40)).run()
    lens = robsim.imaging.Intrinsics([[40, 0, 25], [0, 40, 20], [0, 0, 1]])
    mapped = robsim.imaging.PlaneMap(intrinsics=lens)
    robsim.Experiment([robsim.Frame(small.image, plane_map=mapped)]).run()


def test_a_part_of_the_frames_has_times(run):
    untimed, late = timed(run[0], (None, 0.7))
    np.testing.assert_allclose(robsim.Experiment([untimed, late]).run().t, [0, 0.7])
    # A step without a frame needs none.
    trace = robsim.Experiment([None, late, None, robsim.Observation(t=1.1)]).run()
    np.testing.assert_allclose(trace.t, [0, 0.7, 0.9, 1.1])
    sim = robsim.Experiment([late, robsim.Observation(untimed), robsim.Observation(untimed, t=0.9)])
    with pytest.raises(ValueError, match="that of step 1 has none"):
        sim.run()
    np.testing.assert_allclose(sim.run().t, [0.7, 0.9])


@pytest.mark.parametrize(
    ("frames", "step"), [([None, 5], 1), ([np.zeros((4, 4, 3), np.uint8)], 0), (["a", None], 0)]
)
def test_what_is_no_frame_is_refused_with_its_step(frames, step):
    sim = robsim.Experiment(frames)
    with pytest.raises(TypeError, match=f"frames must give Frame or .* at step {step}"):
        sim.run()


def test_stages_that_are_off_are_left_out_to_the_end_of_a_step():
    sim = robsim.Experiment([robsim.Observation(measurement=(k, 2, 3)) for k in range(2)])
    assert [sim.step_stage() for _ in range(4)] == ["world", "measure", "world", "measure"]
    assert sim.n_steps == 2


def test_frames_that_are_read_once_cannot_be_reset_after_a_part_of_a_step(run):
    sim = robsim.Experiment(iter(run[0][:3]))
    assert sim.step_stage() == "world"
    with pytest.raises(RuntimeError, match="can be read only once"):
        sim.reset()
    assert len(sim.run()) == 3


def test_a_trace_of_frames_that_nobody_measures(run):
    trace = robsim.Experiment(timed(run[0], (0.1, 0.3)), measure=False).run()
    np.testing.assert_array_equal(trace.t, [0.1, 0.3])
    assert not trace.seen.any()


def test_a_reset_repeats_the_run_with_its_own_inputs(run):
    sim = robsim.Experiment(run[0], control=robsim.DriveAround(), seed=1)
    u = sim.run(5).u
    sim.reset()
    np.testing.assert_array_equal(sim.run(5).u, u)
    sim.reset(seed=2)
    assert not np.array_equal(sim.run(5).u, u)
