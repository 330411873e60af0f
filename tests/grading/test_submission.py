"""Submissions are run in a worker; whatever they do, the run ends, and it is said who did what."""

import dataclasses
import gc
import math
import os
import re
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import graded
import robsim
from graded import HONEST, PATIENT, assert_same_trace, folder_of, ran_here
from robsim.teach import Key, Submission, SubmissionError, WorkerLimits, check_isolation
from robsim.teach.isolation._process import WorkerProcess
from sizes import thorough

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("patient_grader")]

SCENARIO = robsim.Scenario(resolution=(200, 200), measure=True, noise=robsim.GaussianNoise(5))
#: A step may take a moment, the first one minutes: what hangs hangs at step 1.
SHORT = WorkerLimits(call=0.3, first_call=300.0, run=600.0)


def submission(tmp_path, slots="control", **options):
    code = {name: options.pop(name) for name in list(options) if name in robsim.Simulation.SLOTS}
    options = {"limits": PATIENT} | options
    return Submission(folder_of(tmp_path / "s", **code), slots=slots, **options)


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


MISTAKES = {
    "1 / 0": ("ZeroDivisionError: division by zero", 5),
    "return 1, float('nan')": (r"control.py, line 3: ValueError: .* finite", 3),
    "return 13, 0": ("at most 12 V", None),
    "raise SystemExit(0)": ("SystemExit", 5),
    "os._exit(0)": (r"its process exited \(exit code 0\)", None),
    "os.abort()": ("its process was ended by signal SIG", None),
    "os.closerange(3, 99)": ("closed its connection|Bad file|process exited", None),
}
HANGS = dict.fromkeys(
    ("time.sleep(600)", "while True: pass"), ("control took longer than 0.3 s at step 1", None)
)


@pytest.mark.parametrize(("mistakes", "limits"), [(MISTAKES, PATIENT), (HANGS, SHORT)])
def test_what_goes_wrong_is_told_with_slot_step_and_line(tmp_path, mistakes, limits):
    for line, (message, line_number) in mistakes.items():
        error = failure(tmp_path, at_step(line, k=1), limits=limits)
        assert re.search(message, str(error)), str(error)
        assert (error.slot, error.step, error.whose) == ("control", 1, "submission")
        assert error.line == line_number
        assert "/" not in str(error).replace("s/", "")


def test_a_submission_that_cannot_be_loaded_says_so(tmp_path):
    for text in ("def control(step) return 1", "1 / 0", "import os; os._exit(3)", "x = 1"):
        with pytest.raises(SubmissionError):
            submission(tmp_path, control=text).run(SCENARIO, steps=3)
    endless = submission(tmp_path, control="while True: pass", limits=WorkerLimits(first_call=0.5))
    with pytest.raises(SubmissionError, match="took longer"):
        endless.run(SCENARIO, steps=3)


def test_the_first_call_and_the_run_have_limits_of_their_own(tmp_path):
    slow = at_step("time.sleep(0.4)", k="step.k")
    assert len(submission(tmp_path, control=slow, limits=SHORT).run(SCENARIO, steps=1)) == 1
    error = failure(tmp_path, slow, limits=dataclasses.replace(PATIENT, run=0.9))
    assert "the run took longer than 0.9 s" in str(error)


