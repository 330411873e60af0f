"""A wrong calibration shows before the robot drives."""

import math

import numpy as np
import pytest

import robsim
from python_cameras import EndlessCamera
from robsim.imaging import Calibration, Intrinsics, PlaneMap
from robsim.live import Lens, SimulatedLab, check_camera
from robsim.live import _calibration_findings as mapping

SIZE = (480, 480)
MATRIX = [[420.0, 0, 239.5], [0, 420.0, 239.5], [0, 0, 1]]
AREA = (600, 600)
MM = 2.0


def looking(tilt, away, height=0.0):
    """The map of a camera over the middle of the area, of what is some px above the floor."""
    c, s = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    turn = np.array([(1, 0, 0), (0, c, -s), (0, s, c)])
    middle = turn @ (-(AREA[0] - 1) / 2, -(AREA[1] - 1) / 2, 0) + (0, 0, away)
    to_pixel = np.array(MATRIX) @ np.column_stack([turn[:, :2], middle - height * turn[:, 2]])
    return PlaneMap(np.linalg.inv(to_pixel))


def calibration(tilt, away, **options):
    return Calibration(
        size=SIZE,
        intrinsics=Intrinsics(MATRIX),
        floor=looking(tilt, away),
        area=AREA,
        mm_per_px=MM,
        **options,
    )


def picture(tilt, away, height=0.0, start=(250.0, 330.0, 0.7)):
    """What the camera sees of a robot whose markers are some px high."""
    scenario = robsim.Scenario(
        area=AREA, resolution=SIZE, start=start, headings=None, seed=1, noise=None
    )
    with (
        SimulatedLab(scenario, plane_map=looking(tilt, away, height), fps=100) as lab,
        robsim.Camera(lab) as camera,
    ):
        return np.array(camera.read().image)


def check(image, given):
    with robsim.Camera(EndlessCamera(image, 2000), calibration=given) as camera:
        return check_camera(camera, seconds=0.1)


@pytest.fixture(scope="module")
def oblique():
    return picture(30, 620, 40)


def test_the_right_calibration_is_good(oblique):
    report = check(oblique, calibration(30, 620, marker_height=80))
    assert report["markers' distance"].verdict == "good"
    assert abs(report["markers' distance"].value) < 1
    assert report["markers' distance, by place"].verdict == "not known"
    assert report["work area in the picture"].verdict == "good"
    assert any("was tried in one place" in remark for remark in report.remarks)
    assert np.abs(report.measurement.pose[:2] - (250, 330)).max() < 1.5


def test_a_height_that_was_forgotten_is_named(oblique):
    report = check(oblique, calibration(30, 620))
    finding = report["markers' distance"]
    assert finding.verdict in ("poor", "bad")
    assert "calibrated for markers on the floor" in finding.remedy
    height = float(finding.remedy.partition(", and ")[2].partition(" mm")[0])
    assert height == pytest.approx(80, abs=12)


@pytest.mark.parametrize(("tilt", "away"), [(0, 620), (30, 900), (30, 480)])
def test_the_calibration_of_another_mounting_shows(oblique, tilt, away):
    report = check(oblique, calibration(tilt, away, marker_height=80))
    wrong = {problem.kind for problem in report.problems}
    assert wrong & {"markers' distance", "work area in the picture"}
    assert report.verdict != "good"


def test_no_height_is_advised_that_no_robot_has(oblique):
    remedy = check(oblique, calibration(30, 900, marker_height=80))["markers' distance"].remedy
    assert "they would fit" not in remedy
    assert "was the camera moved or zoomed since its calibration" in remedy


@pytest.mark.slow
def test_without_a_calibration_it_is_advised(oblique):
    with robsim.Camera(EndlessCamera(oblique, 2000), area=AREA) as camera:
        finding = check_camera(camera, seconds=0.1)["markers' distance"]
    assert finding.verdict == "bad"
    assert "robsim calibrate" in finding.remedy


def test_a_tilt_that_was_forgotten_shows_from_place_to_place():
    true, wrong = looking(30, 620), looking(0, 620)
    distance = 40.0
    pairs = []
    for y in np.linspace(100, 500, 20):
        pixels = true.to_pixel(np.array([(300 - distance / 2, y), (300 + distance / 2, y)]))
        placed = wrong.to_world(pixels)
        ratio = float(np.linalg.norm(placed[0] - placed[1])) / distance
        pairs.append(mapping.MarkerPair(*pixels, placed.mean(axis=0), ratio))
    assert mapping.spread_over_places(pairs, AREA) > 0.06
    assert math.isnan(mapping.spread_over_places(pairs[:3] * 5, AREA))


@pytest.mark.slow
def test_a_lens_that_was_forgotten_changes_the_distance():
    scenario = robsim.Scenario(area=AREA, resolution=SIZE, start=(70, 70, 0.7), seed=1, noise=None)
    with (
        SimulatedLab(scenario, plane_map=looking(0, 520), lens=Lens(-0.12), fps=100) as lab,
        robsim.Camera(lab) as camera,
    ):
        image = np.array(camera.read().image)
    report = check(image, calibration(0, 520))
    assert report["markers' distance"].verdict != "good"
    assert "closer together" in report["markers' distance"].remedy
