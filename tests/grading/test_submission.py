"""Submissions are run in a worker; whatever they do, the run ends, and it is said who did what."""

import gc
import os
import pickle
import re
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import robsim
from graded import HONEST, assert_same_trace, folder_of, ran_here
from robsim.grading import (
    AssignmentError,
    Key,
    Limits,
    Submission,
    SubmissionError,
    check_isolation,
)

pytestmark = pytest.mark.long

SCENARIO = robsim.Scenario(resolution=(200, 200), measure=True, noise=robsim.GaussianNoise(5))
QUICK = Limits(call=0.3, first_call=5.0, run=20.0)


def submission(tmp_path, slots="control", **options):
    code = {name: options.pop(name) for name in list(options) if name in robsim.Simulation.SLOTS}
    return Submission(
        folder_of(tmp_path / "s", **code), slots=slots, **({"limits": QUICK} | options)
    )


def failure(tmp_path, text, slots="control", **options):
    """The error of a submission whose controller is this text."""
    code = {} if text is None else {"control": text}
    with pytest.raises(SubmissionError) as failed:
        submission(tmp_path, slots, **code, **options).run(SCENARIO, steps=6, seed=1)
    return failed.value


def at_step(*lines, k=3):
    """A controller that does something at a step."""
    body = "".join(f"                {line}\n" for line in lines)
    return f"""
        import os, sys, time
        def control(step):
            if step.k == {k}:
{body}
            return 0.1, 0.2
        """


@pytest.mark.parametrize(
    ("line", "message", "line_number"),
    [
        ("1 / 0", "ZeroDivisionError: division by zero", 5),
        (
            "return 1, float('nan')",
            r"control.py, line 3: ValueError: the result .* all finite, got \[1.0, nan\]$",
            3,
        ),
        ("return 13, 0", "at most 12 V", None),
        ("raise SystemExit(0)", "SystemExit", 5),
        ("os._exit(0)", r"its process ended by itself \(exit code 0\)", None),
        ("os.abort()", "its process was ended by signal SIG", None),
        ("time.sleep(60)", r"control took longer than 0.3 s at step 3", None),
        ("while True: pass", r"control took longer than 0.3 s at step 3", None),
        ("os.closerange(3, 99)", "closed its connection|Bad file|its process ended", None),
    ],
)
def test_what_goes_wrong_is_told_with_slot_step_and_line(tmp_path, line, message, line_number):
    error = failure(tmp_path, at_step(line))
    assert re.search(message, str(error)), str(error)
    assert (error.slot, error.step, error.whose) == ("control", 3, "submission")
    assert error.line == line_number
    assert "/" not in str(error).replace("s/", "")


@pytest.mark.parametrize(
    "text",
    ["def control(step) return 1", "1 / 0", "import os; os._exit(3)", "while True: pass", "x = 1"],
)
def test_a_submission_that_cannot_be_loaded_says_so(tmp_path, text):
    with pytest.raises(SubmissionError):
        submission(tmp_path, control=text, limits=Limits(first_call=0.5)).run(SCENARIO, steps=3)


SPEAKS = """
    import gc, struct
    def control(step):
        if step.k == 2:
            for found in gc.get_objects():
                if type(found).__name__ == "Channel":
                    one = found._socket
                    {speech}
        return 0.1, 0.2
    """


@pytest.mark.parametrize(
    ("speech", "message"),
    [
        ("one.sendall(b'x' * 8)", "a message of a kind that there is not"),
        ("one.sendall(struct.pack('<HHI', 4, 0, 1 << 31))", "a message of 2147483648 bytes"),
        ("one.sendall(struct.pack('<HHI', 2, 0, 0))", "a message that is not due"),
        ("one.sendall(struct.pack('<HHI', 6, 0, 2) + b'[]')", "an error that is none"),
        ("one.sendall(struct.pack('<HHI', 4, 0, 9) + b'a')", "too short"),
        ("one.shutdown(2)", "closed its connection|process ended"),
    ],
)
def test_one_that_speaks_on_the_connection_itself_gains_nothing(tmp_path, speech, message):
    error = failure(tmp_path, SPEAKS.format(speech=speech))
    # Its own answer may come with it.
    assert re.search(f"{message}|more than one message", str(error)), str(error)
    assert (error.slot, error.step) == ("control", 2)


def test_a_slow_first_call_has_its_own_limit(tmp_path):
    slow = at_step("time.sleep(0.5)", k=0)
    assert len(submission(tmp_path, control=slow).run(SCENARIO, steps=2)) == 2