def test_time_in_which_others_have_the_processor_does_not_count(tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.teach.grading._worker._BUSY", 1e4)
    waits = "import time\ndef control(step):\n    time.sleep(0.3 * step.k)\n    return 1, 2"
    limits = dataclasses.replace(SHORT, call=0.1)
    if sys.platform == "linux":
        mine = submission(tmp_path, control=waits, limits=limits)
        assert len(mine.run(SCENARIO, steps=2)) == 2
        monkeypatch.setattr("robsim.teach.grading._worker._BUSY", 1.0)
    for known in (True, False):
        if not known:
            cpu_seconds = property(lambda process: math.nan)
            monkeypatch.setattr(WorkerProcess, "cpu_seconds", cpu_seconds)
            monkeypatch.setattr("robsim.teach.grading._worker._BUSY", 1e4)
        with pytest.raises(SubmissionError, match="control took longer than 0"):
            submission(tmp_path, control=waits, limits=limits).run(SCENARIO, steps=2)


def test_what_it_prints_is_kept_and_cut(tmp_path):
    limits = dataclasses.replace(PATIENT, output=1000)
    loud = submission(tmp_path, control=at_step("print('x' * 300_000)"), limits=limits)
    loud.run(SCENARIO, steps=6)
    assert loud.output.startswith("x" * 1000)
    assert len(loud.output) < 1100


def test_windows_of_opencv_do_nothing(tmp_path):
    pytest.importorskip("cv2")
    source = """
        import cv2
        from cv2 import waitKey
        def control(step):
            cv2.namedWindow("robot")
            cv2.imshow("robot", step.frame.image)
            key = waitKey(1)
            cv2.destroyAllWindows()
            return key, 2.0
        """
    folder = folder_of(tmp_path / "mine", control=source)
    submission = Submission(folder, slots="control", frames=True, limits=PATIENT)
    trace = submission.run(robsim.Scenario(resolution=(200, 200)), steps=2, seed=1)
    assert trace.u[0].tolist() == [-1, 2]


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


def test_a_key_gives_each_student_and_test_another_world_that_can_be_repeated(tmp_path):
    scenario = SCENARIO.replace(start="random")

    def started(student="a", given=None, **run):
        options = {"control": at_step("pass"), "key": Key(bytes(range(32))), "student": student}
        return submission(tmp_path, **options, **given or {}).run(scenario, steps=4, **run)

    one = started(test="t")
    assert_same_trace(one, started(test="t"))
    assert_same_trace(one, started(given={"test": "t"}))
    for other in (started("b", test="t"), started(test="t", number=1), started(test="u")):
        assert (other.pose_true != one.pose_true).any()
    with pytest.raises(ValueError, match="test"):
        started()
    assert len(started(seed=1)) == 4


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


def test_a_model_with_another_dt_is_the_submissions_fault(tmp_path):
    model = """
        import robsim
        def define_model():
            return robsim.RobotModel(robsim.RobotParameters(dt=0.1))
        """
    error = failure(tmp_path, None, slots="define_model", define_model=model)
    assert error.slot == "define_model"
    assert "dt" in str(error)


@pytest.mark.parametrize(
    "patch",
    [
        "from robsim.teach.submissions import loading\n"
        "loading.own_slots = lambda callbacks, *more: {'measure': True}",
        "from robsim.teach.grading import robot_half\nrobot_half.STAGES = ()",
    ],
)
def test_a_patched_worker_cannot_choose_the_stage_of_robsim(tmp_path, patch):
    code = f"{patch}\ndef measure(step):\n    return None\n"
    error = failure(tmp_path, None, slots="measure", measure=code)
    assert "the submission must fill its slots with its own code" in str(error)


def test_the_compiled_file_of_a_masked_module_cannot_be_read(tmp_path):
    pytest.importorskip("robsim.estimation.evaluation.errors")  # now there is one
    code = """
        import glob, os, robsim
        def control(step):
            folder = os.path.join(os.path.dirname(robsim.__file__), "estimation/evaluation")
            names = glob.glob(os.path.join(folder, "__pycache__/errors.*.pyc"))
            open((names or [os.path.join(folder, "__pycache__/errors.pyc")])[0], "rb").read()
            return 0, 0
        """
    if not check_isolation().closed["files"]:
        pytest.skip("files are open here")
    error = failure(tmp_path, code, masked=["robsim.estimation.evaluation.errors"])
    assert "PermissionError" in str(error)


def test_the_file_of_a_masked_class_cannot_be_read_though_the_table_of_copies_is_emptied(tmp_path):
    code = """
        import os, robsim
        from robsim.teach.submissions import copies
        copies._refused.clear()
        file = os.path.join(os.path.dirname(robsim.__file__), "control/path_following.py")
        def control(step):
            exec(open(file).read(), {"__name__": "mine"})
            return 0, 0
        """
    if not check_isolation().closed["files"]:
        pytest.skip("files are open here")
    error = failure(tmp_path, code, masked=["robsim.FollowPath"])
    assert "PermissionError" in str(error)


def test_what_shares_a_file_with_a_masked_class_can_be_used(tmp_path):
    code = """
        from robsim.estimation.reference import ParticleFilter, UnscentedKalmanFilter
        filters = ParticleFilter(), UnscentedKalmanFilter()
        def control(step):
            return 1, 2
        """
    masked = ["robsim.estimation.reference.ExtendedKalmanFilter", "robsim.lab.SimulatedLab"]
    assert len(submission(tmp_path, control=code, masked=masked).run(SCENARIO, steps=2)) == 2


@pytest.mark.parametrize(
    ("name", "use"),
    [
        ("locate", "found[0](step.blobs, step.markers)"),
        ("detect", "found[0](step.blobs, step.markers)"),
        ("FollowPath", "found[0]([(1, 2)])(step)"),
        ("FollowPath", "type('Mine', found[:1], {})([(1, 2)])(step)"),
        ("RecursiveLeastSquares", "found[0](robsim.RobotModel()).update(0, 0)"),
        ("Simulation", "found[0]()"),
        ("Simulation", "type('Mine', found[:1], {'__init__': lambda self: None})().run(1)"),
    ],
)
def test_a_masked_object_is_found_nowhere_in_the_memory(tmp_path, name, use):
    code = f"""
        import gc, robsim, robsim.control, robsim.vision, sys
        waiting = [*map(vars, sys.modules.values()), *gc.get_objects()]
        every = [*waiting, *(one for some in waiting for one in gc.get_referents(some))]
        named = [one for one in every if getattr(type(one), "__name__", "") != "_Absent"]
        found = tuple(one for one in named if getattr(one, "__name__", "") == {name!r})
        def control(step):
            {use}
            return 0, 0
        """
    masked = ["robsim.locate", "robsim.vision.detect", "robsim.FollowPath", "robsim.Simulation"]
    error = failure(tmp_path, code, masked=[*masked, "robsim.RecursiveLeastSquares"])
    assert "is unavailable in this assignment" in str(error) or "IndexError" in str(error)


@pytest.mark.parametrize(
    ("slot", "mask"),
    [("measure", "robsim.locate"), ("estimate_parameters", "robsim.RecursiveLeastSquares")],
)
def test_the_masked_stage_of_robsim_cannot_be_switched_on(tmp_path, slot, mask):
    code = f"""
import sys
sys.modules["robsim.teach.submissions.loading"].own_slots = lambda callbacks, *more: callbacks
robot_half = sys.modules["robsim.teach.grading.robot_half"]
run, refused = robot_half.RobotHalf.run, []
def switched_on(self, *args, **options):
    try:
        self._core.set_slot({slot!r}, True)
    except ValueError as error:
        refused.append(error)
    return run(self, *args, **options)
robot_half.RobotHalf.run = switched_on
def {slot}(step):
    if refused:
        raise refused[0]
    return None
"""
    error = failure(tmp_path, None, slots=slot, masked=[mask], **{slot: code})
    assert f"robsim's own {slot} is unavailable in this assignment" in str(error)


@pytest.mark.skipif(sys.platform != "linux", reason="there zygotes are")
def test_much_may_be_hidden_where_a_process_may_open_little(tmp_path):
    import resource

    few, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    graded.zygotes.close_zygotes()
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(400, few), most))
    try:
        masked = ["robsim.estimation.reference"]
        hiding = submission(tmp_path, control=HONEST["control"], masked=masked)
        assert len(hiding.run(SCENARIO, steps=3, seed=1)) == 3
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (few, most))
        graded.zygotes.close_zygotes()


