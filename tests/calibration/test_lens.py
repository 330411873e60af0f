"""The lens of a camera, from pictures of a board."""

import dataclasses

import numpy as np
import pytest

from photographed_sheets import VIEWS, Shot, board_pictures
from robsim.lab import Charuco, Chessboard, calibrate_lens
from sizes import thorough

pytestmark = pytest.mark.long

cv2 = pytest.importorskip("cv2")

BASE = Shot()
BOARD = Charuco(9, 6, 28)


def errors_over_the_picture(found, base=BASE):
    """How far apart both lenses show the same ray, but for turning the camera (px)."""
    grid = np.stack(np.meshgrid(np.linspace(20, 619, 12), np.linspace(20, 459, 9)), -1)
    pixels = grid.reshape(-1, 2)
    rays = cv2.undistortPoints(pixels[:, None], base.matrix, np.array(base.distortion))[:, 0]
    rays = np.column_stack([rays, np.ones(len(rays))])
    k = np.asarray(found.matrix)
    own = np.column_stack([found.ideal(pixels), np.ones(len(pixels))]) @ np.linalg.inv(k).T
    rays, own = (r / np.linalg.norm(r, axis=1, keepdims=True) for r in (rays, own))
    # Kabsch's rotation between both bundles of rays
    left, _, right = np.linalg.svd(own.T @ rays)
    turned = own @ (left @ right)
    return base.focal * np.linalg.norm(turned - rays, axis=1)


def rms(errors):
    return float(np.sqrt((errors**2).mean()))


@pytest.fixture(scope="module")
def pictures():
    return list(board_pictures(BOARD))


def test_a_lens_is_found_from_a_few_pictures_of_a_board(pictures):
    report = calibrate_lens(pictures, BOARD)
    assert report.rms < 0.15
    assert rms(errors_over_the_picture(report.calibration.intrinsics)) < 0.6
    assert report.calibration.size == (640, 480)
    assert not report.has_k3
    assert report.calibration.lens_residuals.pictures == 8
    assert report.verdict in ("good", "poor")


# Of eight seeds, the chessboard gives 0.09 to 0.36 px, the ChArUco board 0.06 to 0.37 px.
@pytest.mark.parametrize(
    ("board", "most"), [(Chessboard(9, 6, 20), 0.2), *thorough(((BOARD, 0.3),), ())]
)
def test_more_pictures_give_a_good_lens(board, most):
    rng = np.random.default_rng(2)
    views = [
        (*rng.uniform(0.28, 0.72, 2), rng.uniform(430, 650), *rng.uniform(-0.6, 0.6, 2))
        for _ in range(16)
    ]
    report = calibrate_lens(board_pictures(board, views, rng=rng), board)
    assert report.rms < 0.12
    errors = errors_over_the_picture(report.calibration.intrinsics)
    assert rms(errors) < most
    assert errors.max() < 1


def test_a_third_coefficient_is_fitted_where_the_pictures_determine_it():
    base = dataclasses.replace(BASE, distortion=(-0.3, 0.2, 0.0, 0.0, -0.12))
    rng = np.random.default_rng(3)
    views = [
        (*rng.uniform(0.2, 0.8, 2), rng.uniform(380, 520), *rng.uniform(-0.6, 0.6, 2))
        for _ in range(16)
    ]
    report = calibrate_lens(board_pictures(BOARD, views, base, rng), BOARD)
    assert report.has_k3
    assert report.calibration.intrinsics.distortion[4] == pytest.approx(-0.12, abs=0.06)
    assert rms(errors_over_the_picture(report.calibration.intrinsics, base)) < 0.3


def test_what_is_missing_is_said():
    flat = [(0.4, 0.6, 520, 0.02, 0.01), (0.45, 0.55, 500, 0, 0.03), (0.4, 0.5, 480, 0.05, 0.02)]
    report = calibrate_lens(board_pictures(BOARD, [*flat, (0.45, 0.6, 550, 0.1, 0.0)]), BOARD)
    said = " ".join(problem.sentence for problem in report.problems)
    assert "tilt it" in said
    assert "4 pictures" in said
    assert "right" in report.empty_parts
    assert report.verdict != "good"


def test_a_picture_with_another_zoom_is_named_and_left_out(pictures):
    pictures = list(pictures)
    other = dataclasses.replace(BASE, focal=640.0)
    pictures[4:5] = board_pictures(BOARD, VIEWS[4:5], other)
    names = [f"board-{n}.png" for n in range(8)]
    report = calibrate_lens(pictures, BOARD, names=names)
    assert [one.name for one in report.pictures if not one.is_used] == ["board-4.png"]
    assert "board-4.png" in report.problems[-1].sentence
    assert errors_over_the_picture(report.calibration.intrinsics).max() < 1.2


def test_pictures_that_are_too_few_or_of_several_sizes_are_refused(pictures):
    grey = np.full((480, 640, 3), 150, np.uint8)
    names = ["first.png", "second.png"]
    for given, options, words in (
        (pictures[:2], {}, "got 2 of 2"),
        ([grey, grey], {}, r"got 0 of 2.*9 x 6"),
        ([grey, grey[:400]], {}, r"640 x 480 px.*640 x 400 px.*number 2"),
        ([grey, grey[:400]], {"names": names}, r"640 x 400 px.*second\.png"),
        ([], {}, "empty"),
    ):
        with pytest.raises(ValueError, match=words):
            calibrate_lens(given, BOARD, **options)
