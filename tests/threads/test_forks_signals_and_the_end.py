"""Forks, signals and the end of Python while a run is under way in some thread."""

import os
import signal
import subprocess
import sys

import pytest

import robsim
import surroundings
from sizes import thorough
from threads import forks, in_fork, running

pytestmark = [
    pytest.mark.threads,
    pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning"),
]

OPTIONS = {
    "measure": True,
    "estimate_parameters": True,
    "area": (300, 300),
    "resolution": (75, 75),
    "seed": 1,
}


def python(code):
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False
    )
    return done.returncode, done.stdout, done.stderr


def told(look):
    try:
        look()
    except RuntimeError as error:
        return str(error)
    return "done"


@forks
def test_a_forked_process_is_told_that_the_run_is_not_its_own():
    sim = robsim.Simulation(control=robsim.DriveAround(), **OPTIONS)
    sim.run(5)
    estimator = sim.estimator

    def look():
        for use in (lambda: sim.run(3), sim.step, sim.reset, lambda: sim.last_step):
            assert "when the process was forked" in told(use)
        for use in (lambda: estimator.theta, estimator.reset):
            assert "when the process was forked" in told(use)
        assert not sim.is_running
        assert not sim.stop()
        own = robsim.Simulation(control=robsim.DriveAround(), **OPTIONS)
        with running(own, 10**9):  # its thread never has the number of one of the parent's
            assert "another thread is running" in told(lambda: own.last_step)
            assert "when the process was forked" in told(lambda: sim.last_step)
        assert len(own.run(3)) > 3

    with running(sim, 10**9):
        in_fork(look)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_callback_may_fork_and_both_processes_go_on():
    children = []

    def control(step):
        if step.k == 2:
            children.append(os.fork())
        return 0.3, 0.1

    sim = robsim.Simulation(control=control, **OPTIONS)
    try:
        trace = sim.run(6)
    finally:
        if children == [0]:
            os._exit(0 if sim.n_steps == 6 and not sim.is_running else 1)
    assert len(trace) == 6
    assert os.waitpid(children[0], 0)[1] == 0


DAEMON = """
import threading, time, robsim
sim = robsim.Simulation(measure=True, area=(300, 300), resolution=(75, 75), {options})
threading.Thread(target=lambda: sim.run(10**9), daemon=True).start()
while not sim.n_steps:
    time.sleep(0.001)
"""


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.long
@pytest.mark.skipif(
    surroundings.ADDRESS_SANITIZER, reason="it takes a thread that Python ends for a fault"
)
@pytest.mark.parametrize("options", ["", "control=lambda step: (0, 0), time_limit=300"])
def test_the_end_of_python_during_a_run(options):
    assert python(DAEMON.format(options=options)) == (0, "", "")


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.long
def test_the_end_of_python_during_native_work_in_another_thread():
    """Python tears a daemon thread that comes back to it out of its calls: no abort."""
    code = """
import threading
import numpy as np
import robsim
frame = robsim.Frame(np.zeros((1500, 1500, 3), np.uint8))
colors, markers = robsim.load_colors(), robsim.load_robot().marker_layout()
works = threading.Event()
def work():
    while True:
        robsim.find_blobs(frame, colors, markers=markers)
        works.set()
threading.Thread(target=work, daemon=True).start()
works.wait()
"""
    assert python(code) == (0, "", "")


RUNNING = """
import threading, time
import robsim
def drive(i):
    control = None if {native} else lambda step: (0.0, 0.0)
    sim = robsim.Simulation(seed=i, resolution=(200, 200), measure=i % 2 == 0, control=control)
    if {begins}:
        begun.release()
    sim.run(3)
    begun.release()
    sim.run(10**9)
begun = threading.Semaphore(0)
for i in range(4):
    threading.Thread(target=drive, args=(i,), daemon=True).start()
for i in range(4):
    begun.acquire()
"""


@pytest.mark.parametrize("native", [True, False])
@pytest.mark.parametrize("begins", [True, False])
def test_the_end_of_python_while_daemon_threads_drive(native, begins):
    """In the middle of the run, or of its first scenes: the program ends with status 0."""
    for _ in range(thorough(6, 1)):
        assert python(RUNNING.format(native=native, begins=begins)) == (0, "", "")


LATE = """
import atexit
atexit.register(lambda: print(len(sim.run(2_000_000))))  # after the handler of robsim
import robsim
sim = robsim.Simulation()
"""


def test_the_thread_that_ends_python_may_still_run():
    assert python(LATE) == (0, "2000000\n", "")


IMPORTING = """
import threading
threading.Thread(target=lambda: __import__("robsim").Simulation().run(5), daemon=True).start()
"""


def test_the_end_of_python_while_a_daemon_thread_imports():
    for _ in range(thorough(6, 1)):
        assert python(IMPORTING)[::2] == (0, "")


SIGNALS = """
import faulthandler, os, signal, tempfile
import robsim

def run(steps):
    def control(step):
        for one in (signal.SIGUSR1, signal.SIGUSR2, signal.SIGURG):
            os.kill(os.getpid(), one)  # not ours: no reason to end anything
        return 0, 0
    robsim.Simulation(control=control, time_limit=300).run(steps)

own = []
signal.signal(signal.SIGUSR1, lambda *_: own.append(1))
with tempfile.TemporaryFile() as log:
    faulthandler.register(signal.SIGUSR2, file=log, all_threads=False)
    faulthandler.register(signal.SIGURG, file=log, all_threads=False)
    run(3)
    os.kill(os.getpid(), signal.SIGURG)
    os.kill(os.getpid(), signal.SIGUSR2)
    log.seek(0)
    print(len(own), log.read().count(b"most recent call first"))
    faulthandler.unregister(signal.SIGURG)

signal.signal(signal.SIGURG, lambda *_: own.append(2))
run(3)
os.kill(os.getpid(), signal.SIGURG)
print(own.count(2))
"""


@pytest.mark.long
@pytest.mark.skipif(not hasattr(signal, "SIGURG"), reason="needs signals of Unix")
def test_a_time_limit_leaves_all_signals_as_they_were():
    """Handlers that were set in C, of which Python knows nothing, too."""
    # While it runs, that of SIGURG waits if it was set in C: 3 + 2. One of Python's does not: 4.
    assert python(SIGNALS) == (0, "3 5\n4\n", "")


@pytest.mark.long
def test_a_sub_interpreter_is_told_that_it_cannot():
    code = """
import faulthandler
faulthandler.dump_traceback_later(250, exit=True)
try:
    import _interpreters as interpreters
    made = [interpreters.create(kind) for kind in ("isolated", "legacy")]
except ImportError:
    import _xxsubinterpreters as interpreters  # until Python 3.12
    made = [interpreters.create()]
for one in made:
    try:
        print(interpreters.run_string(one, "import robsim; robsim.Simulation"))
    except interpreters.RunFailedError as error:
        print(error)
print("of", len(made))
"""
    status, out, err = python(code)
    assert status == 0, err
    *told, of = out.splitlines()
    assert of == f"of {len(told)}"
    assert all("ImportError" in one and "interpreter" in one for one in told)
