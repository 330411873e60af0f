"""The first finding in a submission, in the grader's worker: it is about the submission alone."""

import re

import pytest

import robsim
from graded import PATIENT
from robsim.teach import TASKS, SubmissionError
from robsim.teach.assignments.marking.findings import _DOCTOR
from robsim.teach.grading.calling import judged
from robsim.teach.grading.task import Task
from robsim.teach.submissions import Rules, SubmissionFiles
from robsim.teach.submissions.files import FOLDER
from robsim.teach.submissions.imports import NotHereError
from robsim.teach.tasks.solutions import MODULE, module_source
from sizes import thorough

NOT_HERE = str(NotHereError(""))
SLOW = "more than the budget"  # which a busy machine may cause


def finding(sources, slots, masked):
    files = SubmissionFiles("mine", FOLDER, "", sources, tuple(slots))
    task = Task(submission=files, rules=Rules(slots=slots, masked=masked), limits=PATIENT)
    try:
        return judged(task, _DOCTOR, 600.0).result
    except SubmissionError as error:  # it is not loaded: the grader asks of no such one
        return "" if NOT_HERE in str(error) or "handed in" in str(error) else str(error)


@pytest.mark.slow
@pytest.mark.parametrize("name", TASKS)
def test_of_what_ships_it_is_of_the_solution_alone(name):
    task = TASKS[name]()
    told = []
    wrong = [one for one in task.solutions if not one.is_right]
    reference = [one for one in task.solutions if one.name == "reference"]
    for one in thorough(task.solutions, [*reference, *wrong[::3]]):
        sources = {f"{module}.py": content for module, content in one.files.items()}
        said = finding({**sources, f"{MODULE}.py": module_source(task)}, task.slots, task.masked)
        assert NOT_HERE not in said
        assert "robsim/" not in said
        places = set(re.findall(r"\w+\.py\b", said.partition("\n")[2]))
        assert places <= sources.keys(), said
        assert not one.is_right or not said or SLOW in said, said
        told += [one.name] if said else []
    assert told or name == "park"  # whose faults only a run shows


@pytest.mark.long
@pytest.mark.parametrize(
    "masked",
    [
        [f"robsim.{wing}" for wing in ("vision", "control", "simulation", "trace", "teach")],
        [f"robsim.{name}" for name in robsim.__all__ if name[0].isalpha()],
    ],
    ids=["wings", "names"],
)
def test_whatever_is_masked_the_doctor_has_all_that_it_needs(masked):
    said = finding(
        {"define_model.py": b"def define_model():\n    return 7\n"}, ["define_model"], masked
    )
    assert said.startswith("define_model: it returns 7, not a RobotModel")


@pytest.mark.long
def test_what_a_mask_stops_is_no_finding():
    source = (
        b"import robsim\ndef measure(step):\n    return robsim.locate(step.blobs, step.markers)\n"
    )
    assert not finding({"measure.py": source}, ["measure"], ["robsim.locate"])


@pytest.mark.long
def test_no_advice_is_what_a_mask_takes():
    source = (
        b"import numpy as np\nimport robsim\nfrom helper import found_in\n\n\ndef measure(step):\n"
        b"    found = found_in(step)\n"
        b"    return found and robsim.Measurement(found.pose, covariance=1e-6 * np.eye(3))\n"
    )
    task = TASKS["measure"]()
    helper = next(one for one in task.solutions if one.name == "centroids").files["measure"]
    helper += b"\n\nfound_in = measure\n"
    sources = {"measure.py": source, "helper.py": helper, f"{MODULE}.py": module_source(task)}
    said = [finding(sources, ["measure"], masked) for masked in ([], ["robsim.locate"])]
    assert ["robsim.locate" in one for one in said] == [True, False], said
    assert all("covariance" in one for one in said)
