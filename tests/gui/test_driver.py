"""The thread that runs: commands from any thread, pace, stages, errors, and its own end."""

import gc
import math
import os
import threading
import time
import weakref
from concurrent.futures import CancelledError

import numpy as np
import pytest

import robsim
from python_cameras import SteppedCamera
from robsim.gui import _driver, _worker
from robsim.gui._driver import Driver
from threads import in_thread, together
from waiting import wait_for

pytestmark = pytest.mark.threads

SMALL = {"area": (300, 300), "resolution": (75, 75), "seed": 1}
SOON = 10  # s
IMAGE = np.zeros((64, 64, 3), np.uint8)


@pytest.fixture(autouse=True)
def no_thread_survives():
    before = set(threading.enumerate())
    yield
    for thread in set(threading.enumerate()) - before:
        thread.join(SOON)
        assert not thread.is_alive()


@pytest.fixture
def drive():
    """Return a function that makes a driver, which is closed at the end."""
    drivers = []

    def make(runner=None, **options):
        drivers.append(Driver(simulation() if runner is None else runner, **options))
        return drivers[-1]

    yield make
    for driver in drivers:
        assert driver.close()


def simulation(**options):
    return robsim.Simulation(**{"control": robsim.DriveAround(), **SMALL, **options})


def frames(count=5):
    return [robsim.Frame(IMAGE, index=k) for k in range(count)]


def experiment(source, **options):
    return robsim.Experiment(source, **{"area": (64, 64), "measure": False, **options})


def done(future):
    return future.result(SOON)


def runs(driver, steps=3):
    before = driver.runner.n_steps
    wait_for(lambda: driver.runner.n_steps >= before + steps)
    return True


# Commands


@pytest.mark.long
@pytest.mark.parametrize("speed", [1000.0, math.inf])
@pytest.mark.parametrize("callback", [None, lambda step: (0.1, 0.2)])
def test_start_and_pause(drive, speed, callback):
    driver = drive(simulation(control=callback), speed=speed)
    states = []
    driver.on_state.append(lambda driver: states.append(driver.state))
    done(driver.start())
    assert runs(driver)
    done(driver.pause())
    steps = driver.runner.n_steps
    assert not driver.runner.is_running
    time.sleep(0.05)
    assert driver.runner.n_steps == steps
    done(driver.start())
    assert runs(driver)
    driver.close()
    assert states == ["running", "paused", "running", "closed"]


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


def test_step_pauses_and_shows_the_step(drive):
    driver = drive()
    shown = []
    driver.on_step.append(lambda step: shown.append(step.k))
    driver.start()
    runs(driver, 1)
    done(driver.step())
    assert driver.state == "paused"
    before = driver.runner.n_steps
    done(driver.step())
    assert driver.runner.n_steps == before + 1
    assert shown == [*range(before + 1)]


def test_prepare_shows_the_start_before_the_first_step(drive):
    driver = drive()
    shown = []
    driver.on_step.append(lambda step: shown.append((step.k, step.frame is None)))
    done(driver.prepare())
    assert shown == [(0, False)]
    assert driver.runner.n_steps == 0


def test_an_experiment_has_nothing_to_show_before_its_first_frame(drive):
    driver = drive(experiment(frames()))
    shown, told = [], []
    driver.on_step.append(shown.append)
    driver.on_state.append(told.append)
    done(driver.prepare())
    assert (shown, told, driver.state) == ([], [driver], "paused")


def test_reset_goes_back_to_the_start(drive):
    driver = drive(speed=math.inf)
    driver.start()
    runs(driver)
    done(driver.reset())
    assert (driver.runner.n_steps, driver.state) == (0, "paused")
    done(driver.step())
    assert driver.runner.last_step.k == 0


@pytest.mark.parametrize("speed", [0, -1.0, math.nan, -math.inf])
def test_a_speed_that_is_none_is_refused_and_leaves_no_thread(speed):
    with pytest.raises(ValueError, match="speed must be"):
        Driver(simulation(), speed=speed)


# Stages

STAGES = ["world", "estimate_parameters", "measure", "estimate_state", "control"]
ONCE = ["define_model", "init_parameter_estimator", "adjust_background"]


