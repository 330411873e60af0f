"""`check_camera`: a good camera is called good, and each fault of another one is named."""

import time
from contextlib import suppress

import numpy as np
import pytest

import robsim
from python_devices import PATIENT, EndlessCamera
from robsim.lab import (
    Camera,
    CameraFaults,
    FrameTimeoutError,
    SimulatedLab,
    UdpMotors,
    check_camera,
)

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("_checks_few_frames")]

SIZE = (400, 400)


def picture(robot="lab", resolution=SIZE, pose=(200, 180, 0.4), **options):
    sim = robsim.Simulation(
        robot=robot, area=SIZE, resolution=resolution, start=pose, headings=None, seed=1, **options
    )
    return np.array(sim.step().frame.image)


def check(image, robot="lab", **options):
    """The check of a camera that shows one image."""
    with Camera(EndlessCamera(image), area=SIZE, **PATIENT) as camera:
        return check_camera(camera, robot=robot, seconds=300, **options)


def kinds(report):
    """What is wrong with the picture, and not with the rate, which is none."""
    of_time = ("frame rate", "jitter", "lost frames")
    return {problem.kind for problem in report.problems} - {*of_time}


def lit(image, factor):
    return np.minimum(np.rint(factor * image.astype(float)), 255).astype(np.uint8)


def test_a_good_picture_has_no_fault():
    report = check(picture())
    assert kinds(report) == set()
    assert report["marker width"].value == pytest.approx(23, abs=1)
    assert report.to_dict()["findings"]["marker width"]["verdict"] == "good"
    assert report["scatter of the position"].value < 1e-6
    assert report.seen == report.frames == 8
    assert np.abs(report.measurement.pose[:2] - (200, 180)).max() < 1


def test_a_dark_picture_is_named():
    report = check(lit(picture(), 0.01))
    assert {"robot detected", "mean level"} <= kinds(report)
    assert not report.ok
    assert "exposure" in str(report)
    very_dim = check(lit(picture(), 0.12))
    assert {"mean level", "markers' level", "margin of red", "margin of blue"} <= kinds(very_dim)
    assert not very_dim.ok
    assert very_dim["robot detected"].verdict == "good"
    assert "second chance" in " ".join(str(very_dim).split())
    dim = check(lit(picture(), 0.45))
    assert "margin of red" in kinds(dim)
    assert dim["margin of red"].verdict == "poor"


def test_an_overexposed_picture_is_named():
    report = check(lit(picture(), 1.6))
    assert "markers clipped" in kinds(report)
    white = check(np.full((*SIZE, 3), 255, np.uint8))
    assert white["white pixels"].verdict == "bad"


def test_small_markers_are_named():
    report = check(picture(resolution=(32, 32)))
    assert report["marker width"].verdict == "bad"
    assert check(picture(resolution=(64, 64)))["marker width"].verdict == "poor"


@pytest.mark.parametrize(
    ("percent", "verdicts"), [(2, ("good", "good")), (10, ("poor", "good")), (30, ("poor", "poor"))]
)
def test_noise_is_measured_and_judged_by_the_markers(percent, verdicts):
    report = check(picture(resolution=(160, 160), noise=robsim.GaussianNoise(percent)))
    noise, figure = report["noise"], report["signal to noise of the markers"]
    assert noise.value == pytest.approx(2.55 * percent, rel=0.15)
    assert noise.unit == "levels"
    assert (noise.verdict, figure.verdict) == verdicts
    # |contrast|^2 / sigma^2 perimeter w / 3.5, of markers of 9.2 px
    assert figure.value == pytest.approx(197 / percent, rel=0.35)


def test_wrong_colours_and_another_robot_are_named():
    colors = [
        robsim.ColorClass("red", v=(230, 255)),
        robsim.ColorClass("blue", u=(154, 255), v=(0, 140)),
    ]
    report = check(picture(), colors=colors)
    assert kinds(report) == {"robot detected"}
    assert "no red blob" in str(report)
    assert report["margin of red"].verdict == "not known"
    assert "robot detected" in kinds(check(picture(), robot="sheep"))
    narrow = [robsim.ColorClass("red", v=(190, 255)), colors[1]]
    assert check(picture(), colors=narrow)["margin of red"].verdict == "poor"


def test_a_floor_without_a_robot_is_named():
    report = check(picture(dropout=robsim.Dropout(1)))
    assert report.seen == 0
    assert report.measurement is None
    assert report["robot detected"].verdict == "bad"


def test_two_robots_are_named():
    image = picture(pose=(100, 100, 0.4))
    other = picture(pose=(300, 300, 2))
    image[200:, 200:] = other[200:, 200:]
    report = check(image)
    assert report["robot detected"].verdict == "bad"
    assert "one robot" in str(report)


