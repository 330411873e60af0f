"""Sheets as PDF at true scale, and what is found of them in pictures."""

import re

import numpy as np
import pytest

from photographed_sheets import FLOOR, VIEWS, Shot, board_pictures, photograph, true_pixels
from robsim.lab import Charuco, Chessboard, FloorSheet, find_sheets, save_sheet
from robsim.lab.calibration.patterns.unseen import why_unseen

cv2 = pytest.importorskip("cv2")

MM = 72 / 25.4
NEAR = Shot(turn=(0.3, -0.2, 0.1), place=(10.0, -5.0, 620.0))


def drawn(file):
    """Width and height of the page, and left, bottom, width, height of all that is black (mm)."""
    content = file.read_bytes().decode("ascii")
    width, height = re.search(r"MediaBox \[0 0 (\S+) (\S+)\]", content).groups()
    scale = float(re.search(r"(\S+) 0 0 \S+ 0 0 cm", content)[1]) / MM
    black = [
        [scale * float(one) for one in found]
        for found in re.findall(r"^(\S+) (\S+) (\S+) (\S+) re f$", content, re.MULTILINE)
    ]
    return (float(width) / MM, float(height) / MM), np.array(black), content


@pytest.mark.parametrize(
    ("pattern", "paper", "page"),
    [
        (Chessboard(9, 6, 25), "A4", (297, 210)),
        (Charuco(9, 6, 40), "A3", (420, 297)),
        (FloorSheet(16), "letter", (279.4, 215.9)),
    ],
)
def test_a_sheet_has_its_true_size_and_a_line_of_100_mm(tmp_path, pattern, paper, page):
    file = tmp_path / "sheet.pdf"
    save_sheet(file, pattern, paper=paper)
    size, black, content = drawn(file)
    np.testing.assert_allclose(size, page, atol=0.001)
    np.testing.assert_allclose(black[:, 2].max(), 100, atol=0.001)
    assert "PrintScaling /None" in content
    count = len(pattern.rectangles)
    left, bottom = black[:count, :2].min(axis=0)
    right, top = (black[:count, :2] + black[:count, 2:]).max(axis=0)
    expected = (pattern.columns * 25 + 25, 7 * 25) if paper == "A4" else pattern.size
    np.testing.assert_allclose((right - left, top - bottom), expected, atol=0.01)
    assert min(left, bottom, page[0] - right, page[1] - top) > 5


def test_the_references_of_a_pdf_lead_to_its_objects(tmp_path):
    file = tmp_path / "sheet.pdf"
    save_sheet(file, Chessboard())
    content = file.read_bytes()
    start = int(re.search(rb"startxref\n(\d+)", content)[1])
    assert content[start:].startswith(b"xref")
    offsets = [int(one) for one in re.findall(rb"^(\d{10}) 00000 n ", content, re.MULTILINE)]
    for number, offset in enumerate(offsets, start=1):
        assert content[offset:].startswith(b"%d 0 obj" % number)
    length = int(re.search(rb"/Length (\d+)", content)[1])
    stream = content.index(b"stream\n") + len(b"stream\n")
    assert content[stream + length :].startswith(b"\nendstream")


def test_what_does_not_fit_on_the_paper_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"287 x 189 mm.*300 x 210 mm"):
        save_sheet(tmp_path / "sheet.pdf", Chessboard(9, 6, 30))
    with pytest.raises(ValueError, match=r"\.pdf"):
        save_sheet(tmp_path / "sheet.png", Chessboard())


@pytest.mark.long
@pytest.mark.parametrize("board", [Chessboard(9, 6, 20), Charuco(9, 6, 28)])
def test_corners_are_found_to_a_tenth_of_a_pixel(board):
    rng = np.random.default_rng(5)
    found = board.find(photograph(NEAR, [(board, (0, 0, 0))], rng=rng))
    from_centre = found.positions - np.array(board.size) / 2
    if found.pixels[0, 0] > found.pixels[-1, 0]:  # a chessboard has no top
        from_centre = -from_centre
    errors = found.pixels - true_pixels(NEAR, from_centre, (0, 0, 0))
    assert len(errors) >= 30
    assert np.sqrt((errors**2).sum(axis=1).mean()) < 0.12


@pytest.mark.long
def test_the_marks_of_floor_sheets_are_found_to_a_twentieth_of_a_pixel():
    rng = np.random.default_rng(6)
    shot = Shot(turn=(-0.5, 0.1, 0.2), place=(0.0, 0.0, 1500.0))
    places = {3: (-250.0, -100.0, 0.4), 16: (260.0, 150.0, 2.5)}
    sheets = [(FloorSheet(number), place) for number, place in places.items()]
    found = find_sheets(photograph(shot, sheets, rng=rng), 80.0)
    assert list(found) == [3, 16]
    for number, corners in found.items():
        errors = corners.pixels - true_pixels(shot, corners.positions, places[number])
        assert len(errors) == 24
        assert np.sqrt((errors**2).sum(axis=1).mean()) < 0.1
        assert np.abs(errors.mean(axis=0)).max() < 0.05


