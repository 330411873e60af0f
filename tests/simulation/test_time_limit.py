"""Callbacks that are slow or hang end the run with a clear message."""

import contextlib
import signal
import threading
import time

import pytest

import robsim
from threads import in_thread

pytestmark = pytest.mark.long


SOON = 0.1  # s


LONG = 300  # s, a limit that nothing meets


def endless(*_):
    while True:
        with contextlib.suppress(Exception):
            time.sleep(0)


def sleeping(*_):
    time.sleep(600)


@pytest.mark.parametrize("hang", [endless, sleeping])
def test_a_watchdog_of_many_steps_ends_a_callback_that_hangs(hang):
    started = []

    def other(step):
        started.append(set(threading.enumerate()))
        return 0, 0

    hanging = robsim.Simulation(control=hang, time_limit=SOON)
    right = robsim.Simulation(control=other, time_limit=LONG)
    with hanging._watched(), right._watched():
        for _ in range(3):
            right.step()
        with pytest.raises(TimeoutError, match="time_limit"):
            hanging.step()
        right.step()
    assert started == started[:1] * 4  # no thread of its own for each step
    right.step()
    assert started[-1] != started[0]


@pytest.mark.parametrize("hang", [endless, sleeping])
def test_a_callback_that_hangs_ends_the_run_and_the_trace_is_kept(hang):
    sim = robsim.Simulation(control=robsim.Spin(), time_limit=SOON)
    sim.run(3)
    sim.control = hang
    with pytest.raises(TimeoutError, match=r"time_limit = 0\.1 s") as caught:
        sim.run(10)
    assert caught.value.__notes__ == ["in the callback control at step 3"]
    assert hang.__name__ in [entry.name for entry in caught.traceback]
    assert len(sim.trace) == 3
    sim.control = robsim.Spin()
    assert len(sim.run(5)) == 8


def test_a_callback_that_comes_back_in_time_passes():
    sim = robsim.Simulation(control=lambda step: time.sleep(0.01) or (0, 0), time_limit=LONG)
    assert len(sim.run(5)) == 5


def test_in_another_thread():
    errors = []

    def run():
        try:
            robsim.Simulation(measure=endless, resolution=(64, 64), time_limit=SOON).run(10)
        except TimeoutError as error:
            errors.append(error.__notes__)

    with in_thread(run):
        pass
    assert errors == [["in the callback measure at step 0"]]


def test_nothing_is_left_behind():
    threads, handler = threading.active_count(), signal.getsignal(signal.SIGUSR2)
    with pytest.raises(TimeoutError):
        robsim.Simulation(control=sleeping, time_limit=SOON).run(10)
    assert threading.active_count() == threads
    assert signal.getsignal(signal.SIGUSR2) is handler


def test_what_a_callback_does_wrong_stays_what_it_is():
    def raises(step):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        robsim.Simulation(control=raises, time_limit=LONG).run(1)

    def fast(step):
        return "fast"

    line = fast.__code__.co_firstlineno
    with pytest.raises((TypeError, ValueError), match=f"line {line}, in fast"):
        robsim.Simulation(control=fast, time_limit=LONG).run(1)


def test_a_limit_is_above_zero_and_finite():
    for seconds in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="time_limit"):
            robsim.Simulation(time_limit=seconds)


ONCE = ("define_model", "adjust_background")


STEPS = (("evaluate_model", 1), ("estimate_parameters", 0), ("estimate_state", 0))


class Slow(robsim.Spin):
    def __call__(self, step):
        time.sleep(600)


class SlowEstimator:
    def update(self, phi, y):
        time.sleep(600)


@pytest.mark.parametrize(
    ("options", "note"),
    [
        ({"control": Slow()}, "in the callback control at step 0"),
        (
            {"init_parameter_estimator": lambda model: SlowEstimator()},
            "in the callback estimate_parameters at step 2",
        ),
        *(({slot: sleeping}, f"in the callback {slot} at step {step}") for slot, step in STEPS),
        *(({slot: endless}, f"in the callback {slot} at the start") for slot in ONCE),
    ],
)
def test_every_slot_is_watched(options, note):
    sim = robsim.Simulation(**options, time_limit=SOON)
    with pytest.raises(TimeoutError, match="time_limit") as caught:
        sim.run(5)
    assert caught.value.__notes__ == [note]
    if "define_model" in options:  # it is called by a look at the model, too
        with pytest.raises(TimeoutError):
            _ = sim.model


def test_a_callback_that_catches_everything_is_interrupted_again():
    caught = []

    def stubborn(step):
        while len(caught) < 3:
            try:
                time.sleep(600)
            except BaseException as error:
                caught.append(error)
        return 0, 0

    with pytest.raises(TimeoutError):
        robsim.Simulation(control=stubborn, time_limit=SOON).run(1)
    assert len(caught) == 3


def test_a_run_within_a_run_is_refused_and_leaves_the_limit():
    def control(step):
        with pytest.raises(RuntimeError):
            sim.run(1)
        time.sleep(600)

    sim = robsim.Simulation(control=control, time_limit=SOON)
    with pytest.raises(TimeoutError):
        sim.run(1)