def test_a_run_has_a_limit_of_its_own(tmp_path):
    slow = at_step("pass", "time.sleep(0.2)", k="step.k and step.k")
    error = failure(tmp_path, slow, limits=Limits(run=0.7))
    assert "the run took longer than 0.7 s" in str(error)


def test_what_it_prints_is_kept_and_cut(tmp_path):
    loud = submission(tmp_path, control=at_step("print('x' * 300_000)"), limits=Limits(output=1000))
    loud.run(SCENARIO, steps=6)
    assert loud.output.startswith("x" * 1000)
    assert len(loud.output) < 1100
    error = failure(tmp_path, at_step("print('here')", "1 / 0"))
    assert "here" in error.output


def test_nothing_of_a_run_is_there_in_the_next(tmp_path):
    counts = """
        import pathlib
        runs = pathlib.Path("runs")
        n = len(runs.read_text()) if runs.exists() else 0
        def control(step):
            global n
            n += 1
            runs.write_text("x" * n)
            return 0.01 * n, 0
        """
    counting = submission(tmp_path, control=counts)
    one, other = (counting.run(SCENARIO, steps=5, seed=1) for _ in range(2))
    assert_same_trace(one, other)
    assert one.u[-1, 0] == pytest.approx(0.05)


def test_a_worker_has_no_file_that_it_does_not_need(tmp_path):
    looks = """
        import os
        open_files = len(os.listdir("/dev/fd"))
        def control(step):
            return open_files / 100, 0
        """
    if not os.path.isdir("/dev/fd"):
        pytest.skip("no /dev/fd")
    watched = submission(tmp_path, control=looks, isolation="process")
    assert watched.run(SCENARIO, steps=1).u[0, 0] <= 0.07


def test_the_truth_is_not_in_the_worker(tmp_path):
    """What a worker is told comes from the frames and the inputs alone."""
    looks = """
        import gc, robsim
        def control(step):
            kinds = {type(one).__name__ for one in gc.get_objects()}
            found = kinds & {"Simulation", "SimulatedWorld", "Scenario", "Key", "RunSeeds"}
            return len(found), 0
        """
    trace = submission(tmp_path, control=looks).run(SCENARIO, steps=3)
    assert (trace.u == 0).all()


def test_a_key_gives_each_student_and_run_another_world_that_can_be_repeated(tmp_path):
    key = Key(bytes(range(32)))
    scenario = SCENARIO.replace(start="random")
    mine = submission(tmp_path, control=at_step("pass"), key=key, student="a")
    yours = submission(tmp_path, control=at_step("pass"), key=key, student="b")
    one = mine.run(scenario, steps=4, test="t")
    assert_same_trace(one, mine.run(scenario, steps=4, test="t"))
    for other in (
        yours.run(scenario, steps=4, test="t"),
        mine.run(scenario, steps=4, test="t", number=1),
        mine.run(scenario, steps=4, test="u"),
    ):
        assert (other.pose_true != one.pose_true).any()


def test_the_noise_of_graded_frames_is_not_that_of_the_worlds_seed(tmp_path):
    """A frame tells nothing of the seeds of the others."""
    key = Key(bytes(32))
    looks = """
        def control(step):
            return step.frame.image[:9, :9].mean() / 100, 0
        """
    watched = submission(tmp_path, control=looks, key=key, frames=True)
    trace = watched.run(SCENARIO, steps=5, test="")
    seed = np.random.SeedSequence(key.world_seed("s", "", 0))
    sim = robsim.Simulation(SCENARIO, seed=seed, control=robsim.Replay(trace.u))
    frames = [sim.step().frame.image for _ in range(5)]
    assert (sim.trace.pose_true == trace.pose_true).all()
    plain = [frame[:9, :9].mean() / 100 for frame in frames]
    assert np.abs(plain - trace.u[:, 0]).min() > 0


def test_a_callback_of_the_teachers_that_fails_is_the_assignments_fault(tmp_path):
    def estimate_state(step):
        return 1 / (step.k - 2)

    graded = submission(tmp_path, control=at_step("pass"))
    with pytest.raises(AssignmentError, match="estimate_state at step 0") as failed:
        graded.run(SCENARIO, steps=5, estimate_state=estimate_state)
    assert (failed.value.slot, failed.value.step) == ("estimate_state", 0)


