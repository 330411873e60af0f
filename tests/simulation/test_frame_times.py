"""Late and lost frames, and the samples from them."""

import functools

import numpy as np
import pytest

import robsim

# --- samples


DT = 0.2
B1X = 2


@functools.cache
def driven(steps):
    """Return the poses and inputs of a drive around without walls."""
    sim = robsim.Simulation(boundary="unlimited", control=robsim.DriveAround(), seed=3)
    trace = sim.run(steps)
    return trace.pose_true, trace.u


def observed(times, poses):
    return [robsim.Observation(t=t, measurement=pose) for t, pose in zip(times, poses, strict=True)]


def identified(observations, u, **options):
    """Return an experiment on them, and the list that its samples are put into."""
    samples = []
    estimator = robsim.RecursiveLeastSquares(5, n_filters=3)

    def estimate_parameters(step):
        if step.sample is None:
            return None
        samples.append((step.sample.phi, step.sample.y))
        return estimator.update(step.sample.phi, step.sample.y)

    given = {
        "estimate_parameters": estimate_parameters,
        "control": lambda step: u[round(step.t / DT)],
    }
    return robsim.Experiment(observations, **(given | options)), samples


def lost_steps(steps):
    return np.random.default_rng(1).choice(np.arange(1, steps), steps // 10, replace=False)


@pytest.mark.parametrize("lost", [[20], [20, 22], [2], lost_steps(60)], ids=str)
def test_a_gap_interrupts_the_record_as_a_missing_measurement_does(lost):
    poses, u = driven(60)
    kept = np.setdiff1d(np.arange(60), lost)
    times = DT * np.arange(60)
    unseen = [
        robsim.Observation(t=seen.t) if k in lost else seen
        for k, seen in enumerate(observed(times, poses))
    ]
    full, samples = identified(unseen, u)
    short, samples_over_gaps = identified(observed(times[kept], poses[kept]), u)
    full.run()
    short.run()
    assert 0 < len(samples) < 57
    for one, other in zip(samples, samples_over_gaps, strict=True):
        np.testing.assert_array_equal(one[0], other[0])
        np.testing.assert_array_equal(one[1], other[1])
    np.testing.assert_array_equal(full.trace.parameters[-1], short.trace.parameters[-1])
    # The record gives the same ones, and that of its last step.
    recorded = robsim.estimation.regression_of(short.trace)
    np.testing.assert_array_equal(recorded.phi[: len(samples)], [phi for phi, _ in samples])
    np.testing.assert_array_equal(recorded.y[: len(samples)], [y for _, y in samples])
    assert len(recorded.k) == len(samples) + 1


def test_a_tenth_of_lost_frames_spoils_no_estimate():
    poses, u = driven(600)
    kept = np.setdiff1d(np.arange(600), lost_steps(600))
    sim, _ = identified(observed(DT * kept, poses[kept]), u, estimate_parameters=True)
    trace = sim.run()
    truth = robsim.RobotModel().theta
    assert trace.parameters[-1, 0, B1X] == pytest.approx(truth[0, B1X], rel=1e-3)
    np.testing.assert_allclose(trace.parameters[-1], truth, atol=1e-3)
    np.testing.assert_allclose(robsim.batch_estimate(trace).batch, truth, atol=1e-9)


def test_the_input_that_the_robot_really_got_is_in_the_sample():
    poses, u = driven(60)
    observations = [
        robsim.Observation(t=t, measurement=pose, last_u=last_u)
        for t, pose, last_u in zip(DT * np.arange(60), poses, [(0, 0), *u[:-1]], strict=True)
    ]
    other, samples = identified(observations, 0 * u)
    told, expected = identified(observed(DT * np.arange(60), poses), u)
    told.run()
    other.run()
    np.testing.assert_array_equal([phi for phi, _ in samples], [phi for phi, _ in expected])
    np.testing.assert_array_equal(other.trace.parameters, told.trace.parameters)


def run_at(times, **options):
    poses, u = driven(60)
    sim = robsim.Experiment(
        observed(times, poses[: len(times)]), control=robsim.Replay(u), **options
    )
    return sim, sim.run


STAGES = {
    "estimate_parameters": lambda: True,
    "estimate_state": robsim.estimation.reference.ExtendedKalmanFilter,
}


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize("interval", [0.1, 0.3])
def test_frames_at_another_rate_are_refused_at_once(stage, interval):
    sim, run = run_at(np.arange(30) * interval, **{stage: STAGES[stage]()})
    with pytest.raises(ValueError, match=rf"step\.dt .*0\.2 s, got {interval}: .*sim\.model"):
        run()
    assert len(sim.trace) == 1


@pytest.mark.parametrize("interval", [0.16, 0.22])
def test_frames_of_nearly_the_rate_are_refused_soon(interval):
    times = np.arange(60) * interval
    for stage, make in STAGES.items():
        sim, run = run_at(times, **{stage: make()})
        with pytest.raises(ValueError, match=f"{interval} on average"):
            run()
        assert len(sim.trace) <= 13
    _, run = run_at(times)
    with pytest.raises(ValueError, match=f"{interval} on average"):
        robsim.batch_estimate(run(), identify_from="measurement")


@pytest.mark.parametrize("stage", STAGES)
def test_a_jitter_of_a_twentieth_is_accepted(stage):
    jitter = np.random.default_rng(1).uniform(-0.05, 0.05, 60)
    sim, run = run_at(DT * (np.arange(60) + jitter), **{stage: STAGES[stage]()})
    run()
    assert len(sim.trace) == 60


def test_the_rate_of_the_frames_can_be_told():
    rate = robsim.RobotModel(robsim.RobotParameters(dt=0.033))
    sim, run = run_at(
        0.033 * np.arange(30),
        define_model=lambda: rate,
        estimate_parameters=True,
        estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(rate),
    )
    run()
    assert len(sim.trace) == 30


def live_observations(times):
    image = np.zeros((64, 64, 3), np.uint8)
    for k, t in enumerate(times):
        yield robsim.Observation(
            robsim.Frame(image, t=t, epoch=0.0, index=k), measurement=(10.0 * t, 5.0, 0.0)
        )


def live(times):
    samples = []
    experiment = robsim.Experiment(
        live_observations(times),
        area=(64, 64),
        control=lambda step: (0.1, 0.1),
        estimate_parameters=lambda step: samples.append(step.sample and step.sample.k),
    )
    return experiment, samples


def test_a_live_frame_out_of_turn_interrupts_the_record_and_ends_no_run():
    experiment, samples = live([0.0, 0.2, 0.4, 0.6, 0.87, 1.0, 1.2, 1.4, 1.6])
    experiment.run()
    # That of step 4 came 0.07 s late, and the one after it so much sooner.
    assert samples == [None, None, None, 2, 3, None, None, None, 7]


def test_a_camera_of_another_rate_is_refused_all_the_same():
    experiment, _ = live(0.07 * np.arange(30))
    with pytest.raises(ValueError, match=r"step\.dt must be a multiple of the model's dt"):
        experiment.run()
    assert len(experiment.trace) < 15


# --- lost frames


OPTIONS = {"measure": True, "resolution": (400, 400), "boundary": "unlimited", "seed": 5}


def test_a_hidden_robot_is_neither_drawn_nor_found():
    sim = robsim.Simulation(
        **OPTIONS, dropout=robsim.Dropout(1.0), adjust_background=lambda background: background
    )
    trace = sim.run(3)
    assert not trace.seen.any()
    assert np.isfinite(trace.pose_true).all()
    assert sim.last_step.blobs == {"red": [], "blue": []}


def test_stretches_are_hidden_with_the_probability():
    sim = robsim.Simulation(**OPTIONS, dropout=robsim.Dropout(0.3, steps=4))
    valid = sim.run(400).seen.reshape(-1, 4)
    assert (valid.all(axis=1) | (~valid).all(axis=1)).all()
    assert 0.2 < 1 - valid.mean() < 0.4


def test_the_path_and_the_other_frames_stay_what_they_are():
    free, hidden = (
        robsim.Simulation(
            **OPTIONS, control=robsim.DriveAround(), dropout=robsim.Dropout(share)
        ).run(100)
        for share in (0.0, 0.5)
    )
    np.testing.assert_array_equal(free.pose_true, hidden.pose_true)
    np.testing.assert_array_equal(
        free.pose_measured[hidden.seen], hidden.pose_measured[hidden.seen]
    )
    assert not hidden.seen.all()


def test_wrong_options():
    for name, arguments in (
        ("probability", (1.0001,)),
        ("probability", (-0.1,)),
        ("probability", (float("nan"),)),
        ("steps", (0.1, 0)),
    ):
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            robsim.Dropout(*arguments)


@pytest.mark.parametrize("boundary", ["bounce", "unlimited"])
def test_the_frame_of_a_recorded_step_is_the_one_that_was(boundary):
    sim = robsim.Simulation(
        resolution=(300, 200),
        boundary=boundary,
        control=robsim.DriveAround(),
        noise=robsim.UniformNoise(10),
        dropout=robsim.Dropout(0.3),
        measure=True,
        seed=6,
    )
    frames = [sim.step().frame for _ in range(50)]
    for k in (0, 49, 3, 27, 26, 40):
        again = sim.render_step(k)
        assert (again.index, again.t) == (frames[k].index, frames[k].t)
        np.testing.assert_array_equal(again.image, frames[k].image)
        np.testing.assert_array_equal(again.plane_map.matrix, frames[k].plane_map.matrix)
    for k in (-1, 50):
        with pytest.raises(IndexError, match=r"0\.\.49"):
            sim.render_step(k)


def test_step_locator_is_what_the_default_measurement_uses():
    def measure(step):
        return robsim.locate(step.blobs, step.markers, image=step.frame)

    own, default = (
        robsim.Simulation(**{**OPTIONS, "measure": which}).run(10) for which in (measure, True)
    )
    assert own.seen.all()
    np.testing.assert_array_equal(own.pose_measured, default.pose_measured)
