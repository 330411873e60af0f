"""Slots of the world that a submission fills: the same trace as here, and nothing beside them."""

import re

import pytest

import robsim
from graded import assert_same_trace, folder_of, ran, ran_here
from robsim.grading import AssignmentError, Limits, Submission, SubmissionError

pytestmark = pytest.mark.long

SLOTS = ("adjust_background", "evaluate_model")
SCENARIO = robsim.Scenario(
    resolution=(200, 200), measure=True, noise=robsim.GaussianNoise(5), start="random"
)
MODEL = """
    import numpy as np
    def evaluate_model(world):
        if world.dt != world.model.dt or abs(world.t - world.k * world.dt) > 1e-9:
            raise ValueError("time")
        pose = np.array(world.model.predict(world.pose_1, world.pose_2, world.last_u))
        return pose + [0.5, world.k / 10, 0.01]
    """
BACKGROUND = """
    def adjust_background(background):
        background[100:300] = 200
        return background
    """


def world(tmp_path, model=MODEL, slots="evaluate_model", **options):
    folder = folder_of(tmp_path / "s", evaluate_model=model)
    limits = Limits(call=0.4, first_call=5.0, run=20.0)
    return Submission(folder, slots=slots, **({"limits": limits} | options))


def failure(tmp_path, line):
    start = "import numpy as np\ndef evaluate_model(world):\n"
    text = f"{start}    if world.k == 3: {line}\n    return 1, 2, 3\n"
    with pytest.raises(SubmissionError) as failed:
        world(tmp_path, text).run(SCENARIO, steps=6, seed=1)
    return failed.value


def test_the_world_of_a_submission_is_that_of_one_process(tmp_path):
    folder = folder_of(tmp_path / "s", evaluate_model=MODEL, adjust_background=BACKGROUND)
    scenario = SCENARIO.replace(mismatch=robsim.ParameterMismatch(0.05))
    there = ran(folder, SLOTS, scenario, steps=30)
    assert_same_trace(ran_here(folder, SLOTS, scenario, steps=30), there)
    assert there.info.callbacks == SLOTS
    plain = robsim.Simulation(scenario, seed=1).run(30)
    assert (there.pose_true[1:] != plain.pose_true[1:]).any(axis=1).all()


def test_what_the_submission_switches_off_is_the_default(tmp_path):
    off = world(tmp_path, "ENABLED = False\n").run(SCENARIO, steps=8, seed=2)
    model = robsim.RobotModel()
    plain = robsim.Simulation(SCENARIO.replace(model=model), seed=2).run(8)
    assert_same_trace(off, plain)


def test_callbacks_of_the_teachers_are_run_here(tmp_path):
    def control(step):
        return (0.1, 0.2) if step.k < 3 else 1 / 0

    graded = world(tmp_path)
    assert (graded.run(SCENARIO, steps=3, seed=1, control=control).u == [0.1, 0.2]).all()
    with pytest.raises(AssignmentError, match="control at step 3"):
        graded.run(SCENARIO, steps=6, seed=1, control=control)
    result = graded.runs(SCENARIO, runs=2, steps=5, metrics="tracking", seed=1)
    assert not result.failed.any()


@pytest.mark.parametrize(
    ("line", "message", "number"),
    [
        ("1 / 0", "^evaluate_model at step 3, evaluate_model.py, line 3: ZeroDivisionError", 3),
        (
            "return 1, 2",
            r"^evaluate_model at step 3: .* an array of shape \(3,\), got \(2,\)$",
            None,
        ),
        ("return 1, 2, np.nan", "^evaluate_model at step 3: the result must be all finite", None),
        ("return 1e300, 2, 3", "^evaluate_model at step 3: no robot gets to", None),
        ("return 'abc'", "^evaluate_model at step 3: TypeError: the result must be", None),
        ("[0 for _ in iter(int, 1)]", "^evaluate_model took longer than 0.4 s at step 3", None),
        ("import os; os._exit(0)", "^evaluate_model at step 3: its process ended by itself", None),
    ],
)
def test_what_goes_wrong_is_the_submissions_fault_with_its_step(tmp_path, line, message, number):
    error = failure(tmp_path, line)
    assert re.search(message, str(error)), str(error)
    assert (error.slot, error.step, error.line) == ("evaluate_model", 3, number)
    assert getattr(error, "__notes__", []) == []


def test_a_background_of_another_kind_is_refused(tmp_path):
    for line, told in (
        ("background[:9]", "at the start: the result must be an array of shape"),
        ("background / 2", "at the start: the result must be an array of uint8"),
        ("1 / 0", "line 2: ZeroDivisionError"),
    ):
        text = f"def adjust_background(background):\n    return {line}\n"
        folder = folder_of(tmp_path / "s", adjust_background=text)
        with pytest.raises(SubmissionError, match=told) as failed:
            Submission(folder, slots="adjust_background").run(SCENARIO, steps=2, seed=1)
        assert failed.value.slot == "adjust_background"


def test_its_process_has_the_record_and_nothing_else_of_the_world(tmp_path):
    looks = """
        import gc
        def evaluate_model(world):
            kinds = {type(one).__name__ for one in gc.get_objects()}
            found = kinds & {"Simulation", "SimulatedWorld", "Scenario", "Key", "RunSeeds", "Trace"}
            return len(found), 2, 3
        """
    scenario = SCENARIO.replace(boundary="unlimited")
    trace = world(tmp_path, looks, limits=Limits()).run(scenario, steps=3, seed=1)
    assert (trace.pose_true[1:, 0] == 0).all()
