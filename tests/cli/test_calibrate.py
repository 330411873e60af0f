"""The commands ``robsim calibrate``, and those that take a calibration."""

import json
import re
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from photographed_sheets import LAID, OBLIQUE, VIEWS, board_pictures, floor_picture
from python_devices import EndlessCamera
from robsim.cli import app
from robsim.lab import Chessboard
from robsim.lab.calibration.taking import BoardTaker
from robsim.trace import Trace
from robsim.vision import (
    Calibration,
    Intrinsics,
    load_calibration,
    load_image,
    save_calibration,
    save_image,
)

pytestmark = pytest.mark.long

pytest.importorskip("cv2")
BOARD = Chessboard(9, 6, 25)
AREA = ("--area", "1000x800", "--scale", "2")


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def calibrate(*arguments):
    """Run ``robsim calibrate`` in this process."""
    return CliRunner(env={"COLUMNS": "80"}).invoke(app, ["calibrate", *map(str, arguments)])


def refused(*arguments):
    result = calibrate(*arguments)
    assert result.exit_code == 2, result.output
    return result.stderr


def lens_file():
    lens = Intrinsics(OBLIQUE.matrix, distortion=OBLIQUE.distortion)
    save_calibration("camera.toml", Calibration(size=OBLIQUE.size, intrinsics=lens))


def marks_file(count=9):
    places = np.array([(x, y) for y in (200, 800, 1400) for x in (200, 1000, 1800)], float)
    seen = OBLIQUE.pixels(np.column_stack([places - (1000, 800), np.zeros(9)]))
    lines = [
        f"m{n}, {u}, {v}, {x}, {y}"
        for n, ((u, v), (x, y)) in enumerate(zip(seen.tolist(), places.tolist(), strict=True))
    ]
    Path("marks.csv").write_text("\n".join(["name,u,v,x,y", *lines[:count]]))


@pytest.mark.parametrize(
    ("separator", "point", "coding"), [(";", ",", "utf-8-sig"), ("\t", ".", "utf-16")]
)
def test_marks_of_a_spreadsheet_are_read(separator, point, coding):
    lens_file()
    marks_file()
    text = Path("marks.csv").read_text().replace(", ", ",")
    text = text.replace(",", separator).replace(".", point)
    Path("marks.csv").write_bytes(text.encode(coding))
    result = calibrate("floor", "--calibration", "camera.toml", *AREA, "--marks", "marks.csv")
    assert result.exit_code == 0, result.output


def test_marks_give_a_floor_and_its_grid():
    lens_file()
    marks_file()
    options = ("--calibration", "camera.toml", *AREA, "--marker-height", "16cm")
    result = calibrate("floor", "--marks", "marks.csv", *options)
    assert result.exit_code == 0, result.output
    assert "Calibration of the floor: good" in result.stdout
    made = load_calibration("camera.toml")
    assert made.marker_height == 160
    ahead = OBLIQUE.pixels([(100.0, 50.0, 160.0)])
    np.testing.assert_allclose(made.plane_map.to_world(ahead), [(550, 425)], atol=0.01)
    save_image("floor.png", np.full((480, 640, 3), 90, np.uint8))
    assert calibrate("check", "floor.png", "--out", "grid.png").exit_code == 0
    assert load_image("grid.png").shape == (480, 640, 3)
    assert "would overwrite" in refused("check", "floor.png", "--out", "floor.png")


