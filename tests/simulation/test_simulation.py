"""Simulations: steps, results, a drive from end to end."""

import itertools
import os
import signal
import sys

import numpy as np
import pytest

import robsim
from threads import in_thread
from waiting import wait_for

SMALL = {"resolution": (240, 240)}


@pytest.mark.long
def test_spin_with_36_phases_gives_a_saw_tooth():
    trace = robsim.Simulation(measure=True).run(345)
    assert trace.seen.all()
    error = np.rad2deg(trace.error[:, 2])
    assert np.abs(error).max() < 5.3
    assert 2.7 < np.sqrt(np.mean(error**2)) < 3.0
    # It falls by the turn of a step, and jumps by the 10 degrees between two phases.
    changes = np.diff(error)
    turn = np.rad2deg(robsim.wrap_angle(np.diff(trace.pose_true[:, 2])))
    jumps = changes > 5
    np.testing.assert_allclose(changes[~jumps], -turn[~jumps], atol=0.25)
    np.testing.assert_allclose(changes[jumps], 10 - turn[jumps], atol=0.6)
    assert jumps.sum() == round(np.rad2deg(np.unwrap(trace.pose_true[:, 2])[-1]) / 10)


RESULTS = {
    "define_model": robsim.RobotModel,
    "init_parameter_estimator": lambda model: robsim.RecursiveLeastSquares(5, n_filters=3),
    "adjust_background": lambda background: background,
    "evaluate_model": lambda world: world.model.predict(world.pose_1, world.pose_2, world.last_u),
    "estimate_parameters": lambda step: None,
    "measure": lambda step: robsim.Measurement((1.0, 2.0, 3.0)),
    "estimate_state": lambda step: robsim.Estimate((4.0, 5.0, 6.0), np.eye(3)),
    "control": lambda step: (0.1, 0.2),
}


def recorded(slot, calls):
    """A callback that notes its calls, those in a step with its number."""

    def callback(*arguments):
        calls.append(slot if slot in ONCE else (slot, arguments[0].k))
        return RESULTS[slot](*arguments)

    return (lambda: callback()) if slot == "define_model" else lambda given: callback(given)


ONCE = ("define_model", "init_parameter_estimator", "adjust_background")
OPTIONAL = ("estimate_parameters", "measure", "estimate_state")


@pytest.mark.long
def test_every_combination_of_stages_is_called_in_the_order_of_the_manual():
    for on in itertools.product([False, True], repeat=3):
        calls = []
        optional = [slot for slot, is_on in zip(OPTIONAL, on, strict=True) if is_on]
        slots = (*ONCE, "evaluate_model", *optional, "control")
        off = {slot: False for slot in OPTIONAL if slot not in optional}
        sim = robsim.Simulation(**{slot: recorded(slot, calls) for slot in slots}, **off, **SMALL)
        trace = sim.run(3)
        each = ["evaluate_model", *optional, "control"]
        expected = [*ONCE, *((slot, k) for k in range(3) for slot in each)]
        expected.remove(("evaluate_model", 0))  # the robot stands at the start
        assert calls == expected
        assert np.isfinite(trace.pose_measured).all() == trace.seen.all() == ("measure" in optional)
        assert np.isfinite(trace.pose_estimated).all() == ("estimate_state" in optional)
        np.testing.assert_array_equal(trace.u, [[0.1, 0.2]] * 3)


def test_the_input_of_a_step_moves_the_robot_in_the_next():
    seen = []

    def control(step):
        seen.append(step.last_u.tolist())
        return (step.k + 1.0, 0.0)

    worlds = []

    def evaluate_model(world):
        worlds.append((world.k, world.last_u.tolist()))
        return world.model.predict(world.pose_1, world.pose_2, world.last_u)

    robsim.Simulation(control=control, evaluate_model=evaluate_model).run(4)
    assert seen == [[0, 0], [1, 0], [2, 0], [3, 0]]
    # In step 0 the robot stands at the start.
    assert worlds == [(1, [1, 0]), (2, [2, 0]), (3, [3, 0])]


