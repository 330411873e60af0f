"""Simulations whose callbacks come from a folder."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import robsim
from commands import command

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def new_folder(tmp_path_factory):
    """What `robsim new` writes."""
    place = tmp_path_factory.mktemp("new")
    assert command("new", "mine", cwd=place).exit_code == 0
    return place / "mine"


@pytest.fixture
def folder(tmp_path, new_folder):
    return Path(shutil.copytree(new_folder, tmp_path / "mine"))


def write(folder, slot, text):
    (folder / f"{slot}.py").write_text(text)


def constant(u1, u2):
    return f"def control(step):\n    return {u1}, {u2}\n"


def assert_same(one, other):
    assert one.names == other.names
    for name in one.names:
        np.testing.assert_array_equal(one[name], other[name])


def test_a_file_that_is_switched_off_is_as_good_as_none(folder):
    options = {"seed": 1, "measure": True, "estimate_parameters": True, "resolution": (400, 400)}
    assert_same(
        robsim.Simulation.from_folder(folder, **options).run(10),
        robsim.Simulation(**options).run(10),
    )


def test_an_edited_file_is_picked_up_by_the_next_run(folder):
    sim = robsim.Simulation.from_folder(folder)
    sim.run(3)
    write(folder, "control", constant(0.1, 0.2))
    u = sim.run(3).u
    np.testing.assert_array_equal(u, [(0.05, -0.05)] * 3 + [(0.1, 0.2)] * 3)
    write(folder, "control", constant(0.3, 0.2))
    assert sim.step().k == 6
    assert tuple(sim.trace.u[-1]) == (0.3, 0.2)
    (folder / "control.py").unlink()
    assert tuple(sim.run(1).u[-1]) == (0.05, -0.05)


def test_a_syntax_error_names_file_and_line_and_leaves_the_run_alone(folder):
    sim = robsim.Simulation.from_folder(folder)
    trace = sim.run(5)
    write(folder, "control", "def control(step):\n    return (0.1, 0.2\n")
    for go_on in (lambda: sim.run(5), sim.reset):
        with pytest.raises(SyntaxError) as caught:
            go_on()
        assert caught.value.filename == str(folder / "control.py")
        assert caught.value.lineno == 2
    assert_same(sim.trace, trace)
    write(folder, "control", constant(0, 0))
    assert len(sim.run(5)) == 10


def test_what_comes_once_waits_for_a_reset(folder):
    sim = robsim.Simulation.from_folder(folder)
    sim.run(2)
    write(
        folder,
        "define_model",
        "from robsim import RobotModel, RobotParameters\n"
        "def define_model():\n    return RobotModel(RobotParameters(mass=1))\n",
    )
    with pytest.raises(RuntimeError, match=r"define_model\.py .*sim\.reset"):
        sim.run(2)
    assert len(sim.trace) == 2
    sim.reset()
    sim.run(1)
    heavy = robsim.RobotModel(robsim.RobotParameters(mass=1))
    np.testing.assert_array_equal(sim.model.theta, heavy.theta)


def test_a_reset_starts_the_memory_of_the_files_anew(folder):
    write(
        folder, "control", "n = 0\ndef control(step):\n    global n\n    n += 1\n    return n, n\n"
    )
    sim = robsim.Simulation.from_folder(folder)
    first = sim.run(4)
    sim.reset()
    assert_same(sim.run(4), first)


def test_helpers_are_there_during_the_run(folder):
    (folder / "gains.py").write_text("GAIN = 0.25\n")
    write(
        folder, "control", "def control(step):\n    from gains import GAIN\n    return GAIN, GAIN\n"
    )
    sim = robsim.Simulation.from_folder(folder)
    assert (sim.run(2).u == 0.25).all()
    (folder / "gains.py").write_text("GAIN = 0.75\n")
    assert tuple(sim.run(1).u[-1]) == (0.75, 0.75)


def test_the_time_limit_counts_for_a_folder_too(folder):
    write(folder, "control", "import time\ndef control(step):\n    time.sleep(600)\n")
    sim = robsim.Simulation.from_folder(folder, time_limit=0.1)
    with pytest.raises(TimeoutError, match="time_limit"):
        sim.run(1)


def test_a_look_at_the_model_finds_the_folders_helpers(tmp_path):
    (tmp_path / "robots.py").write_text("DT = 0.5\n")
    (tmp_path / "define_model.py").write_text(
        "import robsim\n\n\ndef define_model():\n    from robots import DT\n\n"
        "    return robsim.RobotModel(robsim.RobotParameters(dt=DT))\n"
    )
    assert robsim.Simulation.from_folder(tmp_path).model.dt == 0.5


def test_a_keyword_beats_the_file_but_true_does_not(folder):
    write(folder, "control", constant(0.1, 0.2))
    write(folder, "measure", "def measure(step):\n    return None\n")
    sim = robsim.Simulation.from_folder(
        folder, control=lambda step: (0.3, 0.4), evaluate_model=robsim.Unicycle(), measure=True
    )
    trace = sim.run(40)
    alone = robsim.Simulation(control=lambda step: (0.3, 0.4), evaluate_model=robsim.Unicycle())
    np.testing.assert_array_equal(trace.pose_true, alone.run(40).pose_true)
    assert not trace.seen.any()


def test_only_the_slots_that_are_wanted_are_filled_and_executed(tmp_path):
    write(tmp_path, "control", constant(0.5, 0.25))
    write(tmp_path, "evaluate_model", "raise SystemExit('executed')")
    write(tmp_path, "measure", "def measure(step):\n    return (1, 2, 3)")
    sim = robsim.Simulation.from_folder(tmp_path, slots=("control",), measure=True)
    trace = sim.run(3)
    np.testing.assert_array_equal(trace.u, [[0.5, 0.25]] * 3)
    np.testing.assert_array_equal(
        trace.pose_true, robsim.Simulation(control=lambda step: (0.5, 0.25)).run(3).pose_true
    )
    assert trace.seen.all()
    assert (trace.pose_measured[:, 0] > 500).all()
    # An edit of a file that is not wanted is none.
    write(tmp_path, "evaluate_model", "raise SystemExit('executed again')")
    sim.run(1)


def test_wrong_use(tmp_path):
    write(tmp_path, "measure", "def measure(step):\n    return None")
    for options, error, told in (
        ({"noize": "uniform"}, TypeError, "noize"),
        ({"slots": ()}, ValueError, "slots"),
        ({"slots": "controll"}, ValueError, "'controll'.*'control'"),
        ({"slots": ("measure", "evaluate")}, ValueError, "slots .*'evaluate'"),
        ({"slots": "control"}, ValueError, "control"),
    ):
        with pytest.raises(error, match=told):
            robsim.Simulation.from_folder(tmp_path, **options)
    with pytest.raises(FileNotFoundError, match="robsim new"):
        robsim.Simulation.from_folder(tmp_path / "none")
    with pytest.raises(ValueError, match=r"slots .*'evaluate_model'"):
        robsim.Experiment.from_folder(tmp_path, frames=[], slots="evaluate_model")


def test_the_default_can_be_asked_for(tmp_path):
    write(tmp_path, "control", constant(0.5, 0.25))
    write(tmp_path, "evaluate_model", "def evaluate_model(world):\n    return (900, 300, 0)")
    write(tmp_path, "measure", "def measure(step):\n    return (1, 2, 3)")
    sim = robsim.Simulation.from_folder(
        tmp_path, evaluate_model="default", measure="default", control="default", headings=None
    )
    expected = robsim.Simulation(measure=True, headings=None).run(4)
    trace = sim.run(4)
    np.testing.assert_array_equal(trace.pose_true, expected.pose_true)
    np.testing.assert_array_equal(trace.pose_measured, expected.pose_measured)
    sim.control = lambda step: (0.1, 0.1)
    sim.run(1)
    sim.control = "default"
    np.testing.assert_array_equal(sim.run(1).u[-2:], [(0.1, 0.1), (0.05, -0.05)])


def test_an_experiment_takes_the_robot_half_of_a_folder(tmp_path):
    write(tmp_path, "control", constant(0.5, 0.25))
    write(tmp_path, "evaluate_model", "raise SystemExit('executed')")
    write(tmp_path, "adjust_background", "raise SystemExit('executed')")
    source = robsim.Simulation(resolution=(240, 240))
    frames = [source.step().frame for _ in range(3)]
    sent = []
    options = {"frames": frames, "send": sent.append, "frame_timeout": 300}
    trace = robsim.Experiment.from_folder(tmp_path, **options).run()
    assert trace.seen.all()
    np.testing.assert_array_equal(sent, [(0.5, 0.25)] * 3 + [(0, 0)] * 2)