def all_on():
    return simulation(
        measure=True,
        estimate_parameters=True,
        estimate_state=robsim.reference.ExtendedKalmanFilter(),
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


@pytest.mark.long
def test_animated_it_goes_from_stage_to_stage_and_step_by_step_again(drive, monkeypatch):
    monkeypatch.setattr(_driver, "_STAGE_PAUSE", 0.01)
    driver = drive(all_on(), speed=math.inf)
    stages, steps = [], []
    done(driver.prepare())
    driver.on_stage.append(lambda stage, step: stages.append(stage))
    driver.on_step.append(lambda step: steps.append(step.k))
    driver.animates = True
    done(driver.start())
    wait_for(lambda: len(stages) > 10)
    done(driver.pause())
    assert stages[:3] == ONCE
    of_steps = stages[3:]
    assert of_steps == [STAGES[i % 5] for i in range(len(of_steps))]
    assert steps == [*range(len(of_steps) // 5)]
    count = len(stages)
    driver.animates = False
    done(driver.start())
    assert runs(driver, 5)
    assert len(stages) == count


def animated_stages(driver, monkeypatch, count):
    monkeypatch.setattr(_driver, "_STAGE_PAUSE", 0.01)
    stages = []
    driver.on_stage.append(lambda stage, step: stages.append(stage))
    driver.animates = True
    done(driver.start())
    wait_for(lambda: len(stages) >= count)
    done(driver.pause())
    return stages[:count]


def test_what_came_once_is_watched_before_the_first_step_alone(drive, monkeypatch):
    driver = drive(all_on())
    done(driver.prepare())
    done(driver.step())
    assert animated_stages(driver, monkeypatch, 2) == STAGES[:2]
    done(driver.prepare())  # as another panel of the same run
    assert animated_stages(driver, monkeypatch, 1) == STAGES[2:3]


def test_what_comes_once_is_watched_again_after_a_reset(drive, monkeypatch):
    driver = drive(all_on())
    done(driver.step())
    done(driver.reset())
    assert animated_stages(driver, monkeypatch, 4) == [*ONCE, STAGES[0]]


def test_an_experiment_shows_what_it_calls_once(drive, monkeypatch):
    driver = drive(experiment(frames()))
    done(driver.prepare())
    assert animated_stages(driver, monkeypatch, 3) == [*ONCE[:2], STAGES[0]]


def test_animation_starts_and_ends_while_it_runs(drive, monkeypatch):
    monkeypatch.setattr(_driver, "_STAGE_PAUSE", 1000.0)
    driver = drive(speed=math.inf)
    done(driver.start())
    assert runs(driver)
    driver.animates = True
    done(driver.call(lambda: None))
    steps = driver.runner.n_steps
    time.sleep(0.03)
    assert driver.runner.n_steps == steps
    driver.animates = False
    assert runs(driver)


# Pace


def test_a_change_of_speed_counts_at_once(drive):
    driver = drive(speed=1e-4)  # 2000 s for a step
    driver.start()
    assert runs(driver, 1)
    time.sleep(0.02)
    assert driver.runner.n_steps == 1
    driver.speed = math.inf
    assert runs(driver)
    driver.speed = 1e-4
    done(driver.call(lambda: None))
    steps = driver.runner.n_steps
    time.sleep(0.03)
    assert driver.runner.n_steps <= steps + 1


@pytest.mark.long
def test_what_was_held_up_is_not_made_up_for(drive):
    driver = drive(speed=20.0)  # 10 ms for a step of 0.2 s
    times = []
    driver.on_step.append(lambda step: times.append(time.monotonic()))
    driver.start()
    assert runs(driver, 3)
    done(driver.call(lambda: time.sleep(0.5)))
    held, before = time.monotonic(), len(times)
    assert runs(driver, 3)
    after = len(times) - before
    assert after <= (times[-1] - held + 2 * _driver._CATCH_UP) / 0.01 + 2  # and not 50 more
    driver.speed = 1e-4
    time.sleep(0.02)
    driver.speed = 20.0
    assert runs(driver, 1)


def test_a_gap_in_a_record_is_not_waited_for(drive, monkeypatch):
    monkeypatch.setattr(_driver, "_LONGEST_GAP", 0.01)
    observations = [robsim.Observation(measurement=(k, 0, 0), t=1e4 * k) for k in range(4)]
    model = robsim.RobotParameters(dt=1e4)
    driver = drive(robsim.Experiment(observations, measure=True, model=model), speed=1.0)
    driver.start()
    wait_for(lambda: driver.state == "ended")
    assert driver.runner.n_steps == 4


def test_a_live_camera_sets_the_pace(drive):
    source = SteppedCamera([IMAGE] * 20)
    source.permits.release()
    with robsim.Camera(source, open_timeout=SOON) as camera:
        driver = drive(experiment(camera), speed=1e-4)
        assert driver.is_live
        driver.start()
        for steps in range(1, 6):
            wait_for(lambda steps=steps: driver.runner.n_steps == steps)
            source.permits.release()
        assert driver.close()


# Errors


class Fragile:
    """A controller that fails at a step until it is mended."""

    def __init__(self, k):
        self.k = k
        self.calls = []

    def __call__(self, step):
        self.calls.append(step.k)
        if step.k == self.k:
            raise ZeroDivisionError("of the test")
        return 0.1, 0.1


@pytest.mark.parametrize("speed", [1000.0, math.inf])
def test_an_error_pauses_and_the_next_start_repeats_the_stage(drive, speed):
    control = Fragile(37)
    driver = drive(simulation(control=control), speed=speed)
    driver.start()
    wait_for(lambda: driver.state == "failed")
    assert isinstance(driver.error, ZeroDivisionError)
    assert driver.error.callback.slot == "control"
    assert (driver.error.callback.k, driver.runner.n_steps) == (37, 37)
    driver.start()
    wait_for(lambda: control.calls[-2:] == [37, 37] and driver.state == "failed")
    control.k = None
    done(driver.start())
    assert driver.error is None
    wait_for(lambda: driver.runner.n_steps > 45)
    assert control.calls[:40] == [*range(38), 37, 37]


def test_a_mended_callback_is_put_in_between_two_steps(drive):
    driver = drive(simulation(control=Fragile(0)))
    done(driver.step())
    assert driver.state == "failed"
    done(driver.pause())
    assert driver.state == "failed"  # the error is still to be seen

    def mend():
        driver.runner.control = lambda step: (0, 0)

    done(driver.call(mend))
    done(driver.step())
    assert (driver.state, driver.error, driver.runner.n_steps) == ("paused", None, 1)


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, EOFError, RuntimeError])
def test_whatever_a_callback_raises_is_its_error(drive, error):
    def control(step):
        raise error

    driver = drive(simulation(control=control))
    done(driver.step())
    assert driver.state == "failed"
    assert isinstance(driver.error, error)
    assert done(driver.call(lambda: 1)) == 1


def test_an_error_at_the_start_and_one_of_the_set_up(drive):
    driver = drive(simulation(define_model=lambda: 1 / 0))
    done(driver.prepare())
    assert driver.error.callback.slot == "define_model"
    driver = drive(simulation(estimate_parameters=True, measure=False, identify_from="measurement"))
    done(driver.start())
    wait_for(lambda: driver.state == "failed")
    assert "identify_from" in str(driver.error)


def test_frames_end_and_reset_begins_again_if_they_can(drive):
    driver = drive(experiment(frames(3)), speed=math.inf)
    driver.start()
    wait_for(lambda: driver.state == "ended")
    assert (driver.runner.n_steps, driver.error) == (3, None)
    driver.start()
    done(driver.call(lambda: None))
    wait_for(lambda: driver.state == "ended")
    done(driver.reset())
    assert (driver.runner.n_steps, driver.state) == (0, "paused")
    done(driver.step())
    assert driver.runner.n_steps == 1


def test_frames_that_come_once_cannot_be_reset(drive):
    driver = drive(experiment(iter(frames(3))))
    done(driver.step())
    with pytest.raises(RuntimeError, match="can be read only once"):
        done(driver.reset())
    done(driver.step())
    assert driver.runner.n_steps == 2


def test_a_mistake_in_a_listener_is_told_once_and_the_run_goes_on(drive, monkeypatch):
    told = []
    monkeypatch.setattr(threading, "excepthook", lambda about: told.append(about.exc_value))
    driver = drive(speed=math.inf)
    driver.on_step.append(lambda step: 1 / 0)
    driver.on_state.append(lambda driver: {}["nothing"])
    driver.start()
    assert runs(driver, 10)
    done(driver.pause())
    assert sorted(type(error).__name__ for error in told) == ["KeyError", "ZeroDivisionError"]
    assert driver.state == "paused"


# Waiting for a frame


class Motors:
    def __init__(self):
        self.sent = []

    def __call__(self, u):
        self.sent.append(tuple(u))


@pytest.fixture
def camera():
    """A camera that shows one frame, and then none for long."""
    source = SteppedCamera([IMAGE] * 20)
    source.permits.release()
    with robsim.Camera(source, open_timeout=SOON) as camera:
        camera.permits = source.permits
        yield camera


@pytest.fixture(params=["step", "stage"])
def waiting(request, drive, camera):
    """A driver with motors whose run waits for the second frame."""
    options = {"send": Motors(), "control": lambda step: (1, 2), "frame_timeout": 1000}
    driver = drive(experiment(camera, **options))
    driver.motors = options["send"]
    done(driver.step())
    assert driver.motors.sent == [(1, 2)]
    driver.animates = request.param == "stage"
    driver.start()
    wait_for(lambda: driver.runner.is_running)
    return driver


@pytest.mark.long
@pytest.mark.parametrize("command", ["pause", "step", "reset"])
def test_a_wait_for_a_frame_is_cut(waiting, camera, command):
    future = getattr(waiting, command)()
    if command == "step":
        wait_for(lambda: waiting.state == "paused")
        camera.permits.release()
    done(future)
    assert waiting.error is None
    assert waiting.state == "paused"
    assert waiting.motors.sent[1:3] == [(0, 0), (0, 0)]


@pytest.mark.long
def test_a_look_or_a_setting_does_not_stop_the_robot(waiting, camera):
    future = waiting.call(lambda: waiting.runner.n_steps)
    time.sleep(0.12)  # it has looked up twice
    assert not future.done()
    assert waiting.motors.sent == [(1, 2)]
    camera.permits.release()
    done(future)
    assert (0, 0) not in waiting.motors.sent


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
    assert waiting.close()
    assert waiting.state == "closed"
    assert waiting.motors.sent[1:] == [(0, 0), (0, 0)]


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
    assert driver.close()
    assert under_way.result(0)[1]
    for future in (*waiting, driver.step()):
        with pytest.raises(CancelledError):
            done(future)
    assert driver.state == "closed"
    assert driver.close()


def test_closing_from_the_run_itself(drive):
    driver = drive(speed=math.inf)
    closed = []
    driver.on_step.append(lambda step: step.k >= 3 and closed.append(driver.close()))
    driver.start()
    wait_for(lambda: driver.state == "closed")
    assert closed == [False]
    assert driver.close()

    def control(step):
        closed.append(other.close())
        return 0, 0

    other = drive(simulation(control=control))
    other.step()
    wait_for(lambda: other.state == "closed")
    assert closed == [False, False]
    assert other.runner.n_steps == 1


def test_closing_from_many_threads_and_in_the_midst_of_a_reset(drive):
    driver = drive(speed=math.inf)
    driver.start()
    runs(driver)
    driver.reset()
    together(*[lambda: driver.close()] * 3, driver.reset, driver.start, driver.pause)
    assert driver.state == "closed"


def test_closing_one_that_never_ran(drive):
    driver = drive()
    states = []
    driver.on_state.append(lambda driver: states.append(driver.state))
    assert driver.close()
    assert driver.close()
    assert states == ["closed"]


def test_a_callback_that_never_returns_holds_up_nobody_for_long(drive):
    inside, may_end = threading.Event(), threading.Event()

    def control(step):
        inside.set()
        may_end.wait(60)
        return 0, 0

    driver = drive(simulation(control=control))
    driver.start()
    inside.wait(SOON)
    assert not driver.close(0.05)
    assert driver.state == "running"
    may_end.set()
    wait_for(lambda: driver.state == "closed")


def test_a_callback_cannot_wait_for_its_own_run(drive):
    refused = []

    def control(step):
        future = driver.pause()
        for wait in (future.result, future.exception):
            try:
                wait()
            except RuntimeError as error:
                refused.append(str(error))
        return 0, 0

    driver = drive(simulation(control=control))
    driver.start()
    wait_for(lambda: driver.state == "paused" and driver.runner.n_steps)
    assert len(refused) == 2 * driver.runner.n_steps
    assert "cannot wait for a command to its own run" in refused[0]


def test_a_thread_without_work_ends_and_another_one_begins_with_the_next(drive, monkeypatch):
    monkeypatch.setattr(_worker, "_IDLE", 0.02)
    driver = drive()
    for steps in range(1, 3):
        done(driver.step())
        wait_for(lambda: driver._thread is None)
        assert driver.runner.n_steps == steps
    assert driver.state == "paused"


def test_one_that_is_forgotten_is_collected(monkeypatch):
    monkeypatch.setattr(_worker, "_IDLE", 0.02)

    def use():
        driver = Driver(simulation())
        driver.on_state.append(lambda _: driver)  # a cycle
        done(driver.step())
        wait_for(lambda: driver._thread is None)
        return weakref.ref(driver)

    gone = use()
    gc.collect()
    assert gone() is None


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
