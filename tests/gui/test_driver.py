"""The thread that runs: commands from any thread, pace, stages, errors, and its own end."""

import gc
import math
import os
import threading
import weakref
from concurrent.futures import CancelledError

import numpy as np
import pytest

import robsim
from python_devices import Sender, SteppedCamera
from robsim.gui import _worker
from robsim.gui._driver import Driver
from small_runs import IMAGE, SOON, done, experiment, frames, simulation
from threads import in_thread, together
from waiting import wait_for

pytestmark = pytest.mark.threads


@pytest.fixture(autouse=True)
def no_thread_survives():
    before = set(threading.enumerate())
    yield
    wait_for(lambda: set(threading.enumerate()) <= before)


@pytest.fixture
def drive():
    """Return a function that makes a driver, which is closed at the end."""
    drivers = []

    def make(runner=None, **options):
        drivers.append(Driver(simulation() if runner is None else runner, **options))
        return drivers[-1]

    yield make
    for driver in drivers:
        assert driver.close(SOON)


def runs(driver, steps=3):
    before = driver.runner.n_steps
    wait_for(lambda: driver.runner.n_steps >= before + steps)
    return True


def rounds(driver):
    """Let the thread look many times for what is due."""
    for _ in range(20):
        done(driver.call(lambda: None))


# Commands


@pytest.mark.parametrize("speed", [1000.0, math.inf])
def test_start_and_pause(drive, speed):
    driver = drive(speed=speed)
    states = []
    driver.on_state.append(lambda driver: states.append(driver.state))
    for _ in range(2):
        done(driver.start())
        assert runs(driver)
        done(driver.pause())
        steps = driver.runner.n_steps
        assert not driver.runner.is_running
        rounds(driver)
        assert driver.runner.n_steps == steps
    driver.close(SOON)
    assert states == ["running", "paused", "running", "paused", "closed"]


def test_it_gives_the_same_as_a_run(drive):
    driver = drive(simulation(measure=True), speed=math.inf)
    done(driver.step())
    done(driver.step_stage())
    done(driver.start())
    assert runs(driver, 20)
    done(driver.pause())
    alone = simulation(measure=True).run(driver.runner.n_steps)
    np.testing.assert_array_equal(driver.runner.trace.pose_measured, alone.pose_measured)
    np.testing.assert_array_equal(driver.runner.trace.u, alone.u)


def test_commands_of_many_threads_are_done_one_after_another_between_steps(drive):
    driver = drive(speed=math.inf)
    done(driver.start())
    inside, seen = [], []

    def look():
        inside.append(1)
        assert inside == [1]
        assert not driver.runner.is_running
        seen.append(driver.runner.last_step.k)
        inside.pop()

    def ask():
        for future in [driver.call(look) for _ in range(50)]:
            done(future)

    together(ask, ask, ask)
    assert len(seen) == 150
    assert seen == sorted(seen)


def test_a_call_gives_its_result_or_its_exception(drive):
    driver = drive()
    assert done(driver.call(lambda: 7)) == 7
    with pytest.raises(ZeroDivisionError):
        done(driver.call(lambda: 1 / 0))
    assert driver.state == "paused"


def test_prepare_shows_the_start_before_the_first_step_if_there_is_a_frame(drive):
    for runner, expected in ((simulation(), [0]), (experiment(frames()), [])):
        driver = drive(runner)
        shown = []
        driver.on_step.append(lambda step, shown=shown: shown.append(step.k))
        done(driver.prepare())
        assert shown == expected
        done(driver.step())
        assert shown == [*expected, 0]
        assert driver.state == "paused"


# Stages

STAGES = ["world", "estimate_parameters", "measure", "estimate_state", "control"]
ONCE = ["define_model", "init_parameter_estimator", "adjust_background"]


def all_on():
    return simulation(
        measure=True,
        estimate_parameters=True,
        estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(),
        control=lambda step: (0.1, 0.1),
    )


