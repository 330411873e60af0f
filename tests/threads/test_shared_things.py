"""Things that several simulations use at the same time, each in a thread of its own."""

import gc
import threading

import numpy as np
import pytest

import robsim
from threads import in_thread, running, together

pytestmark = pytest.mark.threads

LONG = 10**9  # steps, more than anybody waits for
SMALL = {"measure": True, "area": (300, 300), "resolution": (75, 75)}


def test_an_estimator_serves_one_run_at_a_time():
    shared = robsim.RecursiveLeastSquares(5, n_filters=3)
    sims = [
        robsim.Simulation(
            init_parameter_estimator=lambda model: shared,
            control=robsim.DriveAround(),
            seed=seed,
            **SMALL,
        )
        for seed in range(2)
    ]
    sims[1].run(3)
    with (
        running(sims[0], LONG),
        pytest.raises(RuntimeError, match="estimator"),
    ):
        sims[1].run(10)
    assert len(sims[1].trace) == 3
    sims[1].run(10)  # one after the other they may


def test_an_estimator_serves_a_simulation_inside_a_callback_of_its_own():
    shared = robsim.RecursiveLeastSquares(5, n_filters=3)
    options = {"init_parameter_estimator": lambda model: shared, "seed": 1}
    inner = robsim.Simulation(control=robsim.DriveAround(), **options)

    def control(step):
        inner.run(2)
        return 0.4, 0.1 * step.estimator.theta[0, 0]

    assert len(robsim.Simulation(control=control, **options).run(5)) == 5
    assert shared.n_samples.tolist() == [10 + 5 - 4] * 3


def test_a_refused_run_stops_the_robot():
    shared = robsim.RecursiveLeastSquares(5, n_filters=3)
    sim = robsim.Simulation(
        init_parameter_estimator=lambda model: shared,
        control=robsim.DriveAround(),
        **SMALL,
    )
    sent = []
    frames = [robsim.Frame(np.zeros((64, 64, 3), dtype=np.uint8)) for _ in range(9)]
    experiment = robsim.Experiment(
        frames,
        area=(64, 64),
        send=lambda u: sent.append(tuple(u)),
        frame_timeout=300,
        stop_input=(0, 0),
        control=lambda step: (0.5, 0.5),
        measure=lambda step: (1, 1, 0),
        init_parameter_estimator=lambda model: shared,
        identify_from="measurement",
    )
    experiment.step()  # and the robot drives
    with running(sim, LONG), pytest.raises(RuntimeError, match="estimator"):
        experiment.run(2)
    assert (sent[0], *{*sent[1:]}) == ((0.5, 0.5), (0, 0))


@pytest.mark.long
@pytest.mark.parametrize(
    "control", [robsim.DriveAround(), robsim.Spin(), robsim.Replay(np.full((400, 2), 0.4))]
)
def test_a_ready_controller_and_a_scene_serve_any_number(control):
    def make(seed):
        noise = robsim.GaussianNoise(10)
        return robsim.Simulation(control=control, seed=seed, noise=noise, headings=36, **SMALL)

    alone = [make(seed).run(60).pose_measured for seed in range(4)]
    sims = [make(seed) for seed in range(4)]
    together(*(lambda sim=sim: sim.run(60) for sim in sims))
    for sim, expected in zip(sims, alone, strict=True):
        np.testing.assert_array_equal(sim.trace.pose_measured, expected)


@pytest.mark.parametrize("kind", [robsim.GoToPoint, robsim.FollowPath])
def test_a_controller_with_a_memory_serves_one_run_at_a_time(kind):
    shared = kind(9, 9) if kind is robsim.GoToPoint else kind([(9, 9)])
    first, second = (robsim.Simulation(control=shared, **SMALL) for _ in range(2))
    second.run(2)
    with running(first, LONG), pytest.raises(RuntimeError, match=kind.__name__):
        second.run(2)
    assert len(second.run(2)) == 4


def test_a_frame_that_is_given_back_by_another_thread_is_not_changed_before():
    """Its memory is used again as soon as nobody else holds it."""
    sim = robsim.Simulation(measure=True, area=(300, 240), resolution=(100, 80), seed=1)
    given, taken = [], threading.Semaphore(0)

    def control(step):
        given.append((step.frame, step.frame.image.sum()))
        taken.release()
        return 0.3, 0.2

    sim.control = control

    def look():
        for _ in range(200):
            taken.acquire()
            frame, total = given.pop()
            assert frame.image.sum() == total

    together(lambda: sim.run(200), look)


@pytest.mark.long
def test_the_garbage_collector_looks_at_a_run():
    """It comes in the midst of anything, and looks at what the loop holds."""

    class Estimator:
        def update(self, phi, y):
            return np.zeros((3, 5))

    def make(**options):
        sim = robsim.Simulation(seed=1, **SMALL, **options)
        sim.define_model = lambda: sim and robsim.RobotModel()
        return sim

    def collect():
        for _ in range(30):
            dropped = make(init_parameter_estimator=lambda model: Estimator())
            dropped.run(3)
            del dropped
            gc.collect()

    before = gc.get_threshold()
    gc.freeze()  # what is there from before: it would take too long
    gc.set_threshold(1)
    try:
        with running(make(control=robsim.DriveAround(), estimate_parameters=True), LONG):
            collect()
        with in_thread(lambda: make(control=lambda step: [step.k * 0.0, 0.1]).run(100)):
            collect()
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()


def test_frames_that_several_threads_draw_again():
    sim = robsim.Simulation(resolution=(100, 80), noise=robsim.UniformNoise(5), seed=1)
    frames = [sim.step().frame.image.copy() for _ in range(8)]

    def draw():
        for _ in range(4):
            for k, expected in enumerate(frames):
                np.testing.assert_array_equal(sim.render_step(k).image, expected)

    together(draw, draw, draw)


def test_callbacks_in_several_threads():
    """With callbacks the runs take turns; each gives what it gives alone."""

    def make(seed):
        sim = robsim.Simulation(seed=seed, **SMALL)
        sim.control = lambda step: (0.2 + 0.001 * sim.rng.random(), 0.1)
        return sim

    alone = [make(seed).run(60).u for seed in range(3)]
    sims = [make(seed) for seed in range(3)]
    together(*(lambda sim=sim: sim.run(60) for sim in sims))
    for sim, expected in zip(sims, alone, strict=True):
        np.testing.assert_array_equal(sim.trace.u, expected)
