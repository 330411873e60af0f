"""Slots of the world that a submission fills: the same trace as here, and nothing beside them."""

import re

import pytest

import robsim
from graded import PATIENT, assert_same_trace, folder_of, ran, ran_here
from robsim.teach import AssignmentError, Limits, Submission, SubmissionError

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("patient_grader")]

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
    return Submission(folder, slots=slots, **({"limits": PATIENT} | options))


def failure(tmp_path, line, k=3, **options):
    start = "import numpy as np\ndef evaluate_model(world):\n"
    text = f"{start}    if world.k == {k}: {line}\n    return 1, 2, 3\n"
    with pytest.raises(SubmissionError) as failed:
        world(tmp_path, text, **options).run(SCENARIO, steps=6, seed=1)
    assert (failed.value.slot, failed.value.step) == ("evaluate_model", k)
    assert getattr(failed.value, "__notes__", []) == []
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
    plain = robsim.Simulation(SCENARIO.replace(model=robsim.RobotModel()), seed=2).run(8)
    assert_same_trace(off, plain)


def test_callbacks_of_the_teachers_are_run_here(tmp_path):
    def control(step):
        return (0.1, 0.2) if step.k < 3 else 1 / 0

    graded = world(tmp_path)
    assert (graded.run(SCENARIO, steps=3, seed=1, control=control).u == [0.1, 0.2]).all()
    with pytest.raises(AssignmentError, match="control at step 3") as failed:
        graded.run(SCENARIO, steps=6, seed=1, control=control)
    assert (failed.value.slot, failed.value.step) == ("control", 3)
    result = graded.runs(SCENARIO, runs=2, steps=5, metrics="tracking", seed=1)
    assert not result.failed.any()


def test_what_goes_wrong_is_the_submissions_fault_with_its_step(tmp_path):
    for line, message, number in (
        ("1 / 0", "^evaluate_model at step 3, evaluate_model.py, line 3: ZeroDivisionError", 3),
        ("return 1, 2", r"^evaluate_model at step 3: .* \(3,\), got \(2,\)$", None),
        ("return 1, 2, np.nan", "^evaluate_model at step 3: .* finite", None),
        ("return 1e300, 2, 3", "^evaluate_model at step 3: ", None),
        ("return 'abc'", "^evaluate_model at step 3: TypeError", None),
        ("import os; os._exit(0)", "^evaluate_model at step 3: its process ended by itself", None),
    ):
        error = failure(tmp_path, line)
        assert re.search(message, str(error)), str(error)
        assert error.line == number
    limits = Limits(call=0.3, first_call=300.0, run=600.0)
    hangs = failure(tmp_path, "[0 for _ in iter(int, 1)]", k=2, limits=limits)
    assert "evaluate_model took longer than 0.3 s" in str(hangs)


def test_a_background_of_another_kind_is_refused(tmp_path):
    for line, told in (
        ("background[:9]", "at the start: the result must be an array of shape"),
        ("background / 2", "at the start: the result must be an array of uint8"),
        ("1 / 0", "line 2: ZeroDivisionError"),
    ):
        text = f"def adjust_background(background):\n    return {line}\n"
        folder = folder_of(tmp_path / "s", adjust_background=text)
        with pytest.raises(SubmissionError, match=told) as failed:
            Submission(folder, slots="adjust_background", limits=PATIENT).run(
                SCENARIO, steps=2, seed=1
            )
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
    trace = world(tmp_path, looks).run(scenario, steps=3, seed=1)
    assert (trace.pose_true[1:, 0] == 0).all()