def test_stages_come_in_their_order_and_step_finishes_a_step(drive):
    driver = drive(all_on())
    stages = []
    driver.on_stage.append(lambda stage, step: stages.append((step.k, stage)))
    for _ in range(7):
        done(driver.step_stage())
    assert stages == [(0, stage) for stage in STAGES] + [(1, stage) for stage in STAGES[:2]]
    assert driver.runner.n_steps == 1
    done(driver.step())
    assert driver.runner.n_steps == 2
    assert driver.runner.stage == "world"


def animated_stages(driver, clock, count):
    """Run from stage to stage: after each the clock is moved on."""
    stages = []
    driver.on_stage.append(lambda stage, step: stages.append(stage))
    driver.animates = True
    done(driver.start())
    for n in range(1, count + 1):
        clock.advance(driver, 0.3)
        wait_for(lambda n=n: len(stages) == n)
    done(driver.pause())
    return stages


def test_animated_it_goes_from_stage_to_stage_and_step_by_step_again(drive, clock):
    driver = drive(all_on(), speed=math.inf)
    done(driver.prepare())
    stages = animated_stages(driver, clock, 3 + 5 + 2)
    assert stages == [*ONCE, *STAGES, *STAGES[:2]]
    done(driver.start())
    clock.advance(driver, 0.29)
    assert len(stages) == 10  # it stands for 0.3 s
    driver.animates = False
    assert runs(driver, 5)
    assert len(stages) == 10


def test_what_comes_once_is_watched_at_the_start_and_after_a_reset_alone(drive, clock):
    driver = drive(all_on())
    done(driver.prepare())
    done(driver.step())
    assert animated_stages(driver, clock, 2) == STAGES[:2]
    done(driver.prepare())  # as another panel of the same run
    assert animated_stages(driver, clock, 1) == STAGES[2:3]
    done(driver.reset())
    assert animated_stages(driver, clock, 4) == [*ONCE, STAGES[0]]
    driver = drive(experiment(frames()))
    done(driver.prepare())
    assert animated_stages(driver, clock, 3) == [*ONCE[:2], STAGES[0]]


# Pace


def test_a_change_of_speed_counts_at_once(drive, clock):
    driver = drive(speed=1e-4)  # 2000 s for a step
    driver.start()
    assert runs(driver, 1)
    clock.advance(driver, 1999)
    assert driver.runner.n_steps == 1
    clock.advance(driver, 2)
    assert runs(driver, 2 - driver.runner.n_steps)
    driver.speed = math.inf
    assert runs(driver)
    driver.speed = 1e-4
    done(driver.call(lambda: None))
    steps = driver.runner.n_steps
    rounds(driver)
    assert driver.runner.n_steps <= steps + 1


def test_what_was_held_up_is_not_made_up_for(drive, clock):
    driver = drive(speed=20.0)  # 10 ms for a step of 0.2 s
    driver.start()
    assert runs(driver, 1)
    clock.advance(driver, 100.0)
    wait_for(lambda: driver.runner.n_steps > 10)  # 0.1 s are made up for
    rounds(driver)
    assert driver.runner.n_steps <= 13


def test_a_gap_in_a_record_is_not_waited_for(drive, clock):
    observations = [robsim.Observation(measurement=(k, 0, 0), t=1e4 * k) for k in range(4)]
    model = robsim.RobotParameters(dt=1e4)
    driver = drive(robsim.Experiment(observations, measure=True, model=model), speed=1.0)
    driver.start()
    for n in range(1, 5):
        wait_for(lambda n=n: driver.runner.n_steps == n)
        clock.advance(driver, 2.0)
    wait_for(lambda: driver.state == "ended")