def test_a_model_with_another_dt_is_the_submissions_fault(tmp_path):
    model = """
        import robsim
        def define_model():
            return robsim.RobotModel(robsim.RobotParameters(dt=0.1))
        """
    error = failure(tmp_path, None, slots="define_model", define_model=model)
    assert error.slot == "define_model"
    assert "dt" in str(error)


def test_masked_modules_cannot_be_had(tmp_path):
    code = """
        import robsim
        def control(step):
            robsim.reference.ExtendedKalmanFilter()
            return 0, 0
        """
    error = failure(tmp_path, code, masked=["robsim.reference"])
    assert "robsim.reference" in str(error)


def test_the_compiled_file_of_a_masked_module_cannot_be_read(tmp_path):
    pytest.importorskip("robsim.evaluation._errors")  # now there is one
    code = """
        import glob, os, robsim
        def control(step):
            folder = os.path.join(os.path.dirname(robsim.__file__), "evaluation", "__pycache__")
            names = glob.glob(os.path.join(folder, "_errors.*.pyc"))
            for name in names or [os.path.join(folder, "_errors.pyc")]:
                open(name, "rb").read()
            return 0, 0
        """
    if not check_isolation().closed["files"]:
        pytest.skip("files are open here")
    error = failure(tmp_path, code, masked=["robsim.evaluation._errors"])
    assert "PermissionError" in str(error)


TELLS = """
    def control(step):
        return 0.1 * (step.sample is not None), 0.3
    """


@pytest.mark.parametrize(
    ("identify_from", "are_given"), [("truth", False), ("measurement", True), ("estimate", False)]
)
def test_samples_of_the_truth_are_for_parameter_estimators(tmp_path, identify_from, are_given):
    """Who has them needs no frame to know where the robot is."""
    scenario = SCENARIO.replace(identify_from=identify_from)
    trace = submission(tmp_path, control=TELLS).run(scenario, steps=8, seed=1)
    assert (trace.u[:, 0] > 0).any() == are_given
    scenario = scenario.replace(estimate_parameters=True)
    if identify_from == "truth":  # the parameters are given, and not what they come from
        trace = submission(tmp_path, control=TELLS).run(scenario, steps=8, seed=1)
        assert (trace.u[:, 0] == 0).all()
        assert np.isfinite(trace.parameters[-1]).all()


def test_one_that_raises_the_errors_of_the_grader_is_told_as_any_other(tmp_path):
    for kind in ("SubmissionError", "AssignmentError", "GraderError"):
        code = f"""
            from robsim.grading import {kind}
            def control(step):
                raise {kind}("the key cannot be read")
            """
        error = failure(tmp_path, code)
        told = f"control at step 0, control.py, line 4: {kind}: the key cannot be read"
        assert (type(error), str(error)) == (SubmissionError, told)


def test_runs_have_a_row_each_and_the_failures_their_line(tmp_path):
    fails = """
        def control(step):
            if step.measurement is None or step.measurement.pose[0] > 600:
                raise ValueError("too far")
            return 0.1, 0.1
        """
    graded = submission(tmp_path, control=fails)
    result = graded.runs(
        SCENARIO.replace(start="random"), runs=8, steps=3, metrics="tracking", seed=3
    )
    assert 0 < result.failed.sum() < 8
    failed = int(np.argmax(result.failed))
    assert "too far" in result["error"][failed]
    assert "control.py:4" in result["line"][failed]
    assert np.isfinite(result["tracking_rmse_xy"][~result.failed]).all()


@pytest.mark.slow
def test_many_submissions_at_a_time_do_not_mix(tmp_path):
    def run(i):
        folder = folder_of(tmp_path / f"s{i}", control=f"def control(step): return {i} / 10, 0")
        return Submission(folder, slots="control").run(SCENARIO, steps=20, seed=i).u[:, 0]

    with ThreadPoolExecutor(4) as pool:
        for i, u in enumerate(pool.map(run, range(12))):
            assert (u == i / 10).all()


