"""Functions and world slots of a submission."""

import dataclasses
import re

import numpy as np
import pytest

import robsim
from graded import PATIENT, assert_same_trace, folder_of, ran, ran_here
from robsim.teach import AssignmentError, Submission, SubmissionError, WorkerLimits
from submissions import notebook

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("patient_grader")]


# --- functions


FIT = """
    import numpy as np

    def line(x, y):
        slope, offset = np.polyfit(x, y, 1)
        return np.array([slope, offset])

    def parts(x, scale):
        return x * scale, len(x), [1, 2, 3], x > 0

    calls = 0
    def counted():
        global calls
        calls += 1
        print("call", calls)
        return calls
    """
FUNCTIONS = ("line", "parts", "counted")


def of(tmp_path, text=FIT, functions=FUNCTIONS, name="mine", **options):
    folder = folder_of(tmp_path / "s", **{name: text})
    return Submission(folder, functions=functions, **{"limits": PATIENT} | options)


def failure(tmp_path, *lines, **options):
    """The error of a call of a function that does this."""
    body = "".join(f"        {line}\n" for line in lines)
    graded = of(
        tmp_path, f"    import os, time\n    import numpy as np\n    def f(x):\n{body}", "f"
    )
    with pytest.raises(SubmissionError) as failed:
        graded.call("f", [1.0, 2.0], **options)
    assert failed.value.slot == "f"
    return failed.value


def test_a_function_gets_arrays_and_returns_some(tmp_path):
    graded = of(tmp_path)
    assert (graded.functions, graded.slots) == (FUNCTIONS, ())
    x = np.linspace(0, 1, 50)
    np.testing.assert_allclose(graded.call("line", x, 3 * x + 2, shape=(2,)), [3, 2])
    scaled, length, numbers, signs = graded.call("parts", x - 0.5, 2)
    np.testing.assert_array_equal(scaled, 2 * x - 1)
    assert (length, type(length)) == (50, np.int64)
    assert numbers.tolist() == [1, 2, 3]
    assert signs.tolist() == (x > 0.5).astype(int).tolist()
    assert "isolation" in graded.isolation_line


def test_what_is_called_computes_as_here(tmp_path, rng):
    """The parameters of a batch, byte for byte: numbers are not changed on their way."""
    text = """
        import robsim
        def fit(phi, y):
            result = robsim.estimation.least_squares(phi, y)
            return result.theta, result.standard_errors
        """
    phi, y = rng.normal(size=(40, 5)), rng.normal(size=40)
    theta, errors = of(tmp_path, text, "fit").call("fit", phi, y, shape=[(5,), (5,)])
    here = robsim.estimation.least_squares(phi, y)
    assert theta.tobytes() == here.theta.tobytes()
    assert errors.tobytes() == here.standard_errors.tobytes()


def test_calls_in_one_go_share_a_process_and_single_ones_do_not(tmp_path):
    graded = of(tmp_path)
    assert graded.calls("counted", [()] * 3) == [1, 2, 3]
    assert graded.output == "call 1\ncall 2\ncall 3\n"
    assert [graded.call("counted") for _ in range(2)] == [1, 1]
    assert graded.calls("counted", []) == []


def test_each_kind_of_submission_can_have_functions(tmp_path):
    helper, f = "def twice(x): return 2 * x\n", "def f(x): return twice(x)\n"
    one_file = tmp_path / "s.py"
    one_file.write_text(helper + f)
    named_after_it = tmp_path / "f.py"
    named_after_it.write_text(f"{helper}{f}def g(x): return -x\n")
    folder = folder_of(tmp_path / "s", f=f"from helper import twice\n{f}", helper=helper)
    cells = notebook(tmp_path / "s.ipynb", helper, f, "1 / 0")
    for path in (one_file, named_after_it, folder, cells):
        functions = ("f", "g") if path == named_after_it else "f"
        graded = Submission(path, functions=functions, limits=PATIENT)
        assert graded.call("f", [1, 2]).tolist() == [2, 4]
        if path == named_after_it:
            assert graded.call("g", 3) == -3


def test_slots_and_functions_stand_beside_each_other_and_only_what_is_used_is_loaded(tmp_path):
    folder = folder_of(
        tmp_path / "s",
        control="def control(step): return 0.1, 0.2",
        fit="1 / 0\ndef fit(x): return x",
    )
    graded = Submission(folder, slots="control", functions=("fit", "other"), limits=PATIENT)
    assert (graded.slots, graded.functions) == (("control",), ("fit",))
    assert (graded.run(robsim.Scenario(), steps=3, seed=1).u == [0.1, 0.2]).all()
    with pytest.raises(SubmissionError, match=r"fit.py, line 1: ZeroDivisionError"):
        graded.call("fit", 1)
    with pytest.raises(SubmissionError, match="s has no function other"):
        graded.call("other", 1)
    with pytest.raises(ValueError, match=r"\bname\b"):
        graded.call("control", 1)