def in_the_dark(picture, rng):
    """The picture of a lit sheet in a dark room, its right half brighter, blurred, with noise."""
    light = np.where(np.abs(picture[..., 0] - float(FLOOR)) < 12, 12.0, picture[..., 0])
    light *= np.linspace(0.25, 0.7, light.shape[1])
    light = cv2.GaussianBlur(light, (0, 0), 1.0) + 3 * rng.standard_normal(light.shape)
    return np.repeat(np.clip(light, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)


def test_a_whole_board_is_found_in_the_dark():
    rng = np.random.default_rng(3)
    board = Chessboard(9, 6, 20)
    for picture in board_pictures(board, VIEWS[:4], rng=rng, farther=1.5):
        found = board.find(in_the_dark(picture, rng))
        assert found is not None
        assert len(found.pixels) == 54


@pytest.mark.parametrize(
    ("board", "turn", "place"),
    [
        (Chessboard(11, 8, 16), (0.21, 1.26, -2.15), (98, 114, 536)),
        (Chessboard(7, 5, 25), (0.39, 0.98, 0.89), (-259, -174, 828)),
    ],
)
def test_a_board_whose_squares_are_narrow_rhombs_is_found(board, turn, place):
    shot = Shot(turn=turn, place=place)
    picture = photograph(shot, [(board, (0, 0, 0))])
    found = board.find(picture)
    true = true_pixels(shot, found.positions - np.array(board.size) / 2, (0, 0, 0))
    errors = min(found.pixels - true, found.pixels[::-1] - true, key=np.ptp)  # it has no top
    assert np.sqrt((errors**2).sum(axis=1).mean()) < 0.3


def test_a_board_whose_corners_are_cut_off_is_not_guessed():
    board, shot = Chessboard(8, 5, 22), Shot(turn=(-0.3, 0.89, -0.9), place=(-201, 213, 853))
    picture = photograph(shot, [(board, (0, 0, 0))])
    left = np.sort(board.find(picture).pixels[:, 0])
    assert board.find(picture[:, int(left[1]) + 1 :]) is None


def test_a_board_of_another_size_is_not_found():
    picture = photograph(NEAR, [(Chessboard(9, 6, 20), (0, 0, 0))])
    for size in ((8, 6), (9, 5), (8, 5), (10, 6), (9, 7), (10, 7)):
        assert Chessboard(*size, 20).find(picture) is None, size


HELD = Chessboard(9, 6, 20)


def held(*view):
    return next(board_pictures(HELD, [view]))


def covered(level, spread):
    """A board with a patch of a level in its middle, soft at its border."""
    picture = held(0.5, 0.5, 450, 0.0, 0.5).astype(float)
    v, u = np.indices(picture.shape[:2])
    patch = np.clip(3 - np.hypot(u - 320, v - 240) / spread, 0, 1)[:, :, None]
    return (picture + patch * (level - picture)).astype(np.uint8)


def smeared():
    kernel = np.zeros((31, 31))
    cv2.line(kernel, (2, 10), (28, 20), 1, 1)
    return cv2.filter2D(held(*VIEWS[1]), -1, kernel / kernel.sum())


@pytest.mark.parametrize(
    ("picture", "board", "why"),
    [
        (lambda: held(0.02, 0.4, 380, 0.3, 0.1), HELD, "whole"),
        (lambda: covered(255, 20), HELD, "glare"),
        (lambda: covered(120, 12), HELD, "covered"),
        (lambda: smeared(), HELD, "blurred"),
        (lambda: held(*VIEWS[1]), Chessboard(7, 5, 20), "9 x 6"),
        (lambda: np.full((480, 640, 3), 9, np.uint8), HELD, "dark"),
        (lambda: np.full((480, 640, 3), 150, np.uint8), HELD, "too few"),
    ],
)
def test_a_board_that_is_not_found_has_a_reason(picture, board, why):
    assert board.find(picture()) is None
    assert why in why_unseen(board, picture())


def test_a_mirrored_picture_of_a_charuco_board_is_noticed():
    board = Charuco(9, 6, 28)
    picture = next(board_pictures(board, VIEWS[4:5]))[:, ::-1]
    assert board.find(picture) is None
    assert why_unseen(board, picture) == "mirrored"


def test_no_board_is_found_where_there_is_none():
    grey = np.full((480, 640, 3), 150, np.uint8)
    for board in (Chessboard(), Charuco()):
        assert board.find(grey) is None
    assert find_sheets(grey, 80.0) == {}


def test_a_picture_that_opencv_could_not_take_is_refused():
    for shape in ((2**32, 8, 3), (8, 40_000, 3), (0, 8, 3)):
        with pytest.raises(ValueError, match=r"^image"):
            Chessboard(7, 5, square=20).find(np.broadcast_to(np.uint8(0), shape))