def regression_of(sim, steps):
    samples = []

    @sim.estimate_parameters
    def keep(step):
        samples.append(step.sample)

    return samples, sim.run(steps)


def test_from_truth_the_sample_of_a_step_is_there_in_that_step():
    samples, trace = regression_of(robsim.Simulation(control=robsim.DriveAround(), seed=3), 20)
    assert samples[:2] == [None, None]
    phi, y = robsim.estimation.regression(trace.pose_true, trace.u)
    for k in range(2, 20):
        assert samples[k].k == k
        np.testing.assert_array_equal(samples[k].phi, phi[k - 2])
        np.testing.assert_array_equal(samples[k].y, y[k - 2])


@pytest.mark.parametrize("source", ["measurement", "estimate"])
def test_from_measurement_or_estimate_it_is_that_of_the_step_before(source):
    def pose(k):
        return (10.0 * k, 3.0 * k * k, 0.4 * k)

    sim = robsim.Simulation(
        control=robsim.DriveAround(),
        seed=3,
        identify_from=source,
        measure=lambda step: robsim.Measurement(pose(step.k)),
        estimate_state=lambda step: robsim.Estimate(pose(step.k), np.eye(3)),
        **SMALL,
    )
    samples, trace = regression_of(sim, 20)
    assert samples[:3] == [None, None, None]
    phi, y = robsim.estimation.regression([pose(k) for k in range(20)], trace.u)
    for k in range(3, 20):
        assert samples[k].k == k - 1
        np.testing.assert_allclose(samples[k].phi, phi[k - 3])
        np.testing.assert_allclose(samples[k].y, y[k - 3])
    with pytest.raises(ValueError, match="identify_from"):
        robsim.Simulation(identify_from=source, estimate_parameters=True).run(1)


@pytest.mark.parametrize(("steps", "bounced"), [(2, False), (3, False), (20, False), (34, True)])
@pytest.mark.parametrize("source", ["truth", "measurement"])
def test_a_run_that_no_callback_watches_ends_with_the_sample_of_its_last_step(
    steps, bounced, source
):
    start = (1100.0, 600.0, 0.0) if bounced else None
    options = {"control": robsim.DriveAround(), "seed": 3, "identify_from": source, "start": start}
    if source == "measurement":
        options["measure"] = True
    watched, _ = regression_of(robsim.Simulation(**options), steps)
    unwatched = robsim.Simulation(**options)
    unwatched.run(steps - 1)
    held = unwatched.last_step
    unwatched.run(1)
    for step, expected in ((held, watched[-2]), (unwatched.last_step, watched[-1])):
        assert (step.sample is None) == (expected is None)
        if expected is not None:
            assert step.sample.k == expected.k
            np.testing.assert_array_equal(step.sample.phi, expected.phi)
            np.testing.assert_array_equal(step.sample.y, expected.y)


def test_a_sample_that_spans_a_missing_measurement_or_a_bounce_is_none():
    sim = robsim.Simulation(
        identify_from="measurement",
        measure=lambda step: None if step.k == 6 else robsim.Measurement((1.0, 2.0, 3.0)),
        **SMALL,
    )
    samples, _ = regression_of(sim, 12)
    missing = [k for k, sample in enumerate(samples) if sample is None]
    assert missing == [0, 1, 2, 7, 8, 9]

    drive = robsim.Simulation(start=(1100.0, 600.0, 0.0), control=lambda step: (1.0, 1.0))
    samples, trace = regression_of(drive, 60)
    (bounce,) = np.nonzero(trace.bounced)[0]
    missing = [k for k, sample in enumerate(samples) if sample is None]
    assert missing == [0, 1, bounce, bounce + 1]


def test_the_held_pose_is_the_last_valid_one():
    sim = robsim.Simulation(
        measure=lambda step: robsim.Measurement((step.k, 0.0, 0.0)) if step.k % 3 == 1 else None,
        **SMALL,
    )
    trace = sim.run(8)
    np.testing.assert_array_equal(trace.seen, [k % 3 == 1 for k in range(8)])
    np.testing.assert_array_equal(trace.pose_held[:, 0], [np.nan, 1, 1, 1, 4, 4, 4, 7])
    np.testing.assert_array_equal(np.isnan(trace.pose_measured[:, 0]), ~trace.seen)