def test_what_goes_wrong_is_told_with_function_and_line(tmp_path):
    for line, message, number in (
        ("return x[7]", r"^f, mine.py, line 4: IndexError", 4),
        ("return None", "TypeError: .* real numbers", None),
        ("return x * np.nan", "^f: .* finite", None),
        ("return np.zeros((2, 2, 2, 2))", "3 axes", None),
        ("return (0,) * 17", "16 results are allowed, got 17", None),
        ("return np.zeros(10**7)", "64 MiB in all, got 76 MiB", None),
        ("return np.zeros(10**9)", "more than 1 GiB$", 4),
        ("raise SystemExit(0)", "line 4: SystemExit: 0$", 4),
        ("os._exit(0)", r"^f: its process exited \(exit code 0\)$", None),
    ):
        error = failure(tmp_path, line)
        assert re.search(message, str(error)), str(error)
        assert error.line == number


def test_each_call_has_its_time_and_the_first_one_more(tmp_path):
    text = "import time\ndef f(seconds):\n    time.sleep(seconds)\n    return 0\n"
    graded = of(tmp_path, text, "f", limits=WorkerLimits(call=0.1, first_call=300.0, run=600.0))
    assert graded.call("f", 0.3) == 0
    with pytest.raises(SubmissionError, match=r"^f took longer than 0.1 s \(in call 2 of 3\)$"):
        graded.calls("f", [(0.0,), (600.0,), (0.0,)])


def test_a_result_of_another_shape_is_refused(tmp_path):
    for shape, told in (
        ((3,), r"must be an array of shape \(3,\), got \(2,\)"),
        ((2, 1), r"got \(2,\)"),
        ([(2,), (2,)], "must be 2 arrays, got 1"),
        ((None, None), r"shape \(any, any\)"),
    ):
        assert re.search(told, str(failure(tmp_path, "return x", shape=shape)))
    assert of(tmp_path, "def f(x): return x * float('nan')", "f").call(
        "f", [1.0], shape=(None,), finite=False
    ).shape == (1,)


def test_a_submission_without_what_is_wanted_says_so(tmp_path):
    for files, told in (
        ({"lines": "def f(x): return x"}, r"lines.py defines no required function: define line\("),
        ({"a": "def f(x): return x", "b": ""}, "s has no line.py"),
        ({"line": "def lines(x): return x"}, r"line.py .*define line\("),
    ):
        folder = tmp_path / next(iter(files)) / "s"
        folder.parent.mkdir()
        folder_of(folder, **files)
        with pytest.raises(SubmissionError, match=told):
            Submission(folder, functions="line").call("line", 1)


def test_large_tables_can_be_handed_in_where_the_teacher_lets_them(tmp_path):
    text = """
        import numpy as np
        def f():
            return np.load("table.npy").sum()
        """
    folder = folder_of(tmp_path / "s", f=text)
    np.save(folder / "table.npy", np.ones(500_000))
    with pytest.raises(SubmissionError, match="has more than 1 MiB"):
        Submission(folder, functions="f")
    limits = dataclasses.replace(PATIENT, submission_file_size=5 << 20, file_size=1000)
    assert Submission(folder, functions="f", limits=limits).call("f") == 500_000
    few = dataclasses.replace(limits, submission_files=1)
    with pytest.raises(SubmissionError, match="more than 1 files"):
        Submission(folder, functions="f", limits=few)


# --- world slots


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


def failure_of_world(tmp_path, line, k=3, **options):
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
    off = world(tmp_path, "ENABLED = False\n", defaults=True).run(SCENARIO, steps=8, seed=2)
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
        ("return np.array([-(2**63)] * 3)", "^evaluate_model at step 3: no robot can reach", None),
        ("return 'abc'", "^evaluate_model at step 3: TypeError", None),
        ("import os; os._exit(0)", "^evaluate_model at step 3: its process exited", None),
    ):
        error = failure_of_world(tmp_path, line)
        assert re.search(message, str(error)), str(error)
        assert error.line == number
    limits = WorkerLimits(call=0.3, first_call=300.0, run=600.0)
    hangs = failure_of_world(tmp_path, "[0 for _ in iter(int, 1)]", k=2, limits=limits)
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
