"""Seams of a run: access from outside, and a separate process."""

import numpy as np
import pytest

import robsim
from remote_half import CONTROLS, RemoteHalf, approach
from threads import in_thread
from waiting import wait_for

# --- access from outside


LONG = 10**9  # steps, more than anybody waits for
STAGES = ("world", "estimate_parameters", "measure", "estimate_state", "control", "send")


def estimate(step):
    return robsim.Estimate((step.k, 0, 0), np.eye(3))


def simulation(**options):
    """A simulation that is quick to look at."""
    return robsim.Simulation(**({"resolution": (300, 300), "seed": 3} | options))


KINDS = {
    "native": {"control": robsim.DriveAround()},
    "native with vision": {"control": robsim.DriveAround(), "measure": True},
    "callback": {"control": lambda step: (0.1, 0.2)},
}
of_all_kinds = pytest.mark.parametrize("options", KINDS.values(), ids=KINDS)


@of_all_kinds
def test_any_thread_can_stop_a_run(options):
    sim = simulation(**options)
    with in_thread(lambda: sim.run(LONG)):
        wait_for(lambda: sim.n_steps > 3)
        assert sim.is_running
        assert sim.stop()
    assert not sim.is_running
    done = sim.n_steps
    assert len(sim.trace) == done > 3
    assert sim.stage == "world"
    # A stop that comes late is for no later run.
    assert not sim.stop()
    assert len(sim.run(5)) == done + 5


def test_a_callback_may_stop_its_run():
    def define_model():
        assert sim.stop()
        return robsim.RobotModel()

    sim = simulation(define_model=define_model)
    assert len(sim.run(LONG)) == 0
    assert len(sim.run(2)) == 2
    sim.control = lambda step: (sim.stop() * 0.1, 0.2)
    np.testing.assert_array_equal(sim.run(LONG).u[2:], [(0.1, 0.2)])


def equal_groups(trace, expected):
    return trace.names == expected.names and all(
        trace[name].tobytes() == expected[name].tobytes() for name in trace.names
    )


@pytest.mark.parametrize(
    "on",
    [
        {"measure": True, "estimate_parameters": True, "estimate_state": estimate},
        {"estimate_state": estimate},
        {"measure": True},
        {},
    ],
    ids=lambda on: "+".join(on) or "control",
)
def test_stage_by_stage_gives_the_same_bytes_as_a_run(on):
    options = {"control": robsim.DriveAround(), "noise": robsim.GaussianNoise(5), **on}
    expected = simulation(**options).run(8)
    sim = simulation(**options)
    names = [stage for stage in STAGES if stage in ("world", "control") or stage in on]
    for k in range(8):
        for name in names:
            assert sim.stage == name
            assert sim.n_steps == k
            assert sim.step_stage() == name
            assert not sim.is_running
    assert sim.stage == "world"
    assert equal_groups(sim.trace, expected)
    # A run and a step end a step that stages have begun.
    mixed = simulation(**options)
    mixed.step_stage()
    assert mixed.step().k == 0
    mixed.step_stage()
    mixed.run(2)
    mixed.step_stage()
    assert mixed.step_stage() == names[1]
    mixed.run(8 - mixed.n_steps)
    assert equal_groups(mixed.trace, expected)


def test_the_stage_that_runs_is_known_while_it_runs():
    seen = {}

    def watched(name, result):
        def stage(step):
            with in_thread(lambda: seen.setdefault(name, sim.stage)):
                pass
            return result

        return stage

    sim = simulation(
        identify_from="truth",
        estimate_parameters=watched("estimate_parameters", None),
        measure=watched("measure", None),
        estimate_state=watched("estimate_state", robsim.Estimate((0, 0, 0), np.eye(3))),
        control=watched("control", (0, 0)),
    )
    sim.run(1)
    assert seen == {name: name for name in STAGES[1:5]}


def test_what_is_known_of_a_run_is_known_in_its_first_callback():
    seen = []

    def adjust_background(background):
        seen.append((len(sim.trace), sim.trace.info.dt, sim.n_steps))
        return background

    sim = simulation(adjust_background=adjust_background)
    sim.run(1)
    assert seen == [(0, 0.2, 0)]


@pytest.fixture
def borrowed():
    """A frame on memory of the test's own, and that memory."""
    frame = simulation().frame
    memory = frame.image.copy()
    plane_map = frame.plane_map
    return robsim.Frame(memory, copy=False, plane_map=plane_map), memory