def test_the_trace_has_the_two_biggest_blobs_of_each_colour():
    trace = robsim.Simulation(measure=True, start=(300.0, 700.0, 0.0)).run(1)
    square, marker = trace.blobs["red"][0]
    np.testing.assert_allclose(square, (572 + 27.5, 64 + 27.5), atol=0.01)
    np.testing.assert_allclose(marker, (300 - 14, 700 + 21.5), atol=0.2)
    np.testing.assert_allclose(trace.blobs["blue"][0, 0], (300 - 14, 700 - 21.5), atol=0.2)
    assert np.isnan(trace.blobs["blue"][0, 1]).all()


def test_a_trace_in_hand_does_not_change_while_the_run_goes_on():
    sim = robsim.Simulation(control=robsim.DriveAround(), seed=5)
    early = sim.run(10)
    copy = early.pose_true.copy()
    sim.run(5000)
    assert len(early) == 10
    np.testing.assert_array_equal(early.pose_true, copy)
    with pytest.raises(ValueError, match="read-only"):
        early.pose_true[0, 0] = 0


def test_once_callbacks_are_refused_after_the_start():
    sim = robsim.Simulation(**SMALL)
    sim.run(1)
    with pytest.raises(RuntimeError, match=r"define_model runs only at the start.*reset"):
        sim.define_model = robsim.RobotModel


def test_the_seed_in_the_trace_gives_the_run_again():
    ends = set()
    for seed in (11, np.random.SeedSequence(11, spawn_key=(3,)), np.random.default_rng(11), None):
        trace = robsim.Simulation(seed=seed, control=robsim.DriveAround()).run(30)
        again = robsim.Simulation(
            seed=np.random.SeedSequence(**trace.info.seed), control=robsim.DriveAround()
        ).run(30)
        np.testing.assert_array_equal(trace.pose_true, again.pose_true)
        ends.add(tuple(trace.pose_true[-1]))
    assert len(ends) == 4


def test_global_random_state_is_not_touched():
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    robsim.Simulation(seed=1, control=robsim.DriveAround(), start="random", measure=True).run(3)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002


def test_a_ready_controller_can_be_called_from_a_callback():
    drive = robsim.DriveAround()
    native = robsim.Simulation(seed=2, control=drive).run(50)
    called = robsim.Simulation(seed=2, control=lambda step: drive(step)).run(50)
    np.testing.assert_array_equal(native.u, called.u)


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="no POSIX signals")
@pytest.mark.parametrize("control", [None, lambda step: (0.1, 0.1)])
def test_ctrl_c_stops_a_run_with_its_trace_kept(control, request):
    # A shell starts what it puts into the background with this signal ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))
    sim = robsim.Simulation(control=control, estimate_parameters=True)

    def press():
        wait_for(lambda: sim.n_steps > 1)
        os.kill(os.getpid(), signal.SIGINT)

    with in_thread(press), pytest.raises(KeyboardInterrupt):
        sim.run(10**9)
    assert not sim.is_running
    done = len(sim.trace)
    assert 0 < done < 10**9
    assert np.isfinite(sim.trace.pose_true).all()
    assert len(sim.run(10)) == done + 10


def test_progress_shows_a_bar_on_a_terminal_alone(capsys, monkeypatch):
    sim = robsim.Simulation(measure=True, **SMALL)
    sim.run(20, progress=True)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    sim.run(20, progress=True)
    assert "20/20" in capsys.readouterr().err


def test_a_look_at_the_frame_in_the_model_does_not_disturb_the_measurement():
    options = {"measure": True, "control": robsim.DriveAround(), "seed": 1}
    undisturbed = robsim.Simulation(**options).run(10)
    sim = robsim.Simulation(**options)

    @sim.evaluate_model
    def evaluate_model(world):
        if world.k:
            assert sim.frame.index == world.k - 1
        return world.model.predict(world.pose_1, world.pose_2, world.last_u)

    np.testing.assert_array_equal(sim.run(10).pose_measured, undisturbed.pose_measured)