def test_a_live_camera_sets_the_pace(drive):
    source = SteppedCamera([IMAGE] * 20)
    source.permits.release()
    with robsim.Camera(source, open_timeout=SOON) as camera:
        driver = drive(experiment(camera), speed=1e-4)
        assert driver.is_live
        driver.start()
        for steps in range(1, 4):
            wait_for(lambda steps=steps: driver.runner.n_steps == steps)
            source.permits.release()
        assert driver.close(SOON)


# Errors


def test_an_error_pauses_and_the_next_start_repeats_the_stage(drive):
    calls, is_broken = [], [True]

    def control(step):
        calls.append(step.k)
        return 1 / (step.k != 17 or not is_broken), 0.1

    driver = drive(simulation(control=control), speed=math.inf)
    driver.start()
    wait_for(lambda: driver.state == "failed")
    assert isinstance(driver.error, ZeroDivisionError)
    assert (driver.error.callback.slot, driver.error.callback.k) == ("control", 17)
    done(driver.pause())
    assert driver.state == "failed"  # the error is still to be seen
    driver.start()
    wait_for(lambda: calls[-2:] == [17, 17] and driver.state == "failed")
    is_broken.clear()
    done(driver.start())
    assert driver.error is None
    wait_for(lambda: driver.runner.n_steps > 20)
    assert calls[:20] == [*range(18), 17, 17]


def test_a_mistake_in_a_listener_is_told_once_and_the_run_goes_on(drive, mistakes):
    driver = drive(speed=math.inf)
    driver.on_step.append(lambda step: 1 / 0)
    driver.on_state.append(lambda driver: {}["nothing"])
    driver.start()
    assert runs(driver, 10)
    done(driver.pause())
    assert sorted(type(error).__name__ for error in mistakes) == ["KeyError", "ZeroDivisionError"]
    assert driver.state == "paused"


# Waiting for a frame


@pytest.fixture
def camera():
    """A camera that shows one frame, and then none for long."""
    source = SteppedCamera([IMAGE] * 20)
    source.permits.release()
    with robsim.Camera(source, open_timeout=SOON) as camera:
        camera.permits = source.permits
        yield camera


@pytest.fixture
def waiting(drive, camera):
    """Return a function that makes a driver with motors whose run waits for the second frame."""

    def make(*, animates):
        motors = Sender()
        control = lambda step: (1, 2)  # noqa: E731
        driver = drive(experiment(camera, send=motors, control=control))
        driver.motors, driver.looks = motors, []
        look_up = driver._look_up
        driver._look_up = lambda n: driver.looks.append(n) or look_up(n)
        done(driver.step())
        assert driver.motors.sent == [(1, 2)]
        driver.animates = animates
        driver.start()
        wait_for(lambda: driver.runner.is_running)
        return driver

    return make


@pytest.mark.long
@pytest.mark.parametrize(
    ("command", "animates"), [("pause", True), ("pause", False), ("step", False), ("reset", True)]
)
def test_a_wait_for_a_frame_is_cut(waiting, camera, command, animates):
    driver = waiting(animates=animates)
    future = getattr(driver, command)()
    if command == "step":
        wait_for(lambda: driver.state == "paused")
        camera.permits.release()
    done(future)
    assert driver.error is None
    assert driver.state == "paused"
    assert driver.motors.sent[1:3] == [(0, 0), (0, 0)]


@pytest.mark.long
def test_a_look_or_a_setting_does_not_stop_the_robot(waiting, camera):
    driver = waiting(animates=False)
    future = driver.call(lambda: driver.runner.n_steps)
    looks = len(driver.looks)
    wait_for(lambda: len(driver.looks) >= looks + 2)
    assert not future.done()
    assert driver.motors.sent == [(1, 2)]
    camera.permits.release()
    assert done(future) == 2
    assert (0, 0) not in driver.motors.sent


def test_without_motors_nothing_waits_for_a_frame(drive, camera):
    driver = drive(experiment(camera))
    driver.start()
    wait_for(lambda: driver.runner.n_steps == 1 and driver.runner.is_running)
    assert done(driver.call(lambda: 7)) == 7
    assert (driver.state, driver.error) == ("running", None)
    camera.permits.release()
    wait_for(lambda: driver.runner.n_steps == 2)