@pytest.mark.parametrize("measure", [True, False])
def test_what_was_measured_elsewhere_is_not_measured_again(borrowed, measure):
    frame, memory = borrowed
    sim = robsim.Experiment(
        [robsim.Observation(frame, measurement=(1, 2, 3)), frame],
        measure=measure,
        estimate_state=lambda step: robsim.Estimate(step.measurement.pose, np.eye(3)),
    )
    step = sim.step()
    np.testing.assert_array_equal(sim.trace.pose_measured, [(1, 2, 3)])
    np.testing.assert_array_equal(sim.trace.pose_held, [(1, 2, 3)])
    np.testing.assert_array_equal(sim.trace.pose_estimated, [(1, 2, 3)])
    # A borrowed frame shows what its memory holds when somebody looks: nobody had.
    kept = memory.copy()
    memory[:] = 0
    assert step.blobs == {"blue": [], "red": []}
    memory[:] = kept
    if measure:
        step = sim.step()
        memory[:] = 0
        assert all(step.blobs[color] for color in ("red", "blue"))


def test_a_callback_may_improve_what_was_measured_elsewhere(borrowed):
    observed = [robsim.Observation(borrowed[0], measurement=(1, 2, 1))]
    sim = robsim.Experiment(observed, measure=lambda step: 2 * step.measurement.pose)
    np.testing.assert_array_equal(sim.run().pose_measured, [(2, 4, 2)])
    sim = robsim.Experiment(observed, measure=lambda step: None)
    assert not sim.run().seen.any()


def test_samples_that_are_brought_give_the_same_parameters():
    observations = []

    def estimate_state(step):
        observations.append(robsim.Observation(t=step.t, sample=step.sample))
        return estimate(step)

    sim = robsim.Simulation(
        area=(600, 600),
        control=robsim.DriveAround(low=0.6, high=1.0),
        estimate_parameters=True,
        estimate_state=estimate_state,
        seed=3,
    )
    expected = sim.run(200)
    assert expected.bounced.any()
    again = robsim.Experiment(
        observations,
        area=(600, 600),
        identify_from="truth",
        estimate_parameters=True,
        measure=False,
        control=robsim.Replay(expected.u),
    ).run()
    assert again.parameters.tobytes() == expected.parameters.tobytes()
    assert np.isfinite(again.parameters[-1]).all()


def test_memory_of_another_size_than_the_frames_is_refused():
    sim = simulation()
    sim.run(1)
    for size in ((300, 299), (299, 300)):
        out = np.full((*size, 3), 7, np.uint8)
        with pytest.raises(ValueError, match=r"\bout\b.*300 x 300 px"):
            sim.render_step(0, out=out)
        assert (out == 7).all()


# --- the robot half in a process


SEED = 5
STEPS = 40
WORLD = {
    "resolution": (300, 300),
    "noise": robsim.GaussianNoise(10),
    "dropout": robsim.Dropout(0.1, 3),
    "start": (300, 400, 1.0),
    "seed": SEED,
}


@pytest.fixture
def run_remotely(tmp_path):
    """Run the robot half in another process; return both traces, and the last input sent."""
    started = []

    def run(**options):
        sim = robsim.Simulation(**WORLD)
        remote = RemoteHalf(sim, tmp_path, seed=SEED, **options)
        started.append(remote)
        trace = sim.run(STEPS)
        return trace, *remote.end()

    yield run
    for remote in started:
        remote.abandon()


def run_at_home(control):
    sim = robsim.Simulation(
        **WORLD,
        identify_from="measurement",
        measure=True,
        estimate_parameters=True,
        estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(),
        control=control,
    )
    trace = sim.run(STEPS)
    # Only who knows the truth knows of a bounce, and makes no sample of it.
    assert not trace.bounced.any()
    return trace


def assert_same(trace, expected, columns):
    for column in columns:
        assert getattr(trace, column).tobytes() == getattr(expected, column).tobytes(), column


OF_BOTH = ("pose_measured", "pose_held", "pose_estimated", "covariance", "state", "parameters")


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.sanitized
def test_a_robot_half_in_a_process_gives_the_same_bytes(run_remotely):
    expected = run_at_home(CONTROLS["drive around"])
    assert 0 < np.isnan(expected.pose_measured).any(axis=1).sum() < STEPS
    assert np.isfinite(expected.parameters[-1]).all()
    world, stop, robot = run_remotely(control="drive around")
    assert_same(world, expected, ("pose_true", *OF_BOTH, "u"))
    assert_same(robot, expected, ("t", *OF_BOTH, "u", "standard_errors_unscaled"))
    for color, centroids in expected.blobs.items():
        assert robot.blobs[color].tobytes() == centroids.tobytes()
    np.testing.assert_array_equal(stop, (0, 0))


@pytest.mark.long
def test_a_robot_half_that_is_told_what_the_motors_got_gives_the_same_bytes(run_remotely):
    limit = 0.7
    expected = run_at_home(lambda step: np.clip(approach(step), -limit, limit))
    world, stop, robot = run_remotely(control="approach", limit=limit)
    assert_same(world, expected, ("pose_true", *OF_BOTH, "u"))
    assert_same(robot, expected, OF_BOTH)
    # What the robot half sent is recorded there, not what arrived.
    assert np.abs(robot.u).max() > limit
    np.testing.assert_array_equal(np.clip(robot.u, -limit, limit), expected.u)
    np.testing.assert_array_equal(stop, (0, 0))
