"""Where a camera looks at the floor from: by marks, and by sheets."""

import dataclasses
import math

import cv2
import numpy as np
import pytest

from photographed_sheets import LAID, Shot, floor_picture
from robsim.lab import calibrate_floor, calibrate_floor_by_sheets, draw_grid
from robsim.vision import Calibration, Intrinsics
from sizes import thorough

# 30 degrees aside, and a lens that distorts by 4 % in the corners of its picture.
SHOT = Shot(
    focal=620.0,
    distortion=(-0.09, 0.004, 0.0008, -0.0005, 0.0),
    turn=(-math.radians(30), 0.0, 0.0),
    place=(0.0, 100.0, 2400.0),
)
LENS = Calibration(size=SHOT.size, intrinsics=Intrinsics(SHOT.matrix, distortion=SHOT.distortion))
AREA = {"area": (1000, 800), "mm_per_px": 2.0}
CORNER = np.array((-1000.0, -900.0))  # of the area, in the axes of the camera's floor


def floor(count=5):
    """Places on the area (mm) and their pixels."""
    grid = np.stack(np.meshgrid(np.linspace(100, 1900, count), np.linspace(100, 1500, count)), -1)
    places = grid.reshape(-1, 2)
    return places, pixels_of(places)


def pixels_of(places, height=0.0):
    return SHOT.pixels(np.column_stack([places + CORNER, np.full(len(places), height)]))


def errors_at(calibration, height):
    """How far off the map is over all of the area that is seen (work-area px)."""
    places, _ = floor(25)
    pixels = pixels_of(places, height)
    seen = ((pixels >= 0) & (pixels <= np.array(SHOT.size) - 1)).all(axis=1)
    assert seen.mean() > 0.6
    return calibration.plane_map.to_world(pixels[seen]) - places[seen] / 2


def sentences(report):
    return " ".join(problem.sentence for problem in report.problems)


def rms(errors):
    return float(np.sqrt((errors**2).sum(axis=-1).mean()))


@pytest.mark.long
def test_marks_give_the_map_at_the_markers_height():
    rng = np.random.default_rng(3)
    places, pixels = floor()
    noisy = pixels + 0.1 * rng.standard_normal(pixels.shape)
    report = calibrate_floor(noisy, places, lens=LENS, marker_height=160, **AREA)
    assert report.verdict == "good"
    assert rms(errors_at(report.calibration, 160)) < 0.15
    # What the tilt, the lens and the height are worth
    flat = calibrate_floor(noisy, places, size=SHOT.size, **AREA)
    assert rms(errors_at(flat.calibration, 160)) > 20
    assert flat.verdict != "good"
    assert report.calibration.floor_residuals.points == 25


@pytest.mark.long
@pytest.mark.parametrize("with_lens", [True, False])
def test_a_wrong_mark_is_named_and_left_out(with_lens):
    places, pixels = floor(3)
    if not with_lens:
        pixels = cv2.undistortPoints(
            pixels[:, None], SHOT.matrix, np.array(SHOT.distortion), P=SHOT.matrix
        ).reshape(-1, 2)
    pixels = pixels + 0.2 * np.random.default_rng(8).standard_normal(pixels.shape)
    moved = places.copy()
    moved[3] += (40, -20)
    names = [f"mark {n}" for n in range(9)]
    options = {"lens": LENS} if with_lens else {"size": SHOT.size}
    report = calibrate_floor(pixels, moved, names=names, **options, **AREA)
    left_out = [one for one in report.points if not one.is_used]
    assert [one.name for one in left_out] == ["mark 3"]
    assert left_out[0].mm == pytest.approx(math.hypot(40, 20), abs=8)
    assert "mark 3" in sentences(report)
    right = calibrate_floor(pixels, places, names=names, **options, **AREA)
    assert all(one.is_used for one in right.points)


@pytest.mark.long
def test_the_chance_that_right_marks_are_called_wrong_is_small():
    places, pixels = floor(3)
    rng = np.random.default_rng(11)
    for _ in range(thorough(20, 6)):
        noisy = pixels + 1.5 * rng.standard_normal(pixels.shape)
        report = calibrate_floor(noisy, places, lens=LENS, **AREA)
        assert all(one.is_used for one in report.points)


def test_marks_of_one_name_are_averaged():
    places, pixels = floor(2)
    shift = np.array((3.0, -2.0))
    report = calibrate_floor(
        np.concatenate([pixels + shift, pixels - shift]),
        np.concatenate([places, places]),
        names=[*"abcd"] * 2,
        lens=LENS,
        **AREA,
    )
    assert len(report.points) == 4
    assert rms(errors_at(report.calibration, 0)) < 1e-3


def test_a_wrong_one_of_few_marks_is_not_pinned_on_the_worst():
    places, pixels = floor(3)
    few = [0, 2, 6, 8, 4]
    moved = places[few] + np.eye(5, 2) * (40, 0)
    report = calibrate_floor(pixels[few], moved, size=SHOT.size, **AREA)
    assert report.worst.name != "1"
    assert "separates it from all others" in sentences(report)


def test_a_wrong_mark_of_four_is_found_by_a_fifth():
    places, pixels = floor(3)
    few = [0, 2, 6, 8, 4]
    moved = places[few] + np.eye(5, 2) * (60, 0)
    four = calibrate_floor(pixels[few[:4]], moved[:4], lens=LENS, **AREA)
    assert "one point of 4 is wrong" in sentences(four)
    assert "fits worst" not in str(four)
    five = calibrate_floor(pixels[few], moved, lens=LENS, **AREA)
    assert [one.name for one in five.points if not one.is_used] == ["1"]


