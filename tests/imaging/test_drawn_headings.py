"""Frames of a simulation say in how many headings the robot is drawn, wherever they have been."""

import copy
import pickle

import numpy as np
import pytest

import robsim
from python_cameras import PATIENT
from robsim.lab import SimulatedLab
from robsim.trace import Session
from robsim.vision import save_image, save_video

AREA = (400, 300)
ROUNDED = np.radians(10) / np.sqrt(12)  # of 36 headings


def simulation(**options):
    return robsim.Simulation(robot="lab", area=AREA, seed=1, **options)


def heading_sd(frame):
    markers = robsim.load_robot("lab").marker_layout()
    blobs = robsim.find_blobs(frame, robsim.load_colors(), markers=markers)
    return np.sqrt(robsim.locate(blobs, markers, image=frame).covariance[2, 2])


@pytest.fixture(scope="module")
def frame():
    return simulation().step().frame


def test_of_the_simulation(frame):
    assert frame.headings == 36
    assert copy.deepcopy(frame).headings == pickle.loads(pickle.dumps(frame)).headings == 36
    assert frame != robsim.Frame(frame.image, t=frame.t, plane_map=frame.plane_map)
    assert heading_sd(frame) == pytest.approx(ROUNDED, rel=0.02)
    assert simulation(headings=None).step().frame.headings is None


def test_an_array_does_not_tell(frame):
    plain = robsim.Frame(frame.image, plane_map=frame.plane_map)
    assert plain.headings is None
    assert heading_sd(plain) < ROUNDED / 10
    assert heading_sd(robsim.Frame(frame.image, headings=36)) == heading_sd(frame)


@pytest.mark.parametrize("headings", [36, None])
def test_of_the_simulated_lab(headings):
    world = robsim.Scenario(robot="lab", area=AREA, headings=headings, seed=1)
    with SimulatedLab(world, fps=50) as lab, robsim.Camera(lab, **PATIENT) as camera:
        assert camera.read(300).headings == headings


@pytest.mark.long
def test_of_a_video(tmp_path, frame):
    pytest.importorskip("cv2")
    for name in ("run.mkv", "run.webm"):
        save_video(tmp_path / name, [frame] * 3, fps=5)
        recording = robsim.Recording(tmp_path / name)
        assert recording.headings == 36
        assert [frame.headings for frame in recording] == [36, 36, 36]
        assert robsim.Recording(tmp_path / name, headings=72).headings == 72
        with robsim.Camera(tmp_path / name, **PATIENT) as camera:
            assert camera.read(300).headings == 36
    for frames in ([frame, frame.image], [simulation(headings=None).step().frame]):
        save_video(tmp_path / "other.mkv", frames, fps=5)
        assert robsim.Recording(tmp_path / "other.mkv").headings is None


def test_of_frames_that_a_calibration_maps(frame):
    floor = robsim.vision.Calibration(size=AREA, floor=frame.plane_map, area=AREA)
    given = [frame, robsim.simulation.Observation(frame, t=0.2)]
    with robsim.Experiment(given, calibration=floor, measure=True) as experiment:
        trace = experiment.run()
    assert experiment.last_step.frame.headings == trace.info.headings == 36
    assert np.sqrt(trace.covariance_measured[:, 2, 2]) == pytest.approx(ROUNDED, rel=0.02)


def test_headings_of_a_folder_are_given(tmp_path, frame):
    save_image(tmp_path / "0.png", frame.image)
    assert robsim.Recording(tmp_path).headings is None
    assert next(iter(robsim.Recording(tmp_path, headings=36))).headings == 36
    for take in (robsim.Recording, lambda folder, headings: robsim.Frame(frame.image, headings=0)):
        with pytest.raises(ValueError, match="headings"):
            take(tmp_path, headings=0)


def recorded(folder, headings):
    drawing = simulation(headings=headings)
    frames = [drawing.step().frame for _ in range(2)]
    with robsim.Experiment(frames, record=folder, area=AREA) as experiment:
        experiment.run()
    return Session(folder)


@pytest.mark.parametrize("headings", [36, None])
def test_of_a_session(tmp_path, headings):
    pytest.importorskip("cv2")
    session = recorded(tmp_path / "run", headings)
    assert [seen.frame.headings for seen in session] == [headings, headings]
    assert session.trace.info.headings == headings


def test_the_trace_of_an_experiment_tells_what_its_frames_do():
    drawing = simulation()
    first, second = drawing.step().frame, drawing.step().frame
    plain = robsim.Frame(second.image, t=1.0)
    with robsim.Experiment([first, second, None, plain], area=AREA, measure=True) as experiment:
        assert experiment.run(3).info.headings == 36
        assert "drawn in 36 headings" in str(experiment.trace.tracking())
        experiment.reset()
        assert experiment.trace.info.headings is None
        assert experiment.run().info.headings is None
