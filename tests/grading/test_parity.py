"""An honest submission gives the same trace in a worker as without one, byte for byte."""

import numpy as np
import pytest

import robsim
from graded import HONEST, assert_same_trace, folder_of, honest, ran, ran_here, random_scenario
from sizes import thorough

SLOTS = tuple(HONEST)
NOISY = robsim.Scenario(
    resolution=(300, 300),
    noise=robsim.GaussianNoise(8),
    dropout=robsim.Dropout(0.2, 3),
    measure=True,
    start="random",
    control=robsim.DriveAround(),
)


def assert_parity(folder, slots, scenario, **options):
    here = ran_here(folder, slots, scenario, **options)
    there = ran(folder, slots, scenario, **options)
    assert_same_trace(here, there)
    return there


@pytest.mark.long
def test_a_submission_that_fills_all_slots_gives_the_same_trace(tmp_path):
    trace = assert_parity(honest(tmp_path / "s", SLOTS), SLOTS, NOISY, steps=40)
    assert trace.info.callbacks == SLOTS
    assert 0 < np.isnan(trace.pose_measured).any(axis=1).sum() < 40
    assert np.isfinite(trace.parameters[-1]).all()
    assert np.isfinite(trace.standard_errors_unscaled[-1]).all()
    assert np.isfinite(trace.blobs["red"]).any()
    assert trace.state.shape == (40, 2)


def test_a_run_with_a_seed_is_that_of_a_simulation_with_it(tmp_path):
    """Also where a controller of the teacher's drives by the submission's estimate."""
    folder = honest(tmp_path / "s", ["estimate_state"])
    drive = robsim.GoToPoint(300, 800)
    trace = assert_parity(folder, ["estimate_state"], NOISY, seed=3, steps=30, control=drive)
    assert np.ptp(trace.u) > 0.1
    scenario = NOISY.replace(model=robsim.RobotModel(), seed=3)
    sim = robsim.Simulation.from_folder(folder, scenario=scenario, control=drive)
    assert_same_trace(sim.run(30), trace)


def test_stages_of_the_teacher_between_those_of_a_submission_are_told(tmp_path):
    slots = ["estimate_parameters", "measure", "control"]
    folder = honest(tmp_path / "s", slots)

    def estimate_state(step):
        seen = step.measurement is not None
        return robsim.Estimate(
            [step.k, *step.measurement.pose[:2]] if seen else [0, 0, 0], np.eye(3)
        )

    trace = assert_parity(folder, slots, NOISY, estimate_state=estimate_state)
    assert (trace.pose_estimated[:, 0] > 0).any()


def test_a_submission_may_see_frames_that_it_does_not_measure(tmp_path):
    looks = """
        def control(step):
            return step.frame.image[::7].mean() / 300, len(step.blobs["red"]) / 5
        """
    folder = folder_of(tmp_path / "s", control=looks)
    trace = assert_parity(folder, ["control"], NOISY, frames=True)
    assert len(np.unique(trace.u[:, 0])) > 10


def test_where_no_memory_can_be_shared_the_pixels_go_through_the_socket(tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.teach.grading.graded_run.has_frame_memory", lambda: False)
    folder = honest(tmp_path / "s", ["measure", "control"])
    assert_parity(folder, ["measure", "control"], NOISY.replace(camera_delay=1))


def test_frames_that_are_kept_stay_as_they_were(tmp_path):
    keeps = """
        import numpy as np
        frames, sums = [], []
        def measure(step):
            frames.append(step.frame.image)
            sums.append(step.frame.image.sum(dtype=int))
            if [int(one.sum(dtype=int)) for one in frames] != sums:
                raise ValueError("a frame has changed")
            return 100 + len(frames), sums[-1] % 997, 0
        """
    folder = folder_of(tmp_path / "s", measure=keeps)
    scenario = NOISY.replace(resolution=(120, 120), dropout=None)
    trace = assert_parity(folder, ["measure"], scenario, steps=30)
    assert len(np.unique(trace.pose_measured[:, 1])) > 20


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(thorough(40, 8)))
def test_random_slots_in_random_scenarios_give_the_same_trace(tmp_path, seed):
    rng = np.random.default_rng(seed)
    slots = [slot for slot in SLOTS if rng.random() < 0.5] or ["control"]
    scenario = random_scenario(rng)
    if "estimate_state" in slots and rng.random() < 0.3:
        scenario = scenario.replace(identify_from="estimate")
    frames = [None, True][rng.integers(2)]
    assert_parity(honest(tmp_path / "s", slots), slots, scenario, seed=seed, frames=frames)