def test_four_marks_without_a_lens_are_not_checked_and_a_fifth_checks_them():
    places, pixels = floor(3)
    few = [0, 2, 6, 8, 4]
    wrong = places[few] + np.eye(5, 2) * (40, 0)
    for positions in (places[few], wrong):
        report = calibrate_floor(pixels[few[:4]], positions[:4], size=SHOT.size, **AREA)
        assert np.isnan(report.expected_errors).all()
        assert report.verdict == "not checked"
        assert any("a fifth point checks them" in remark for remark in report.remarks)
    assert calibrate_floor(pixels[few], wrong, size=SHOT.size, **AREA).verdict == "bad"


def test_what_is_wrong_is_refused_by_its_name():
    places, pixels = floor(3)
    good = {"pixels": pixels, "positions": places, "lens": LENS, **AREA}
    line = np.array([(0.0, 0.0), (500, 0), (1000, 0), (1500, 0), (1700, 0)])
    for change, words in (
        ({"pixels": [(1, 2)] * 3, "positions": [(1, 2)] * 3}, "got 3"),
        ({"positions": [(1, 2)] * 4}, "positions"),
        ({"size": (64, 48)}, "64 x 48 px"),
        ({"lens": None}, "size"),
        ({"marker_height": 9000}, "camera"),
        ({"positions": places * (1, -1)}, "mirrored"),
        ({"positions": line, "pixels": pixels_of(line)}, "line"),
    ):
        given = good | change
        with pytest.raises((TypeError, ValueError), match=words):
            calibrate_floor(given.pop("pixels"), given.pop("positions"), **given)


@pytest.fixture(scope="module")
def picture():
    return floor_picture(SHOT)


def test_a_mirrored_picture_of_sheets_is_named(picture):
    with pytest.raises(ValueError, match="mirrored"):
        calibrate_floor_by_sheets([picture[:, ::-1]], **AREA)


def crosses():
    return {
        number: tuple((np.array(place[:2]) - CORNER).tolist()) for number, place in LAID.items()
    }


@pytest.mark.long
def test_sheets_anywhere_on_the_floor_give_the_map(picture):
    report = calibrate_floor_by_sheets(
        [picture], lens=LENS, marker_height=160, places=crosses(), **AREA
    )
    assert report.verdict == "good"
    assert rms(errors_at(report.calibration, 160)) < 0.3
    assert max(report.places_off.values()) < 1
    assert report.print_scale == pytest.approx(1, abs=1e-3)


@pytest.mark.long
def test_one_sheet_is_the_middle_of_the_area_in_its_axes(picture):
    report = calibrate_floor_by_sheets([picture], lens=LENS, **AREA)
    x, y, angle = LAID[1]
    ahead = np.array([(x, y, 0), (x + 100 * math.cos(angle), y + 100 * math.sin(angle), 0)])
    found = report.calibration.plane_map.to_world(SHOT.pixels(ahead))
    np.testing.assert_allclose(found, [(500, 400), (550, 400)], atol=0.2)


@pytest.mark.long
def test_a_sheet_in_another_place_and_a_scaled_print_are_named(picture):
    places = crosses()
    places[4] = (places[4][0] + 60, places[4][1])
    report = calibrate_floor_by_sheets([picture], lens=LENS, places=places, **AREA)
    assert "sheet 4 is" in sentences(report)
    # Printed at 97 %, its marks have 77.6 mm, and not 80
    report = calibrate_floor_by_sheets([picture], lens=LENS, places=crosses(), mark=82.5, **AREA)
    assert report.print_scale == pytest.approx(80 / 82.5, abs=2e-3)
    assert "100 %" in sentences(report)


@pytest.mark.long
def test_pictures_without_sheets_and_places_of_none_are_refused(picture):
    grey = np.full((480, 640, 3), 150, np.uint8)
    with pytest.raises(ValueError, match="floor sheet"):
        calibrate_floor_by_sheets([grey], lens=LENS, **AREA)
    doubled = np.concatenate([picture, picture], axis=1)
    with pytest.raises(ValueError, match="sheet 1 twice"):
        calibrate_floor_by_sheets([doubled], **AREA)
    with pytest.raises(ValueError, match=r"sheet 9.*1, 2, 3, 4, 5"):
        calibrate_floor_by_sheets([picture], lens=LENS, places={9: (0, 0)}, **AREA)
    with pytest.raises(ValueError, match="one size"):
        calibrate_floor_by_sheets([picture, picture[:400]], lens=LENS, **AREA)


@pytest.mark.long
def test_the_grid_lies_on_the_floor():
    places, pixels = floor(3)
    report = calibrate_floor(pixels, places, lens=LENS, marker_height=160, **AREA)
    grey = np.full((480, 640, 3), 100, np.uint8)
    drawn = draw_grid(grey, report.calibration, step=400).astype(int)
    is_yellow = (drawn[..., 0] - drawn[..., 2]) > 60
    is_blue = (drawn[..., 2] - drawn[..., 0]) > 40
    for height, mask in ((0, is_yellow), (160, is_blue)):
        crossings = pixels_of(np.array([(800.0, 620.0), (1200.0, 1000.0), (620.0, 800.0)]), height)
        between = pixels_of(np.array([(1000.0, 1000.0), (600.0, 1000.0)]), height)
        for u, v in np.rint(crossings).astype(int):
            assert mask[v - 1 : v + 2, u - 1 : u + 2].any()
        for u, v in np.rint(between).astype(int):
            assert not mask[v, u]
    with pytest.raises(ValueError, match=r"320 x 240.*640 x 480"):
        draw_grid(grey[:240, :320], report.calibration)
    with pytest.raises(ValueError, match=r"size of image .*\(640, 9\)"):
        draw_grid(grey[:9], report.calibration)
    with pytest.raises(ValueError, match="floor"):
        draw_grid(grey, dataclasses.replace(LENS))
