"""A Python as in a browser (Pyodide), without tornado and without threads."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

BROWSER = """
import runpy, sys, sysconfig, threading

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("tornado", "resource"):
            raise ModuleNotFoundError(name)

def start(thread):
    raise RuntimeError("can't start new thread")

sysconfig.get_config_vars()  # of this system, before it is another one
sys.meta_path.insert(0, Missing())
sys.platform, threading.Thread.start = "emscripten", start
import robsim
"""


def run_there(program):
    done = subprocess.run(
        [sys.executable, "-c", BROWSER + program], capture_output=True, text=True, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.long
def test_a_run_with_estimates_and_a_figure_needs_neither():
    printed = run_there("""
sim = robsim.Simulation(control=robsim.DriveAround(), measure=True, headings=None, seed=1)
trace = sim.run(300)
fit = robsim.batch_estimate(trace)
robsim.plot_traces(trace)
robsim.campaign(metrics="tracking", runs=2, steps=20, progress=False)
print(len(trace), bool(trace.seen.all()))
""")
    assert printed == "300 True\n"


@pytest.mark.long
@pytest.mark.kernels
def test_the_digests_are_those_of_every_system():
    assert "bytes" in run_there(f"""
sys.argv = [{str(ROOT / "tests/digests")!r}]
sys.path.insert(0, sys.argv[0])
runpy.run_path(sys.argv[0], run_name="__main__")
""")


@pytest.mark.long
def test_other_parts_say_that_they_are_not_here():
    """The panel, cameras, the grader, engines, sessions and limits of time."""
    printed = run_there("""
from robsim.teach.isolation.check import check_isolation
from robsim.trace.sessions.writer import SessionWriter

sim = robsim.Simulation(control=robsim.DriveAround(), seed=1)
for part in (
    lambda: robsim.panel(sim),
    lambda: robsim.Camera(0),
    lambda: robsim.Simulation(time_limit=1.0).run(1),
    lambda: robsim.campaign(metrics="tracking", runs=2, steps=2, executor="threads"),
    lambda: SessionWriter("run.mcap", setup={}),
    check_isolation,
):
    try:
        part()
    except NotImplementedError as error:
        print(str(error).partition(" needs threads")[0])
""")
    assert len(printed.splitlines()) == 6, printed