@pytest.mark.long
def test_closing_does_not_wait_for_a_frame(waiting):
    driver = waiting(animates=True)
    assert driver.close(SOON)
    assert driver.state == "closed"
    assert driver.motors.sent[1:] == [(0, 0), (0, 0)]


def test_a_command_that_comes_just_before_a_run_is_not_lost(drive, camera, monkeypatch):
    """Between the look for commands and the begin of the run, nothing can be stopped yet."""
    driver = drive(experiment(camera))
    prepare, paused = driver.runner._prepare, []

    def prepare_slowly():
        if driver.runner.n_steps and not paused:
            with in_thread(lambda: paused.append(driver.pause())):
                pass
        prepare()

    monkeypatch.setattr(driver.runner, "_prepare", prepare_slowly)
    driver.start()
    wait_for(lambda: paused)
    done(paused[0])
    assert driver.state == "paused"


# The end


def test_commands_that_wait_are_cancelled_and_later_ones_too(drive):
    driver, inside, may_end = drive(), threading.Event(), threading.Event()
    under_way = driver.call(lambda: (inside.set(), may_end.wait(SOON)))
    inside.wait(SOON)
    waiting = [driver.start(), driver.reset(), driver.call(lambda: 1)]
    assert not driver.close(0)
    may_end.set()
    assert driver.close(SOON)
    assert under_way.result(0)[1]
    for future in (*waiting, driver.step()):
        with pytest.raises(CancelledError):
            done(future)
    assert driver.state == "closed"
    assert driver.close()


def test_closing_from_the_run_itself(drive):
    closed = []

    def control(step):
        closed.append(driver.close())
        return 0, 0

    driver = drive(simulation(control=control))
    driver.step()
    wait_for(lambda: driver.state == "closed")
    assert closed == [False]
    assert driver.runner.n_steps == 1
    assert driver.close(SOON)


def test_closing_from_many_threads_and_in_the_midst_of_a_reset(drive):
    driver = drive(speed=math.inf)
    driver.start()
    runs(driver)
    driver.reset()
    closes = [lambda: driver.close(SOON)] * 3
    together(*closes, driver.reset, driver.start, driver.pause)
    assert driver.state == "closed"


def test_a_callback_cannot_wait_for_its_own_run(drive):
    refused = []

    def control(step):
        future = driver.pause()
        for wait in (future.result, future.exception):
            try:
                wait()
            except RuntimeError as error:
                refused.append(error)
        return 0, 0

    driver = drive(simulation(control=control))
    driver.start()
    wait_for(lambda: driver.state == "paused" and driver.runner.n_steps)
    assert len(refused) == 2 * driver.runner.n_steps


def test_a_thread_without_work_ends_and_one_that_is_forgotten_is_collected(monkeypatch):
    monkeypatch.setattr(_worker, "_IDLE", 0.02)

    def use():
        driver = Driver(simulation())
        driver.on_state.append(lambda _: driver)  # a cycle
        for steps in range(1, 3):
            done(driver.step())
            wait_for(lambda: driver._thread is None)  # another one begins with the next command
            assert driver.runner.n_steps == steps
        return weakref.ref(driver)

    gone = use()
    wait_for(lambda: gc.collect() is not None and gone() is None)


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_is_told_that_the_run_is_not_its_own(drive):
    driver = drive(speed=math.inf)
    driver.start()
    runs(driver)
    child = os.fork()
    if child == 0:
        code = 1
        try:
            try:
                driver.pause()
            except RuntimeError as error:
                code = 0 if "forked" in str(error) and driver.close() else 2
            _worker.close_all()
        finally:
            os._exit(code)
    assert os.waitpid(child, 0)[1] == 0
    assert runs(driver)