def test_samples_of_the_truth_are_for_parameter_estimators(tmp_path):
    """Who has them needs no frame to know where the robot is."""
    tells = """
        def control(step):
            return 0.1 * (step.sample is not None), 0.3
        """
    graded = submission(tmp_path, control=tells)
    for identify_from, are_given in (("truth", False), ("measurement", True), ("estimate", False)):
        scenario = SCENARIO.replace(identify_from=identify_from)
        trace = graded.run(scenario, steps=8, seed=1)
        assert (trace.u[:, 0] > 0).any() == are_given
    # The parameters are given, and not what they come from.
    trace = graded.run(SCENARIO.replace(estimate_parameters=True), steps=8, seed=1)
    assert (trace.u[:, 0] == 0).all()
    assert np.isfinite(trace.parameters[-1]).all()


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


def test_arguments_that_contradict_each_other_are_refused(tmp_path):
    folder = folder_of(tmp_path / "s", control=at_step("pass"))
    for options, name in (
        ({}, "slots"),
        ({"slots": "contol"}, "slots"),
        ({"slots": ["evaluate_model", "control"]}, "evaluate_model"),
        ({"functions": "control"}, "functions"),
        ({"functions": ["fit", "fit"]}, "functions"),
        ({"functions": "a b"}, "functions"),
        ({"slots": "control", "isolation": "full"}, "isolation"),
    ):
        with pytest.raises(ValueError, match=name):
            Submission(folder, **options)
    with pytest.raises(ValueError, match="control"):
        Submission(folder, slots="control").run(SCENARIO, steps=1, control=robsim.Spin())


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
    scenario = SCENARIO.replace(resolution=(300, 300))

    def held():
        gc.collect()
        resident = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        return resident, len(os.listdir("/proc/self/fd")), threading.active_count()

    def failures(seeds):
        failed = 0
        for seed in seeds:
            try:
                graded.run(scenario, steps=5, seed=seed)
            except SubmissionError:
                failed += 1
        return failed

    failures(range(10))
    before, count = held(), thorough(280, 40)
    assert count / 4 < failures(range(10, 10 + count)) < count * 3 / 4
    after = held()
    assert after[0] < before[0] + 20e6, (before, after)
    assert after[1:] == before[1:]


def test_an_estimator_beside_a_stage_that_must_not_have_the_truth_is_refused(tmp_path):
    for estimator in ("init_parameter_estimator", "estimate_parameters"):
        both = submission(tmp_path, slots=[estimator, "control"], control=at_step("pass"))
        with pytest.raises(ValueError, match=f"{estimator} and control, and identify_from"):
            both.run(SCENARIO, steps=3)
        assert len(both.run(SCENARIO.replace(identify_from="measurement"), steps=3, seed=1)) == 3
        alone = folder_of(tmp_path / estimator, **{estimator: HONEST[estimator]})
        graded = Submission(alone, slots=["define_model", estimator], limits=PATIENT)
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
