"""What a solution is given: at home no more than where it is graded."""

import textwrap
from copy import deepcopy
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import robsim
from robsim.estimation import Sample
from robsim.teach import IdentifyTask, ParkTask, Submission, try_solution
from robsim.vision import Detection

SCENARIO = robsim.Scenario(
    robot="lab", area=(400, 400), resolution=(200, 200), start=(200, 200, 0.3), measure=True
)
FRAMES = {"frames": True, "blobs": "blobs", "pose": False}

# The voltages tell what it sees: the left one of the frame and the blobs, the right one of others.
LOOKS = """
    def there(look):
        try:
            return look() is not None
        except RuntimeError as error:
            assert "not given" in str(error), error
            return False

    def control(step):
        sees = there(lambda: step.frame) + 2 * there(lambda: step.blobs)
        knows = there(lambda: step.measurement) + 2 * there(lambda: step.detection)
        knows += 4 * there(lambda: step.measurement.seen) + 8 * there(lambda: step.sample)
        return sees / 10, knows / 10
    """


def folder_with(tmp_path, **sources):
    for slot, source in sources.items():
        (tmp_path / f"{slot}.py").write_text(textwrap.dedent(source))
    return tmp_path


@dataclass(frozen=True, kw_only=True)
class ParkByBlobs(ParkTask):
    """A task of which the blobs are given."""

    given: ClassVar[str] = "blobs"


@pytest.mark.parametrize(("given", "sees"), [("frames", 3), ("blobs", 2), ("pose", 0)])
def test_it_sees_at_home_what_it_sees_where_it_is_graded(tmp_path, given, sees):
    folder = folder_with(tmp_path, control=LOOKS)
    graded = Submission(folder, slots="control", frames=FRAMES[given])
    there = graded.run(SCENARIO, steps=6, seed=1).u
    home = robsim.Simulation.from_folder(folder, scenario=SCENARIO, seed=1)
    home._give(given, ("control",))
    assert np.array_equal(home.run(6).u, there)
    assert there.tolist() == [[sees / 10, 0.1]] * 6
    assert home.frame.image.shape == (200, 200, 3)  # who looks from outside sees it all the same


def test_a_simulation_of_ones_own_gives_all(tmp_path):
    folder = folder_with(tmp_path, control=LOOKS)
    trace = robsim.Simulation.from_folder(folder, scenario=SCENARIO, seed=1).run(6)
    assert trace.u[-1].tolist() == [0.3, 1.5]


@pytest.mark.parametrize(
    ("task", "remedy"), [(ParkTask, "step.measurement"), (ParkByBlobs, "blobs")]
)
def test_who_looks_at_a_frame_that_is_not_given_fails_at_home(task, remedy):
    def control(step):
        return step.frame.t, 0.0

    def looks_at_a_copy(step):
        return deepcopy(step).frame.t, 0.0

    trial = try_solution(task(steps=3, runs=1), control=control, progress=False)
    for words in ("frames are not given", remedy, "test_given.py:"):
        assert words in trial.failed[0]
    assert try_solution(task(steps=2, runs=1), control=looks_at_a_copy, progress=False).failed


def test_samples_are_for_who_estimates_parameters():
    """Those of the truth tell where the robot is."""
    seen = []

    def control(step):
        # A pickle comes to an object of the same class, which gives all that it has.
        _, _, (values, _) = step.__reduce__()
        seen.extend([step.sample, *(one for one in values if isinstance(one, Sample | Detection))])
        return 0.3, 0.3

    try_solution(ParkTask(steps=8, runs=1), control=control, progress=False)
    assert {*seen} == {None}

    def estimate(step):
        seen.append(step.sample)
        return np.zeros((3, 5))

    try_solution(IdentifyTask(steps=20, runs=1), estimate_parameters=estimate, progress=False)
    assert any(sample is not None for sample in seen)


def test_what_is_not_given_hides_no_other_error():
    """It is asked which data of the step are missing, and the frame does not say so."""

    def control(step):
        if step.k < 0:
            return step.frame
        return step.measurement.pose[0] if step.measurement is None else (0, 0)

    trial = try_solution(ParkTask(steps=40, runs=1, dropout=0.6), control=control, progress=False)
    assert "'NoneType' object has no attribute 'pose'" in trial.failed[0]


def test_a_campaign_with_less_given_is_another_one():
    def description(**options):
        from robsim.campaigns.spec import description_of

        spec = robsim.campaigns.CampaignSpec(
            scenario=SCENARIO, metrics="tracking", runs=1, steps=2, seed=1, **options
        )
        return description_of(spec)

    assert description(given="pose") != description()
    assert description(given="all") == description()
    with pytest.raises(ValueError, match="given"):
        description(given="truth")