def test_check_tells_by_how_far_sheets_lie_elsewhere():
    lens_file()
    save_image("floor.png", floor_picture(OBLIQUE))
    assert calibrate("floor", "floor.png", "--calibration", "camera.toml", *AREA).exit_code == 0
    made = load_calibration("camera.toml")
    x, y, z = OBLIQUE.place
    save_image("later.png", floor_picture(replace(OBLIQUE, place=(x + 60, y, z))))
    for file, least, most in (("floor.png", 0, 0.05), ("later.png", 8, 20)):
        said = calibrate("check", file, "--out", "grid.png").output
        shifts = [float(shift) for shift in re.findall(r"^floor sheet \d+\D+(\S+)", said, re.M)]
        assert len(shifts) == len({number // 6 for number in made.marks}) >= 4
        assert least <= min(shifts) <= max(shifts) <= most, said
        assert ("moved" in said) == (file == "later.png")
    save_image("bare.png", np.full((480, 640, 3), 90, np.uint8))
    assert "no floor sheet" in calibrate("check", "bare.png", "--out", "grid.png").stdout


def test_marks_and_the_grid_need_no_opencv(monkeypatch):
    save_image("floor.png", np.full((480, 640, 3), 90, np.uint8))
    monkeypatch.setitem(sys.modules, "cv2", None)
    corners = ("--pixels", "9,9 630,9 630,470 9,470", "--positions", "0,0 2000,0 2000,1600 0,1600")
    assert calibrate("floor", "floor.png", *corners, *AREA).exit_code == 0
    marks = {0: (30.0, 40.0)}
    save_calibration("camera.toml", replace(load_calibration("camera.toml"), marks=marks))
    assert calibrate("check", "floor.png", "--out", "grid.png").exit_code == 0
    assert Path("grid.png").is_file()


def test_what_is_missing_or_wrong_is_named():
    lens_file()
    marks_file(3)
    save_image("grey.png", np.full((480, 640, 3), 90, np.uint8))
    Path("bad.csv").write_text("a,1,2,3,4\nb,nan,2,3,4\n")
    Path("empty.csv").write_text("name,u,v,x,y\n")
    Path("large.csv").write_text("a,1,2,3,4\n" * 2**17)
    Path("coded.csv").write_bytes("M\u00fcller,1,2,3,4\n".encode("latin-1"))
    floor = ("floor", "--calibration", "camera.toml", *AREA)
    sheet = ("sheet", "--out", "a.pdf")
    for named, arguments in {
        "got 3": (*floor, "--marks", "marks.csv"),
        "--area and --scale": ("floor", "x.png"),
        "--marker-height needs --calibration": ("floor", "x.png", *AREA, "--marker-height", "80mm"),
        "--calibration": ("floor", "x.png", *AREA, "--calibration", "board.pdf"),
        "picture": floor,
        "--marker-height must": (*floor, "--marker-height", "high"),
        "--place": (*floor, "grey.png", "--place", "one"),
        "empty.csv": (*floor, "--marks", "empty.csv"),
        "number": (*sheet, "--kind", "floor", "--number", "17"),
        "--board": ("lens", "x.png", "--board", "9"),
        "--positions": (*floor, "--pixels", "1,2 3,4 5,6 7,8"),
        "bad.csv: mark 2": (*floor, "--marks", "bad.csv"),
        "large.csv must have at most 1 MB": (*floor, "--marks", "large.csv"),
        "coded.csv is not UTF-8 text": (*floor, "--marks", "coded.csv"),
        "--out": ("sheet", "--out", "sheet.png"),
        "nowhere": ("lens", "x.png", "--out", "nowhere/a.toml"),
        "charuco": (*sheet, "--kind", "charco"),
        "--mark": (*sheet, "--kind", "floor", "--board", "9x6"),
        "--kind floor": (*sheet, "--number", "2"),
        "--camera": ("lens",),
    }.items():
        assert named in refused(*arguments), arguments


@pytest.fixture
def floor_file():
    """A calibration of a lens and a floor, camera.toml."""
    lens_file()
    marks_file()
    calibrate("floor", "--marks", "marks.csv", "--calibration", "camera.toml", *AREA)


@pytest.mark.slow
@pytest.mark.usefixtures("floor_file")
def test_a_new_lens_says_that_the_floor_of_the_old_one_goes():
    for number, picture in enumerate(board_pictures(BOARD, VIEWS[:4])):
        save_image(f"{number}.png", picture)
    lens = ("lens", *(f"{number}.png" for number in range(4)))
    assert "the floor in" in calibrate(*lens).stderr
    assert "had a floor" not in calibrate(*lens).stderr


@pytest.mark.usefixtures("floor_file")
def test_a_calibration_of_other_frames_is_refused():
    Path("frames").mkdir()
    save_image("frames/0.png", np.full((480, 320, 3), 90, np.uint8))
    for words in (("track", "frames"), ("live", "--camera", "frames", "--fps", "5")):
        result = CliRunner().invoke(app, [*words, "--calibration", "camera.toml"])
        assert result.exit_code == 2
        assert "320 x 480" in result.stderr


@pytest.mark.usefixtures("floor_file")
def test_what_was_calibrated_is_told_in_mm():
    Path("frames").mkdir()
    save_image("frames/0.png", np.full((480, 640, 3), 90, np.uint8))
    track = ("track", "frames", "--calibration", "camera.toml", "--no-video", "--unit", "mm")
    result = CliRunner().invoke(app, [*track, "--scale", "3"])
    assert re.search("--scale.*--calibration", result.stderr)
    result = CliRunner().invoke(app, track)
    assert result.exit_code == 1, result.output  # there is no robot
    info = Trace.load("robsim-track/trace.npz").info
    assert (info.unit, info.mm_per_px, info.area) == ("mm", 2, (1000, 800))


@pytest.mark.slow
def test_a_board_is_taken_when_it_stands_still_somewhere_new():
    first, second = list(board_pictures(BOARD, farther=1.3))[:2]
    taker = BoardTaker(BOARD, (640, 480))
    grey = np.full((480, 640, 3), 150, np.uint8)
    shown = [first, first, first, second, second, grey, first, first]
    taken = [index for index, image in enumerate(shown) if taker.takes(image)]
    assert taken == [1, 4]
    assert "bottom right" in taker.empty_parts


@pytest.mark.slow
def test_from_pictures_to_a_floor(tmp_path):
    """Lens, tilt of 30 degrees, markers 80 px high: below 0.4 px over the whole floor."""
    (tmp_path / "board").mkdir()
    for number, image in enumerate(board_pictures(BOARD, VIEWS, farther=1.3)):
        save_image(tmp_path / f"board/{number}.png", image)
    save_image("floor.png", floor_picture(OBLIQUE))
    result = calibrate("lens", "board", "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["rms"] < 0.2
    places = [f"{n}:{x + 1000},{y + 800}" for n, (x, y, _) in LAID.items()]
    laid = [part for place in places for part in ("--place", place)]
    options = ("--calibration", "camera.toml", *AREA, "--marker-height", "160")
    result = calibrate("floor", "floor.png", *options, *laid)
    assert result.exit_code == 0, result.output
    grid = np.stack(np.meshgrid(np.linspace(-1000, 1000, 21), np.linspace(-800, 800, 17)), -1)
    points = np.column_stack([grid.reshape(-1, 2), np.full(grid[..., 0].size, 160.0)])
    pixels = OBLIQUE.pixels(points)
    seen = ((pixels >= 0) & (pixels < OBLIQUE.size)).all(axis=1)
    assert seen.mean() > 0.8
    found = load_calibration("camera.toml").plane_map.to_world(pixels[seen])
    errors = found - (points[seen, :2] + (1000, 800)) / 2
    assert np.sqrt((errors**2).sum(axis=1).mean()) < 0.4


def test_pictures_that_cannot_be_read_are_left_out(tmp_path):
    boards = list(board_pictures(BOARD, VIEWS, farther=1.3))
    for number, image in enumerate(boards):
        save_image(tmp_path / f"board{number}.png", image)
    (tmp_path / "board1.png").write_bytes(b"")
    save_image(tmp_path / "board3.png", boards[3][:100])
    words = ("lens", "--board", "9x6")
    told = rf"2 of {len(boards)}.*board1\.png.*board3\.png"
    with pytest.warns(UserWarning, match=told):
        result = calibrate(*words, *sorted(tmp_path.glob("board*.png")))
    assert result.exit_code == 0, result.output
    for sources in (["board1.png"], ["board1.png", "board1.png"]):
        assert "board1.png" in refused(*words, *sources)


@pytest.mark.slow
def test_pictures_are_taken_from_a_live_camera(monkeypatch, tmp_path):
    from robsim.cli import sources

    images = list(board_pictures(BOARD, farther=1.3))
    looks = []
    look = BoardTaker.look
    monkeypatch.setattr(BoardTaker, "look", lambda *args: looks.append(args) or look(*args))

    class Held(EndlessCamera):
        """Shows one picture after the other, each until it was looked at a few times."""

        def read(self):
            self.image = images[min(len(looks) // 4, len(images) - 1)]
            time.sleep(0.02)
            return super().read()

    monkeypatch.setattr(sources, "_source", lambda text: Held(images[0]))
    result = calibrate("lens", "--camera", "0", "--count", "5", "--keep", tmp_path / "kept")
    assert result.exit_code in (0, 1), result.output
    assert "5 of 5" in result.stderr
    assert len(list((tmp_path / "kept").glob("*.png"))) == 5