def test_reset_forgets_the_columns_too():
    def further(*numbers):
        return lambda step: robsim.Estimate((0, 0, 0), np.eye(3), [step.k, *numbers])

    sim = robsim.Simulation(measure=True, estimate_state=further(-1))
    np.testing.assert_array_equal(sim.run(2).state, [[0, -1], [1, -1]])
    sim.reset()
    sim.measure = False
    sim.estimate_state = further(-1, -2)
    trace = sim.run(2)
    assert trace.state.shape == (2, 3)
    assert "x_measured" not in trace.names


def test_what_cannot_be_run_is_an_error():
    sim = robsim.Simulation(**SMALL)
    for steps in ((), (-1,), (2**70,), (1.5,)):
        with pytest.raises((TypeError, ValueError), match="steps"):
            sim.run(*steps)
    assert len(sim.run(0)) == 0
    sim = robsim.Simulation(measure=True, colors=[robsim.ColorClass("red", v=(164, 255))])
    with pytest.raises(ValueError, match="colors"):
        sim.run(1)
    robsim.Simulation(area=(112, 400)).run(1)
    with pytest.raises(ValueError, match="area"):
        robsim.Simulation(area=(110, 400)).run(1)


def test_a_class_of_ones_own_that_builds_on_a_native_one_is_used():
    class Faster(robsim.Spin):
        def __call__(self, step):
            return 2 * super().__call__(step)

    class Counting(robsim.RecursiveLeastSquares):
        updates = 0

        def update(self, phi, y):
            Counting.updates += 1
            return super().update(phi, y)

    estimator = Counting(5, n_filters=3)
    sim = robsim.Simulation(control=Faster(), init_parameter_estimator=lambda model: estimator)
    trace = sim.run(6)
    np.testing.assert_array_equal(trace.u, [[0.1, -0.1]] * 6)
    assert Counting.updates == 4
    assert sim.estimator is estimator


# --- a drive from end to end


def test_a_drive_with_tracking_and_identification(tmp_path):
    sim = robsim.Simulation(
        robot="lab",
        area=(400, 400),
        headings=None,
        measure=True,
        estimate_parameters=True,
        estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(),
        identify_from="truth",
        control=robsim.DriveAround(low=-0.2, high=0.5, hold=5),
        process_noise=robsim.WheelNoise(0.001),
        seed=4,
    )
    trace = sim.run(120)

    # Where it is, as seen and as estimated.
    assert trace.seen.all()
    way = np.linalg.norm(np.diff(trace.pose_true[:, :2], axis=0), axis=1).sum()
    assert way > 100
    for poses, px, rad in ((trace.pose_measured, 0.1, 0.005), (trace.pose_estimated, 0.1, 0.005)):
        errors = poses - trace.pose_true
        assert np.hypot(errors[:, 0], errors[:, 1]).max() < px
        assert np.abs(robsim.wrap_angle(errors[:, 2])).max() < rad

    # What it is: at every step, and from all of them at once.
    theta = sim.true_model.theta
    np.testing.assert_array_equal(trace.info.theta_true, theta)
    np.testing.assert_allclose(trace.parameters[-1], theta, atol=2e-3)
    np.testing.assert_allclose(robsim.batch_estimate(trace).batch, theta, atol=2e-3)

    # What is written down is the run, and gives it again.
    trace.save(tmp_path / "drive.npz")
    read = robsim.Trace.load(tmp_path / "drive.npz")
    assert read == trace
    with pytest.warns(UserWarning, match="estimate_state"):  # code is no data
        scenario = robsim.Scenario.of(read)
    kalman_filter = robsim.estimation.reference.ExtendedKalmanFilter()
    again = robsim.Simulation(scenario, estimate_state=kalman_filter)
    assert again.run(120).pose_estimated.tobytes() == trace.pose_estimated.tobytes()
