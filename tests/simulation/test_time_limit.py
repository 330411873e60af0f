"""Callbacks that are slow or hang end the run with a clear message."""

import contextlib
import signal
import threading
import time

import numpy as np
import pytest

import robsim

pytestmark = pytest.mark.long


def endless(step):
    while step.k >= 3:
        with contextlib.suppress(Exception):
            time.sleep(0)
    return 0, 0


def sleeping(step):
    if step.k >= 3:
        time.sleep(20)
    return 0, 0


@pytest.mark.parametrize("control", [endless, sleeping])
def test_a_watchdog_of_many_steps_ends_a_callback_that_hangs(control):
    started = []

    def other(step):
        started.append(set(threading.enumerate()))
        return 0, 0

    hanging = robsim.Simulation(control=control, time_limit=0.2)
    right = robsim.Simulation(control=other, time_limit=5)
    with hanging._watched(), right._watched():
        for _ in range(3):
            hanging.step()
            right.step()
        with pytest.raises(TimeoutError, match=r"longer than time_limit = 0\.2 s"):
            hanging.step()
        right.step()
    assert started == started[:1] * 4  # no thread of its own for each step
    right.step()
    assert started[-1] != started[0]


@pytest.mark.parametrize("control", [endless, sleeping])
def test_a_callback_that_hangs_ends_the_run_and_the_trace_is_kept(control):
    sim = robsim.Simulation(control=control, time_limit=0.2)
    start = time.monotonic()
    with pytest.raises(TimeoutError, match=r"longer than time_limit = 0\.2 s") as caught:
        sim.run(10)
    assert time.monotonic() - start < 15  # it would hang for good
    assert caught.value.__notes__ == ["in the callback control at step 3"]
    assert control.__name__ in [entry.name for entry in caught.traceback]
    assert len(sim.trace) == 3
    sim.control = robsim.Spin()
    assert len(sim.run(5)) == 8


def test_a_slow_callback_that_comes_back_in_time_passes():
    sim = robsim.Simulation(control=lambda step: time.sleep(0.01) or (0, 0), time_limit=30)
    assert len(sim.run(5)) == 5


def test_in_another_thread_and_for_every_slot():
    errors = []

    def unseen(step):
        endless(step)

    def run():
        try:
            robsim.Simulation(measure=unseen, resolution=(64, 64), time_limit=0.2).run(10)
        except TimeoutError as error:
            errors.append(error.__notes__)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join(60)
    assert errors == [["in the callback measure at step 3"]]


def test_an_exception_of_the_callback_stays_what_it_is():
    def control(step):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        robsim.Simulation(control=control, time_limit=5).run(1)


def test_nothing_is_left_behind():
    threads, handler = threading.active_count(), signal.getsignal(signal.SIGUSR2)
    sim = robsim.Simulation(control=sleeping, time_limit=0.1)
    with pytest.raises(TimeoutError):
        sim.run(10)
    assert threading.active_count() == threads
    assert signal.getsignal(signal.SIGUSR2) is handler


def test_a_wrong_result_still_names_the_callback_and_its_line():
    def control(step):
        return "fast"

    line = control.__code__.co_firstlineno
    with pytest.raises((TypeError, ValueError), match=f"line {line}, in control"):
        robsim.Simulation(control=control, time_limit=5).run(1)


@pytest.mark.parametrize(
    ("value", "error"),
    [(0, ValueError), (-1, ValueError), (float("nan"), ValueError), (float("inf"), ValueError),
     ("1", TypeError), (True, TypeError)],
)  # fmt: skip
def test_a_wrong_limit(value, error):
    with pytest.raises(error, match="time_limit must be"):
        robsim.Simulation(time_limit=value)


class Slow(robsim.Spin):
    def __call__(self, step):
        time.sleep(20)


class SlowEstimator:
    def update(self, phi, y):
        time.sleep(20)


@pytest.mark.parametrize(
    ("options", "note"),
    [
        ({"control": Slow()}, "in the callback control at step 0"),
        (
            {"init_parameter_estimator": lambda model: SlowEstimator()},
            "in the callback estimate_parameters at step 2",
        ),
    ],
)
def test_own_kinds_of_native_stages_are_watched(options, note):
    sim = robsim.Simulation(**options, time_limit=0.2)
    with pytest.raises(TimeoutError) as caught:
        sim.run(5)
    assert caught.value.__notes__ == [note]


def test_the_other_stages_stay_what_they_are():
    sim = robsim.Simulation(
        init_parameter_estimator=lambda model: robsim.RecursiveLeastSquares(5, n_filters=3),
        measure=True,
        time_limit=30,
        seed=1,
    )
    trace = sim.run(6)
    assert trace.seen.all()
    assert np.isfinite(trace.parameters[-1]).all()


@pytest.mark.parametrize("slot", ["evaluate_model", "estimate_parameters", "estimate_state"])
def test_every_slot_is_watched(slot):
    def hang(_):
        time.sleep(20)

    sim = robsim.Simulation(**{slot: hang}, time_limit=0.2)
    with pytest.raises(TimeoutError) as caught:
        sim.run(2)
    step = 1 if slot == "evaluate_model" else 0
    assert caught.value.__notes__ == [f"in the callback {slot} at step {step}"]


def test_what_is_called_by_a_look_at_the_model_is_watched():
    def hang():
        while True:
            time.sleep(0)

    with pytest.raises(TimeoutError):
        _ = robsim.Simulation(define_model=hang, time_limit=0.2).model


@pytest.mark.parametrize("slot", ["define_model", "adjust_background"])
def test_what_is_called_once_is_watched_too(slot):
    def hang(*_):
        while True:
            time.sleep(0)

    sim = robsim.Simulation(**{slot: hang}, time_limit=0.2)
    with pytest.raises(TimeoutError, match=r"longer than time_limit = 0\.2 s") as caught:
        sim.run(1)
    assert caught.value.__notes__ == [f"in the callback {slot} at the start"]


def test_a_callback_that_catches_everything_is_interrupted_again():
    def stubborn(step):
        for _ in range(3):
            with contextlib.suppress(BaseException):
                time.sleep(20)
        return 0, 0

    start = time.monotonic()
    with pytest.raises(TimeoutError):
        robsim.Simulation(control=stubborn, time_limit=0.2).run(1)
    assert time.monotonic() - start < 40  # one interrupt would leave 40 s


def test_a_run_within_a_run_is_refused_and_leaves_the_limit():
    def control(step):
        with pytest.raises(RuntimeError):
            sim.run(1)
        time.sleep(20)

    sim = robsim.Simulation(control=control, time_limit=0.2)
    with pytest.raises(TimeoutError):
        sim.run(1)
