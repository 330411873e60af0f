"""What others may do to a run from outside, and bring to it."""

import multiprocessing
import struct
import threading
from multiprocessing.shared_memory import SharedMemory

import numpy as np
import pytest

import robsim
from remote_half import PATIENCE, pixels_in, seen_in
from threads import in_thread
from waiting import wait_for

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


class Background:
    """A run in a thread of its own."""

    def __init__(self, sim):
        self.sim = sim
        self.thread = threading.Thread(target=sim.run, args=(LONG,))

    def __enter__(self):
        self.thread.start()
        wait_for(lambda: self.sim.n_steps > 3)
        return self.sim

    def __exit__(self, *error):
        while self.thread.is_alive():
            self.sim.stop()
            self.thread.join(0.01)


@of_all_kinds
def test_any_thread_can_stop_a_run(options):
    sim = simulation(**options)
    background = Background(sim)
    with background:
        assert sim.is_running
        assert sim.stop()
        background.thread.join(PATIENCE)
        assert not background.thread.is_alive()
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


@pytest.mark.long
@of_all_kinds
def test_other_threads_may_read_what_is_recorded(options):
    sim = simulation(**options, noise=robsim.UniformNoise(1))
    seen, traces = set(), []
    with Background(sim):
        last = 0
        for _ in range(16):
            seen.add(sim.stage)
            assert sim.is_running
            wait_for(lambda last=last: sim.n_steps > last)
            last = sim.n_steps
            trace = sim.trace
            assert len(trace) >= last
            assert np.isfinite(trace.pose_true).all()
            assert np.isfinite(trace.u).all()
            traces.append(trace)
            with pytest.raises(RuntimeError, match="another thread"):
                _ = sim.last_step.frame
    assert seen <= set(STAGES)
    final = sim.trace
    for trace in traces[::4]:
        assert equal_groups(trace, final[: len(trace)])


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


def test_without_samples_from_outside_nothing_is_known_of_the_truth():
    seen = []
    sim = robsim.Experiment(
        [robsim.Observation(measurement=(k, 2 * k, 0)) for k in range(6)],
        identify_from="truth",
        control=lambda step: seen.append(step.sample) or (0, 0),
    )
    sim.run()
    assert seen == [None] * 6


def test_the_newest_frame_can_be_written_into_memory_of_others(tmp_path):
    out = pixels_in(tmp_path / "pixels", (300, 300), "w+")
    frames, written = [], []

    def control(step):
        frame = sim.render_step(step.k, out=out)
        assert np.shares_memory(frame.image, out)
        assert (frame.index, frame.t) == (step.k, step.t)
        written.append(out.tobytes())
        if step.k:
            assert sim.render_step(step.k - 1).image.tobytes() == frames[-1]
        frames.append(step.frame.image.tobytes())
        return 0.5, 0.4

    sim = simulation(noise=robsim.GaussianNoise(20), control=control)
    sim.run(6)
    assert written == frames
    assert len(set(frames)) == 6


def test_memory_of_another_size_than_the_frames_is_refused():
    sim = simulation()
    sim.run(1)
    for size in ((300, 299), (299, 300)):
        out = np.full((*size, 3), 7, np.uint8)
        with pytest.raises(ValueError, match=r"\bout\b.*300 x 300 px"):
            sim.render_step(0, out=out)
        assert (out == 7).all()


@pytest.mark.long
def test_another_process_sees_a_frame_in_shared_memory():
    memory = SharedMemory(create=True, size=300 * 300 * 3)
    sim = simulation(noise=robsim.GaussianNoise(5))
    frame = sim.step().frame
    sim.render_step(0, out=np.ndarray((300, 300, 3), np.uint8, memory.buf))
    context = multiprocessing.get_context("spawn")
    replies, theirs = context.Pipe(duplex=False)
    process = context.Process(target=seen_in, args=(memory.name, (300, 300), theirs))
    try:
        process.start()
        theirs.close()
        assert replies.poll(PATIENCE)
        assert replies.recv_bytes() == frame.image.tobytes()
        red = robsim.find_blobs(frame, robsim.load_colors())["red"][0]
        assert struct.unpack("=2d", replies.recv_bytes()) == tuple(red.centroid)
    finally:
        replies.close()
        process.join(PATIENCE)
        memory.close()
        memory.unlink()
    assert process.exitcode == 0
