"""Simulations whose callbacks come from a folder."""

import numpy as np
import pytest

import robsim
from robsim.simulation._folders.callback_folder import new_folder

pytestmark = pytest.mark.long


@pytest.fixture
def folder(tmp_path):
    new_folder(tmp_path / "mine")
    return tmp_path / "mine"


def write(folder, slot, text):
    (folder / f"{slot}.py").write_text(text)


def constant(u1, u2):
    return f"def control(step):\n    return {u1}, {u2}\n"


def same(one, other):
    assert one.names == other.names
    for name in one.names:
        np.testing.assert_array_equal(one[name], other[name])


def test_an_untouched_folder_gives_the_same_bytes_as_none(folder):
    mine, plain = robsim.Simulation.from_folder(folder, seed=1), robsim.Simulation(seed=1)
    same(mine.run(30), plain.run(30))
    np.testing.assert_array_equal(mine.frame.image, plain.frame.image)


def test_a_file_that_is_switched_off_is_as_good_as_none(folder):
    options = {"seed": 1, "measure": True, "estimate_parameters": True, "resolution": (400, 400)}
    same(
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
    with pytest.raises(SyntaxError) as caught:
        sim.run(5)
    assert caught.value.filename.endswith("control.py")
    assert caught.value.lineno == 2
    assert "control.py" in caught.value.__notes__[0]
    same(sim.trace, trace)
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
    with pytest.raises(RuntimeError, match=r"define_model\.py has changed.*call sim\.reset"):
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
    same(sim.run(4), first)


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
    write(folder, "control", "import time\ndef control(step):\n    time.sleep(20)\n")
    sim = robsim.Simulation.from_folder(folder, time_limit=0.2)
    with pytest.raises(TimeoutError, match="time_limit"):
        sim.run(1)


def test_an_unknown_option_and_no_folder(folder, tmp_path):
    with pytest.raises(TypeError, match="noize"):
        robsim.Simulation.from_folder(folder, noize="uniform")
    with pytest.raises(FileNotFoundError, match="robsim new"):
        robsim.Simulation.from_folder(tmp_path / "none")


def test_a_look_at_the_model_finds_the_folders_helpers(tmp_path):
    (tmp_path / "robots.py").write_text("DT = 0.5\n")
    (tmp_path / "define_model.py").write_text(
        "import robsim\n\n\ndef define_model():\n    from robots import DT\n\n"
        "    return robsim.RobotModel(robsim.RobotParameters(dt=DT))\n"
    )
    assert robsim.Simulation.from_folder(tmp_path).model.dt == 0.5


def test_a_keyword_beats_the_file_but_true_does_not(tmp_path):
    new_folder(tmp_path)
    (tmp_path / "control.py").write_text("def control(step):\n    return 0.1, 0.2\n")
    (tmp_path / "measure.py").write_text("def measure(step):\n    return None\n")
    sim = robsim.Simulation.from_folder(
        tmp_path, control=lambda step: (0.3, 0.4), evaluate_model=robsim.Unicycle(), measure=True
    )
    trace = sim.run(40)
    alone = robsim.Simulation(control=lambda step: (0.3, 0.4), evaluate_model=robsim.Unicycle())
    np.testing.assert_array_equal(trace.pose_true, alone.run(40).pose_true)
    assert not trace.seen.any()


def test_a_reset_that_fails_keeps_the_trace(tmp_path):
    new_folder(tmp_path)
    sim = robsim.Simulation.from_folder(tmp_path)
    sim.run(5)
    (tmp_path / "control.py").write_text("def control(step:\n")
    with pytest.raises(SyntaxError):
        sim.reset()
    assert len(sim.trace) == 5


def test_a_callback_that_is_false_is_one_all_the_same(tmp_path):
    (tmp_path / "control.py").write_text(
        "class Empty(list):\n    def __call__(self, step):\n        return 0.5, 0.5\n\n\n"
        "control = Empty()\n"
    )
    trace = robsim.Simulation.from_folder(tmp_path).run(3)
    np.testing.assert_array_equal(trace.u, [(0.5, 0.5)] * 3)


def test_only_the_slots_that_are_wanted_are_filled_and_executed(tmp_path):
    write(tmp_path, "control", "def control(step):\n    return 0.5, 0.25")
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


@pytest.mark.parametrize("slots", ["controll", ("control", "evaluate")])
def test_unknown_slots_are_named(tmp_path, slots):
    with pytest.raises(
        ValueError, match=r"slots must be among define_model, .*, got '(controll|ev)"
    ):
        robsim.Simulation.from_folder(tmp_path, slots=slots)


@pytest.mark.parametrize(
    ("slots", "error", "message"),
    [
        (3, TypeError, "slots must be names of slots, such as .'control',., got 3"),
        ((), ValueError, "slots must name at least one of define_model, "),
        (("contrl",), ValueError, "got 'contrl'; did you mean 'control'?"),
        ((3,), TypeError, "slots must be names of slots, such as .'control',., got 3"),
    ],
)
def test_slots_that_are_none(tmp_path, slots, error, message):
    with pytest.raises(error, match=message):
        robsim.Simulation.from_folder(tmp_path, slots=slots)


def test_a_folder_without_a_file_for_a_wanted_slot(tmp_path):
    write(tmp_path, "measure", "def measure(step):\n    return None")
    with pytest.raises(ValueError, match="has no callback files"):
        robsim.Simulation.from_folder(tmp_path, slots="control")


def test_the_default_can_be_asked_for(tmp_path):
    write(tmp_path, "control", "def control(step):\n    return 0.5, 0.25")
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
    write(tmp_path, "control", "def control(step):\n    return 0.5, 0.25")
    write(tmp_path, "evaluate_model", "raise SystemExit('executed')")
    write(tmp_path, "adjust_background", "raise SystemExit('executed')")
    source = robsim.Simulation(resolution=(240, 240))
    frames = [source.step().frame for _ in range(3)]
    sent = []
    experiment = robsim.Experiment.from_folder(tmp_path, frames=frames, send=sent.append)
    trace = experiment.run()
    assert trace.seen.all()
    np.testing.assert_array_equal(sent, [(0.5, 0.25)] * 3 + [(0, 0)] * 2)
    with pytest.raises(ValueError, match=r"slots must be among .*, got 'evaluate_model'"):
        robsim.Experiment.from_folder(tmp_path, frames=frames, slots="evaluate_model")
