"""A wrong calibration shows before the robot drives."""

import dataclasses
import math

import numpy as np
import pytest

import robsim
from photographed_sheets import DOTS, printed
from python_devices import PATIENT, EndlessCamera
from robsim.lab import (
    FloorSheet,
    Lens,
    SimulatedLab,
    calibrate_floor,
    calibrate_floor_by_sheets,
    check_camera,
    sheet_shifts,
)
from robsim.lab.rehearsal import _calibration_findings as mapping
from robsim.vision import Calibration, Intrinsics, PlaneMap

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("_checks_few_frames")]

SIZE = (480, 480)
MATRIX = [[420.0, 0, 239.5], [0, 420.0, 239.5], [0, 0, 1]]
AREA = (600, 600)
MM = 2.0


def looking(tilt, away, height=0.0, aside=0.0):
    """The map of a camera over the middle of the area, of what is some px above the floor.

    It stands some px aside from there.
    """
    c, s = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    turn = np.array([(1, 0, 0), (0, c, -s), (0, s, c)])
    middle = turn @ (aside - (AREA[0] - 1) / 2, -(AREA[1] - 1) / 2, 0) + (0, 0, away)
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


def picture(plane_map, start=(250.0, 330.0, 0.7), lens=None, **options):
    """What a camera sees of a robot on the floor that its map says."""
    scenario = robsim.Scenario(
        area=AREA, resolution=SIZE, start=start, headings=None, seed=1, noise=None, **options
    )
    with (
        SimulatedLab(scenario, plane_map=plane_map, lens=lens, fps=100) as lab,
        robsim.Camera(lab, **PATIENT) as camera,
    ):
        return np.array(camera.read().image)


def check(image, given):
    with robsim.Camera(EndlessCamera(image), calibration=given, **PATIENT) as camera:
        return check_camera(camera, seconds=300)


@pytest.fixture(scope="module")
def oblique():
    return picture(looking(30, 620, 40))


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


def test_without_a_calibration_it_is_advised(oblique):
    with robsim.Camera(EndlessCamera(oblique), area=AREA, **PATIENT) as camera:
        finding = check_camera(camera, seconds=300)["markers' distance"]
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
        pairs.append(mapping.MarkerPair(pixels, placed.mean(axis=0), ratio))
    assert mapping.spread_over_places(pairs, AREA) > 0.06
    assert math.isnan(mapping.spread_over_places(pairs[:3] * 5, AREA))


def test_a_lens_that_was_forgotten_changes_the_distance():
    image = picture(looking(0, 520), start=(70, 70, 0.7), lens=Lens(-0.12))
    report = check(image, calibration(0, 520))
    assert report["markers' distance"].verdict != "good"
    assert "closer together" in report["markers' distance"].remedy


@pytest.fixture(scope="module")
def laid():
    """A floor of 4 dots for a px, on which three sheets lie."""
    floor = np.full((2 * DOTS * AREA[1], 2 * DOTS * AREA[0], 3), 150, np.uint8)
    for number, (x, y) in {1: (100, 100), 2: (480, 120), 3: (320, 510)}.items():
        page = printed(FloorSheet(number))
        top, left = int(MM * DOTS * y) - len(page) // 2, int(MM * DOTS * x) - page.shape[1] // 2
        floor[top : top + len(page), left : left + page.shape[1]] = page[..., None]
    return floor


@pytest.fixture(scope="module")
def with_sheets(laid):
    """The calibration of a camera by sheets that stay where they lie."""
    lens = Calibration(size=SIZE, intrinsics=Intrinsics(MATRIX))
    image = picture(looking(20, 620), background=laid)
    report = calibrate_floor_by_sheets([image], area=AREA, mm_per_px=MM, lens=lens)
    assert report.verdict == "good"
    assert len(report.calibration.marks) == 18
    return image, report.calibration


def test_a_sheet_that_stays_tells_that_the_camera_was_not_moved(with_sheets):
    image, given = with_sheets
    report = check(image, given)
    assert report["shift of floor sheets"].verdict == "good"
    assert report["shift of floor sheets"].value < 0.2
    assert not any("in one place" in remark for remark in report.remarks)


@pytest.mark.parametrize(("tilt", "away", "aside"), [(24, 620, 30), (20, 620, 4), (21, 620, 0)])
def test_a_sheet_that_stays_tells_that_the_camera_was_moved(laid, with_sheets, tilt, away, aside):
    moved = picture(looking(tilt, away, aside=aside), background=laid)
    report = check(moved, with_sheets[1])
    # What the robot alone does not show where it stands
    assert report["markers' distance"].verdict == "good"
    finding = report["shift of floor sheets"]
    assert finding.verdict == ("poor" if tilt == 21 else "bad")
    assert finding.remedy.startswith("floor sheets 1, ")
    assert "calibrate the floor again" in finding.remedy
    assert finding.name in {problem.kind for problem in report.problems}


def test_a_sheet_that_was_moved_is_told_from_the_camera(with_sheets):
    image, given = with_sheets
    marks = {n: (u + 8 * (6 <= n < 12), v) for n, (u, v) in given.marks.items()}
    finding = check(image, dataclasses.replace(given, marks=marks))["shift of floor sheets"]
    assert finding.value == pytest.approx(8, abs=0.1)
    assert finding.remedy.startswith("floor sheet 2 is not where")
    assert "the others are: put the sheets back" in finding.remedy


def test_sheets_that_were_taken_away_are_missed(oblique, with_sheets):
    report = check(oblique, with_sheets[1])
    assert report["shift of floor sheets"].verdict == "not known"
    assert any("no floor sheet is in the picture" in remark for remark in report.remarks)


def test_measured_marks_and_a_picture_keep_the_sheets_in_it(with_sheets):
    image, given = with_sheets
    places = MM * np.array([(50.0, 50.0), (550, 50), (550, 550), (50, 550), (300, 300)])
    pixels = given.floor.to_pixel(places / MM)
    options = {"area": AREA, "mm_per_px": MM}
    kept = calibrate_floor(pixels, places, picture=image, **options).calibration
    assert kept.size == SIZE
    assert kept.marks.keys() == given.marks.keys()
    assert sheet_shifts(image, kept) == pytest.approx({1: 0, 2: 0, 3: 0}, abs=1e-9)
    assert not calibrate_floor(pixels, places, size=SIZE, **options).calibration.marks
    with pytest.raises(ValueError, match="size"):
        calibrate_floor(pixels, places, picture=image, size=(640, 480), **options)
    with pytest.raises(ValueError, match="size or picture"):
        calibrate_floor(pixels, places, **options)
    with pytest.raises(ValueError, match=r"480 x 400 px"):
        sheet_shifts(image[:400], kept)
    with pytest.raises(ValueError, match=r"size of image .*\(480, 9\)"):
        sheet_shifts(image[:9], kept)


def test_another_sheet_of_the_same_number_does_not_count(with_sheets):
    image, given = with_sheets
    twin = image.copy()
    part = image[60:130, 30:140]
    twin[260:330, 30:140] = part
    found = sheet_shifts(twin, given)
    assert found[1] < 0.2
    assert set(found) == {1, 2, 3}