def test_arguments_that_are_wrong_are_named(tmp_path):
    folder = folder_of(tmp_path / "s", control=at_step("pass"))
    for options, name in (
        ({"slots": "contol"}, "slots"),
        ({"slots": ["evaluate_model", "control"]}, "control and evaluate_model"),
        ({}, "slots or functions must name"),
        ({"functions": "control"}, "which is a slot"),
        ({"functions": "random"}, "a module may have this name"),
        ({"functions": ["fit", "fit"]}, "each name once"),
        ({"slots": []}, "slots must name at least one"),
        ({"functions": 3}, "functions must be names"),
        ({"functions": "a b"}, "names of functions"),
        ({"slots": "control", "test": 3}, "test must be a name"),
        ({"slots": "control", "isolation": "full"}, "isolation"),
        ({"slots": "control", "limits": 3}, "limits"),
        ({"slots": "control", "key": "k"}, "key"),
        ({"slots": "control", "frames": 1}, "frames"),
    ):
        with pytest.raises((TypeError, ValueError), match=name):
            Submission(folder, **options)
    graded = Submission(folder, slots="control")
    with pytest.raises(ValueError, match="control is for the submission"):
        graded.run(SCENARIO, steps=1, control=robsim.Spin())
    with pytest.raises(TypeError, match="estimate_sate"):
        graded.run(SCENARIO, steps=1, estimate_sate=1)
    with pytest.raises(TypeError, match="scenario"):
        graded.run("lab", steps=1)
    assert pickle.loads(pickle.dumps(SubmissionError("x", slot="control"))).slot == "control"


@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="needs /proc")
def test_hundreds_of_runs_leave_nothing_behind(tmp_path):
    """Neither memory nor descriptors nor threads, whether a run fails or not."""
    looks = """
        def measure(step):
            if step.k == 4 and step.frame.image[0, 0, 0] % 2:
                raise ValueError("odd")
            return 1, 2, 3
        """
    graded = submission(tmp_path, slots="measure", measure=looks)
    scenario = SCENARIO.replace(resolution=(600, 600))

    def held():
        status = Path("/proc/self/status").read_text()
        in_use = int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024
        return in_use, len(os.listdir("/proc/self/fd")), threading.active_count()

    def some(count, first):
        failed = 0
        for seed in range(first, first + count):
            try:
                graded.run(scenario, steps=5, seed=seed)
            except SubmissionError:
                failed += 1
        return failed

    some(40, 0)
    gc.collect()
    before = held()
    assert 60 < some(260, 40) < 200
    gc.collect()
    after = held()
    assert after[0] < before[0] + 20, (before, after)
    assert after[1:] == before[1:]


def test_a_key_asks_for_the_name_of_a_test(tmp_path):
    keyed = submission(tmp_path, control=at_step("pass"), key=Key(bytes(32)))
    with pytest.raises(ValueError, match="with a key a run needs the name of its test"):
        keyed.run(SCENARIO, steps=1)
    with pytest.raises(ValueError, match="with a key a run needs"):
        keyed.runs(SCENARIO, runs=1, steps=1, metrics="tracking")
    assert len(keyed.run(SCENARIO, steps=1, seed=1)) == 1
    named = submission(tmp_path, control=at_step("pass"), key=Key(bytes(32)), test="t")
    assert_same_trace(named.run(SCENARIO, steps=2), keyed.run(SCENARIO, steps=2, test="t"))


@pytest.mark.parametrize("estimator", ["init_parameter_estimator", "estimate_parameters"])
def test_an_estimator_beside_a_stage_that_must_not_have_the_truth_is_refused(tmp_path, estimator):
    both = submission(tmp_path, slots=[estimator, "control"], control=at_step("pass"))
    with pytest.raises(ValueError, match=f"slots has {estimator} and control, and identify_from"):
        both.run(SCENARIO, steps=3)
    assert len(both.run(SCENARIO.replace(identify_from="measurement"), steps=3, seed=1)) == 3
    alone = folder_of(tmp_path / "alone", **{estimator: HONEST[estimator]})
    graded = Submission(alone, slots=["define_model", estimator])
    scenario = SCENARIO.replace(estimate_parameters=True, control=robsim.DriveAround())
    here = ran_here(alone, ["define_model", estimator], scenario, steps=20)
    assert_same_trace(graded.run(scenario, steps=20, seed=1), here)
    assert np.isfinite(here.parameters[-1]).all()


def test_parameters_from_the_truth_are_told_as_they_are_in_one_process(tmp_path):
    """The samples do not go over, and all numbers are the same."""
    reads = """
        def control(step):
            assert step.sample is None
            known = 0 if step.parameters is None else step.parameters[0, 0]
            return 0.3 + 0.1 * known, 0.4 * (step.k % 3)
        """
    graded = submission(tmp_path, control=reads)
    scenario = SCENARIO.replace(estimate_parameters=True)
    trace = graded.run(scenario, steps=20, seed=1)
    plain = folder_of(tmp_path / "plain", control=reads.replace("assert step.sample is None", ""))
    assert_same_trace(ran_here(plain, ["control"], scenario, steps=20), trace)
    assert len(np.unique(trace.u[:, 0])) > 5
