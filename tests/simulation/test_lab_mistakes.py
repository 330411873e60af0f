"""Slips of a lab that are told at once, with the remedy."""

import numpy as np
import pytest

import robsim

IMAGE = np.zeros((60, 60, 3), np.uint8)
FRAMES = [robsim.Frame(IMAGE, t=0.2 * k) for k in range(8)]


def camera():
    """A generator of frames."""
    yield from FRAMES


@pytest.mark.parametrize(
    ("frames", "remedy"),
    [
        (camera, "call it, frames=camera()"),
        (FRAMES[0], "give a list of it, [frame]"),
        (IMAGE, "give a list of robsim.Frame(image, t=...)"),
    ],
)
def test_what_is_no_iterable_of_frames(frames, remedy):
    with pytest.raises(TypeError) as told:
        robsim.Experiment(frames)
    assert remedy in str(told.value)


@pytest.mark.parametrize("source", [0, "rtsp://camera/1", "/dev/video0"])
def test_a_recording_is_no_live_camera(source):
    with pytest.raises(ValueError, match=r"^source must be a video file .* a live camera"):
        robsim.Recording(source)


def test_a_callback_that_does_not_return_its_result():
    def waits(step):
        yield 0, 0

    async def sleeps(step):
        return 0, 0

    with pytest.raises(TypeError, match=r"control .* write return in place of yield \(test_lab"):
        robsim.Simulation(control=waits)
    with pytest.raises(TypeError, match="write def in place of async def"):
        robsim.Simulation(control=sleeps)


@pytest.mark.parametrize(
    ("control", "note"),
    [
        (lambda step: (step.pose_true[0], 0), "the truth is not for the robot's software"),
        (lambda step: (step.images[0], 0), "a Step has blobs, colors, detection, dt, estimate"),
        (
            lambda step: (step.detection.measurement.x, 0),
            "a Measurement has covariance, misfit, pair, pose",
        ),
    ],
)
def test_an_attribute_that_there_is_not(control, note):
    with pytest.raises(AttributeError) as told:
        robsim.Simulation(control=control, measure=True).run(1)
    assert any(note in one for one in told.value.__notes__)


def test_a_batch_estimate_needs_the_inputs():
    sim = robsim.Simulation(control=robsim.DriveAround(), resolution=(480, 480), seed=1)
    frames = [sim.step().frame for _ in range(12)]
    trace = robsim.Experiment(frames).run()
    with pytest.raises(robsim.trace.NotRecordedError, match=r"has no u: .*robsim\.Replay\(u\)"):
        robsim.batch_estimate(trace)


def test_a_scenario_in_a_file_has_to_be_loaded():
    with pytest.raises(TypeError, match=r"give robsim\.Scenario\.load\('task\.toml'\)"):
        robsim.Simulation("task.toml")


def test_a_trace_cannot_be_played():
    with pytest.raises(TypeError, match="simulation must be a Simulation, got a Trace"):
        robsim.play(robsim.Simulation().run(2))


def test_a_folder_without_the_slots_that_are_asked_for(tmp_path):
    (tmp_path / "control.py").write_text("def control(step):\n    return 0, 0\n")
    with pytest.raises(ValueError, match="no callback files: none for measure"):
        robsim.Simulation.from_folder(tmp_path, slots=("measure",))