def test_a_single_frame_tells_nothing_of_the_rate():
    with Camera(EndlessCamera(picture(), 1), area=SIZE, **PATIENT) as camera:
        report = check_camera(camera, robot="lab", seconds=300)
    assert report.frames == 1
    for name in ("frame rate", "jitter", "lost frames", "scatter of the position"):
        assert report[name].verdict == "not known"


class ClockedCamera(EndlessCamera):
    """Its exposures have a time by the function `clock`."""

    clock = None

    def read(self):
        return self.image, self.clock()


@pytest.mark.parametrize(
    ("clock", "verdicts"),
    [
        (lambda: None, {"not known"}),
        (lambda: time.monotonic() - 0.01, {"good", "poor", "bad"}),  # a busy machine is late
        (lambda: time.monotonic() - 1, {"bad"}),
    ],
)
def test_the_latency_is_known_by_the_times_of_exposure_only(clock, verdicts):
    source = ClockedCamera(picture())
    source.clock = clock
    with Camera(source, area=SIZE, **PATIENT) as camera:
        report = check_camera(camera, robot="lab", seconds=300)
    latency = report["exposure to arrival"]
    assert latency.verdict in verdicts
    is_known = "not known" not in verdicts
    assert (latency.value >= 10) == is_known
    assert any("no exposure times" in remark for remark in report.remarks) != is_known


@pytest.mark.parametrize(
    "clock",
    [
        time.time,
        lambda: time.monotonic() + 5,
        lambda: time.monotonic() - 61,
        lambda: 1000 * time.monotonic(),
        lambda: float("nan"),
        lambda: "now",
    ],
)
def test_a_time_of_another_clock_is_refused(clock):
    source = ClockedCamera(picture())
    source.clock = clock
    with pytest.raises(
        (ValueError, TypeError), match=r"exposed of read\(\) must be time\.monotonic\(\) in s"
    ):
        Camera(source, area=SIZE, **PATIENT)


def test_an_object_needs_no_device_of_its_own():
    source = EndlessCamera(picture())
    source._open_device = lambda: robsim._core.PythonCamera(source, bgr=True)
    with pytest.raises(TypeError, match="must have bgr, True or False, not _open_device"):
        Camera(source)


def test_wrong_arguments_are_named():
    with Camera(EndlessCamera(picture()), **PATIENT) as camera:
        with pytest.raises(TypeError, match="motors"):
            check_camera(camera, motors=print)
        with pytest.raises(ValueError, match="seconds"):
            check_camera(camera, seconds=0)
    with pytest.raises(ValueError, match="colors must have red and blue"):
        check(picture(), colors=robsim.load_colors()[:1])


def lab_check(fps=20, faults=None, **options):
    options = {"robot": "lab", "area": SIZE, "resolution": SIZE, "seed": 1} | options
    world = robsim.Scenario(**options)
    with (
        SimulatedLab(world, fps=fps, faults=faults) as lab,
        Camera(lab, **PATIENT) as camera,
        UdpMotors(lab.address) as motors,
    ):
        report = check_camera(camera, robot="lab", motors=motors, seconds=300)
        assert not lab.truth.last_u.any()  # nothing drives
    return report


def test_a_lab_in_real_time_is_judged():
    report = lab_check()
    assert kinds(report) == set()
    assert report["frame rate"].value > 0
    assert report["round trip to the robot"].value > 0
    assert "the robot only received a stop" in report.remarks


@pytest.mark.slow
def test_slow_lossy_and_noisy_labs_are_named():
    assert lab_check(fps=3)["frame rate"].verdict == "bad"
    assert lab_check(faults=CameraFaults(dropped=0.4))["lost frames"].verdict == "bad"
    noisy = lab_check(noise=robsim.GaussianNoise(50), resolution=(200, 200))
    assert kinds(noisy) & {"scatter of the position", "scatter of the heading", "robot detected"}


def test_a_silent_camera_is_an_error():
    with (
        SimulatedLab(robsim.Scenario(robot="lab", area=SIZE, resolution=SIZE), fps=20) as lab,
        Camera(lab, **PATIENT) as camera,
    ):
        lab.stall(300)
        with suppress(FrameTimeoutError):
            while True:  # one may be on its way
                camera.read(0.2)
        with pytest.raises(FrameTimeoutError, match=r"0\.2 s"):
            check_camera(camera, seconds=0.2)


def test_the_picture_shows_what_was_found_or_that_there_is_no_robot():
    for options, k, text in (
        ({}, 2, "marker width"),
        ({"dropout": robsim.Dropout(1)}, 1, "the robot was not detected"),
    ):
        figure = robsim.plotting.plot_camera_check(check(picture(**options)))
        assert text in [one.get_text() for one in figure.axes[k].texts]
