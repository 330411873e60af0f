"""The panel that calibrates a floor, without a browser."""

import os
import threading
from itertools import islice

import numpy as np
import pytest

import robsim
from browsers import FakeBrowser, pixels_of_floor, settled, tiled_floor
from python_devices import PATIENT, EndlessCamera
from robsim.lab import Chessboard, Corners, FloorSheet
from robsim.vision import Calibration, Intrinsics, load_calibration, save_calibration, save_image
from waiting import wait_for

PLACES = np.array(
    [(300, 300), (2100, 300), (2100, 2100), (300, 2100), (1200, 1200), (600, 1500), (1500, 600)],
    float,
)
PIXELS = pixels_of_floor(PLACES)
MATRIX = [(700, 0, 399.5), (0, 700, 299.5), (0, 0, 1)]
LENS = Calibration(size=(800, 600), intrinsics=Intrinsics(MATRIX))


@pytest.fixture
def tool(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with robsim.gui.floor_panel() as tool:
        yield tool


@pytest.fixture
def browser(tool):
    browser = FakeBrowser(tool._view, 200)
    browser.take("frame")
    return browser


def fitted(tool):
    """The state once all is computed."""
    view = tool._view
    wait_for(lambda: not view.ask(view._state)["pending"])
    return view.ask(view._state)


@pytest.mark.long
def test_points_are_added_placed_and_fitted(tool, browser):
    assert fitted(tool)["grid"] is None
    for number, (pixel, (x, y)) in enumerate(zip(PIXELS, PLACES, strict=True), start=1):
        browser.say("add", at=(np.rint(pixel) + 1).tolist(), reach=8)
        browser.say("place", point=number, x=x, y=y)
    settled(tool._view)
    told = fitted(tool)
    state, _ = browser.take("state", pending=False, points=told["points"])
    assert state == told
    assert state["problems"] == []
    assert state["fit"]["verdict"] == "good"
    assert state["fit"]["rms"] < 0.3
    for one in state["fit"]["points"]:
        off = np.linalg.norm(np.subtract(one["to"], one["at"]))
        assert one["px"] == pytest.approx(off, abs=1e-9)
    found = tool.value
    assert found.area == (1200, 1200)
    np.testing.assert_allclose(2 * found.plane_map.to_world(PIXELS), PLACES, atol=3)
    back = np.reshape(state["grid"]["map"], (3, 3))
    np.testing.assert_allclose(back, found.floor.matrix)


def test_a_wrong_point_is_named_at_once(tool, browser):
    tool.put(PIXELS, PLACES)
    tool.place(5, (1200, 1400))
    report = tool.report
    assert [one.name for one in report.points if not one.is_used] == ["5"]
    state = tool._view._state()
    assert "point 5 is" in state["problems"][0]
    assert [one["used"] for one in state["fit"]["points"]].count(False) == 1
    tool.undo()
    assert tool.report.problems == ()


def test_what_is_wrong_with_the_points_is_said(tool):
    for places, said in (
        (PLACES[:3], "place a point more"),
        (np.c_[np.arange(5) * 300, np.arange(5) * 300], "line"),
        (PLACES[:, ::-1], "mirrored"),
        (np.vstack([PLACES[:4], PLACES[:1]]), "points 1 and 5 have the same place"),
    ):
        pixels = pixels_of_floor(places) if said == "line" else PIXELS[: len(places)]
        tool.put(pixels, places)
        assert said in " ".join(fitted(tool)["problems"])
        if "points" not in said:
            with pytest.raises(ValueError, match=said):
                tool.value  # noqa: B018


def test_a_glass_gets_the_pixels_as_they_are(tool, browser):
    image = tiled_floor()
    browser.say("magnify", at=[100.4, 50.6], half=5, glass=1)
    head, (pixels,) = browser.take("detail")
    assert head["glass"] == 1
    assert head["box"] == [95, 46, 11, 11]
    part = np.frombuffer(pixels, np.uint8).reshape(11, 11, 3)
    np.testing.assert_array_equal(part, image[46:57, 95:106])
    for at, box in (([-1, 599], [0, 594, 5, 6]), ([-900, 1e300], None)):
        browser.say("magnify", at=at, half=5, glass=0)
        head, (pixels,) = browser.take("detail")
        assert box is None or head["box"] == box
        assert len(pixels) == 3 * head["box"][2] * head["box"][3]


def test_corners_of_a_grid_are_added_where_the_picture_has_them(tool):
    tool.put(PIXELS, PLACES)
    assert tool.fill(600) > 10
    true = pixels_of_floor(tool._view.points.draft.places)
    off = np.linalg.norm(tool._view.points.draft.pixels - true, axis=1)
    assert np.sqrt((off**2).mean()) < 0.3
    tool.undo()
    assert len(tool._view.points.draft.points) == len(PLACES)
    with pytest.raises(ValueError, match="step must"):
        tool.fill(24)  # too many places
    tool.load(np.full((600, 800, 3), 120, np.uint8))
    with pytest.raises(ValueError, match="no other corner"):
        tool.fill(600)


@pytest.mark.long
def test_it_is_saved_and_loaded_with_the_lens_that_is_there(tool, tmp_path):
    lens = Calibration(size=(800, 600), intrinsics=Intrinsics(MATRIX, [-0.05, 0, 0, 0, 0]))
    save_calibration(tmp_path / "lens.toml", lens)
    tool.put(PIXELS, PLACES)
    with pytest.raises(ValueError, match="has a lens"):
        tool.save(tmp_path / "lens.toml")
    with robsim.gui.floor_panel(calibration="lens.toml") as other:
        assert other.value.floor is None
        other.adjust(area=(1000, 900), mm_per_px=2.5, marker_height=80)
        other.put(lens.intrinsics.distorted(PIXELS), PLACES)
        assert other.report.rms < 0.01
        assert other.save().name == "lens.toml"
        value = other.value
    saved = load_calibration(tmp_path / "lens.toml")
    assert saved.intrinsics is not None
    assert (saved.area, saved.mm_per_px, saved.marker_height) == ((1000, 900), 2.5, 80)
    np.testing.assert_allclose(saved.floor.matrix, value.floor.matrix)
    with robsim.gui.floor_panel(calibration=saved, file="other.toml") as again:
        assert again.value == saved
        assert again._view._state()["grid"]["high"] is not None
        again.adjust(mm_per_px=5)
        at = np.array((400.0, 300.0))
        np.testing.assert_allclose(
            5 * again.value.floor.to_world(at), 2.5 * saved.floor.to_world(at)
        )


def test_a_file_that_is_no_calibration_is_not_overwritten(tool, browser, tmp_path):
    tool.put(PIXELS, PLACES)
    for name, content in (("colors.toml", "format = 1\n"), ("notes.toml", "to do")):
        (tmp_path / name).write_text(content)
        browser.say("save", file=name)
        assert f"{name} is not a calibration" in browser.take("note", level="error")[0]["text"]
        assert (tmp_path / name).read_text() == content
    assert tool._view.file.name == "example.toml"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_a_pipe_is_neither_read_nor_written(tool, browser, tmp_path):
    tool.put(PIXELS, PLACES)
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "folder.toml").mkdir()
    for name in ("pipe.toml", "folder.toml"):
        for kind in ("load", "save"):
            browser.say(kind, file=name)
            assert f"{name} is not a file" in browser.take("note", level="error")[0]["text"]


@pytest.mark.long
def test_a_calibration_that_was_not_read_is_not_overwritten(tool, tmp_path):
    tool.put(PIXELS, PLACES)
    floor = tool.value
    save_calibration("camera.toml", floor)
    with robsim.gui.floor_panel(tiled_floor(), calibration=LENS) as other:
        with pytest.raises(ValueError, match=r"camera.toml already exists"):
            other.save()
        with pytest.raises(ValueError, match="already exists"):
            tool.save("camera.toml")
        assert load_calibration("camera.toml") == floor
        assert other.save("mine.toml") == other.save()  # which it wrote itself
    with robsim.gui.floor_panel(tiled_floor(), calibration="mine.toml") as third:
        assert third.save(tmp_path / "mine.toml").name == "mine.toml"
        with pytest.raises(ValueError, match="already exists"):
            third.save("camera.toml")
        third._view.load("camera.toml")
        assert third.save().name == "camera.toml"
    with robsim.gui.floor_panel(tiled_floor(), file="camera.toml") as fourth:
        assert fourth.save().name == "camera.toml"


def test_a_lens_can_be_saved_before_there_is_a_floor(tool, browser):
    def why(by=None):
        if by:
            browser.say("by", name=by)
            settled(tool._view)
        return fitted(tool)["cannot_save"]

    assert "place 4 points more" in why()
    assert "press Use this lens" in why("lens")
    tool._view.ask(lambda: tool._view.take(LENS))
    assert why() == ""
    browser.say("save", file="lens.toml")
    assert "lens.toml" in browser.take("note", level="info")[0]["text"]
    tool.add(PIXELS[0])
    with pytest.raises(ValueError, match="place 3 points more"):
        tool.save()
    tool.put(PIXELS, PLACES)
    assert why() == ""
    assert "Find sheets" in why("sheets")


def test_that_a_floor_is_dropped_from_a_file_is_said(tool):
    tool.put(PIXELS, PLACES)
    save_calibration("camera.toml", tool.value)
    with robsim.gui.floor_panel(tiled_floor(), file="camera.toml") as other:
        browser = FakeBrowser(other._view, 200)
        browser.take("frame")
        other._view.ask(lambda: other._view.take(LENS))  # as a lens that was calibrated
        other.save()
        assert "camera.toml had a floor" in browser.take("note", level="info")[0]["text"]
        other.save()
        browser.say("save", file="camera.toml")
        assert "written" in browser.take("note", level="info")[0]["text"]  # there is none any more


def test_what_is_wrong_is_said_in_place_and_changes_nothing(tool):
    before = tool._view.points.draft
    for kind, fields, said in (
        ("cut", {"point": 9}, "point 9"),
        ("choose", {"point": 9}, "point 9"),
        ("set", {"name": "width", "value": 3.5}, "area must"),
        ("set", {"name": "colour", "value": 3}, "setting"),
        ("set", {"name": "mark", "value": 1}, "mark must"),
        ("by", {"name": "hand"}, "by must"),
        ("fill", {"step": 300}, "4 points more"),
        ("sheet", {"number": 3, "x": 1, "y": 2}, "sheet 3"),
        ("load", {"file": "none.toml"}, "none.toml"),
        ("magnify", {"at": [1, 2], "half": -1, "glass": 0}, "half of"),
    ):
        browser = FakeBrowser(tool._view, 200)  # a line is not told of too many at once
        browser.say(kind, **fields)
        assert said in browser.take("note", level="error")[0]["text"]
    assert tool._view.points.draft is before


def test_a_live_picture_is_calibrated_while_it_goes_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with (
        robsim.Camera(EndlessCamera(np.array(tiled_floor())), **PATIENT) as camera,
        robsim.gui.floor_panel(camera) as tool,
    ):
        browser = FakeBrowser(tool._view, 200)
        browser.take("frame")
        tool.put(PIXELS, PLACES)
        assert fitted(tool)["state"] == "running"
        browser.take("frame")
        tool.freeze()
        assert tool._view._state()["state"] == "paused"
        assert tool.report.rms < 0.01


def test_a_calibration_of_another_size_is_said_and_can_be_forgotten(tool, browser):
    save_calibration("small.toml", Calibration(size=(640, 480), intrinsics=LENS.intrinsics))
    tool.put(PIXELS, PLACES)
    browser.say("load", file="small.toml")
    settled(tool._view)
    with pytest.raises(ValueError, match="640 x 480"):
        tool.report  # noqa: B018
    browser.say("forget")
    settled(tool._view)
    assert tool.report.rms < 0.01
    browser.say("save", file="mine.toml")
    assert "mine.toml" in browser.take("note", level="info")[0]["text"]


@pytest.mark.long
def test_sheets_in_a_picture(tmp_path, monkeypatch):
    pytest.importorskip("cv2")
    from photographed_sheets import OBLIQUE, floor_picture

    monkeypatch.chdir(tmp_path)
    lens = Calibration(size=OBLIQUE.size, intrinsics=Intrinsics(OBLIQUE.matrix, OBLIQUE.distortion))
    with robsim.gui.floor_panel(floor_picture(OBLIQUE), calibration=lens) as tool:
        browser = FakeBrowser(tool._view, 200)
        browser.take("frame")
        browser.say("sheets")
        wait_for(lambda: tool._view.way == "sheets")
        state = fitted(tool)
        assert [one["number"] for one in state["sheets"]["found"]] == [1, 2, 3, 4, 5]
        assert state["fit"]["verdict"] == "good"
        assert state["fit"]["rms"] < 0.3
        browser.say("sheet", number=1, x=500, y=400)
        settled(tool._view)
        to_world = tool.value.floor.to_world
        before = 2 * to_world(OBLIQUE.pixels([(0, 0, 0)]))
        np.testing.assert_allclose(before, [(500, 400)], atol=2)
        browser.say("set", name="mark", value=88)  # all is larger by a tenth
        settled(tool._view)
        ahead = OBLIQUE.pixels([(100, 0, 0)])
        far = 2 * tool.value.floor.to_world(ahead) - (500, 400)
        assert np.linalg.norm(far) == pytest.approx(110, abs=2)
        assert set(tool.value.marks) >= {0, 5, 29}
        assert tool.find_sheets(mark=80, places={1: (0, 0)}).rms < 0.3


def test_a_mark_that_is_measured_while_sheets_are_found_counts_for_them(tool, browser, monkeypatch):
    begun, goes_on = threading.Event(), threading.Event()

    def corners(mark):
        return np.concatenate([*FloorSheet(1, mark).corners().values()])

    def find(image, mark):
        begun.set()
        assert goes_on.wait(300)
        return {1: Corners(corners(mark), corners(mark) + 200)}

    monkeypatch.setattr("robsim.lab.calibration.seen_sheets.find_sheets", find)
    browser.say("sheets")
    assert begun.wait(300)
    browser.say("set", name="mark", value=100)
    browser.take("state", sheets={"mark": 100, "found": []})
    goes_on.set()
    wait_for(lambda: tool._view.sheets.task().corners)
    np.testing.assert_allclose(tool._view.sheets.task().corners[1].positions, corners(100))


@pytest.fixture(scope="module")
def boards():
    """Pictures of a board, through a lens that distorts."""
    pytest.importorskip("cv2")
    from photographed_sheets import board_pictures

    return list(islice(board_pictures(Chessboard(9, 6)), 5))


@pytest.mark.long
def test_a_lens_is_calibrated_by_pictures_of_a_board(boards, tmp_path, monkeypatch):
    from photographed_sheets import Shot

    monkeypatch.chdir(tmp_path)
    (tmp_path / "film").mkdir()
    plain = np.full_like(boards[0], 150)
    for number, image in enumerate([*boards, plain]):
        save_image(tmp_path / "film" / f"{number}.png", image)
    with robsim.gui.floor_panel("film") as tool:
        browser = FakeBrowser(tool._view, 200)
        assert "take 4 pictures more" in browser.take("board")[0]["problems"][0]
        lens = tool._view.lens
        browser.say("use_lens")
        assert "take 4 pictures more" in browser.take("note", level="error")[0]["text"]
        browser.say("take_all")
        assert "no board in frame 5" in browser.take("note", level="error")[0]["text"]
        wait_for(lambda: lens.report is not None and len(lens.report.pictures) == len(boards))
        assert lens.report.rms < 0.3
        browser.say("use_lens")
        settled(tool._view)
        found = tool.value
        assert found.intrinsics.matrix[0][0] == pytest.approx(Shot().focal, rel=0.02)
        browser.say("drop", picture=None)
        browser.say("board", pattern="charuco", columns=8, rows=5, square=30)
        assert browser.take("board", pattern="charuco")[0]["pictures"] == []
        browser.say("board", pattern="charuco", columns=1, rows=5, square=30)
        assert "columns must" in browser.take("note", level="error")[0]["text"]
        browser.say("watch", on=True)
        assert "not live" in browser.take("note", level="error")[0]["text"]


@pytest.mark.long
def test_a_lens_by_methods(boards, tmp_path):
    for number, image in enumerate([*boards[:4], np.full_like(boards[0], 150)]):
        save_image(tmp_path / f"{number}.png", image)
    with robsim.gui.floor_panel(tmp_path, file=tmp_path / "camera.toml") as tool:
        with pytest.raises(ValueError, match="4 pictures more"):
            tool.calibrate_lens()
        for k in range(4):
            tool.look(k)
            assert tool.take_board(Chessboard(9, 6)) == 54
        assert tool.calibrate_lens().rms < 0.3
        assert tool.value.intrinsics is not None
        tool.look(4)
        with pytest.raises(ValueError, match="no board in frame 4"):
            tool.take_board()


@pytest.mark.long
def test_live_pictures_of_a_board_are_taken_by_themselves(boards, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with (
        robsim.Camera(EndlessCamera(boards[0]), **PATIENT) as camera,
        robsim.gui.floor_panel(camera) as tool,
    ):
        browser = FakeBrowser(tool._view, 200)
        browser.say("watch", on=True)
        wait_for(lambda: len(tool._view.lens.taken) == 1)  # it stands still
        told, _ = browser.take("board", watches=True)
        while not told["pictures"]:
            told, _ = browser.take("board")
        browser.say("take")
        wait_for(lambda: len(tool._view.lens.taken) == 2)


class Boards:
    """Pictures of which each has a board, somewhere else; none is looked for in them."""

    def __init__(self, monkeypatch):
        self.count = 0
        self.begun, self.goes_on = threading.Event(), threading.Event()
        self.goes_on.set()

        def find(board, image):
            self.begun.set()
            assert self.goes_on.wait(300)
            self.count += 1
            grid = np.mgrid[:6, :9].reshape(2, -1).T[:, ::-1].astype(float)
            pixels = 20 * grid + 10 + 5 * self.count
            return Corners(board.square * grid, pixels)

        monkeypatch.setattr(Chessboard, "find", find)
        monkeypatch.setattr("robsim.lab.calibration.taking.FEWEST", 1000)  # no lens


@pytest.fixture
def fakes(monkeypatch):
    return Boards(monkeypatch)


def test_a_picture_of_another_size_is_refused_and_those_taken_stay(tool, browser, fakes):
    assert tool.take_board() == 54
    lens = tool._view.lens
    small = np.zeros((480, 640, 3), np.uint8)
    tool.load(small)
    browser.say("take")
    said = "has 640 x 480 px, but the pictures of the board have 800 x 600 px"
    assert said in browser.take("note", level="error")[0]["text"]
    tool.go_back()
    assert tool.take_board() == 54
    assert len(lens.taken) == 2
    tool.drop_boards(0)
    assert (len(lens.taken), lens.taken.size) == (1, (800, 600))
    with pytest.raises(ValueError, match="unknown picture 1"):
        tool.drop_boards(1)
    tool.drop_boards()
    tool.load(small)
    assert tool.take_board() == 54
    assert lens.taken.size == (640, 480)


def test_of_a_picture_that_was_loaded_no_board_is_taken_by_itself(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    camera = EndlessCamera(np.zeros((60, 80, 3), np.uint8))
    with robsim.Camera(camera, **PATIENT) as device, robsim.gui.floor_panel(device) as tool:
        lens, looked = tool._view.lens, []
        tool.load(np.zeros((48, 64, 3), np.uint8))
        monkeypatch.setattr(lens, "_look_at", lambda picture, **_: looked.append(picture))
        tool._view.ask(lambda: setattr(lens, "watches", True))
        tool.load(np.ones((48, 64, 3), np.uint8))
        settled(tool._view)
        assert looked == []
        tool.go_back()
        wait_for(lambda: looked)


def test_with_another_side_of_a_square_the_pictures_stay(tool, browser, fakes):
    lens = tool._view.lens
    tool.take_board(Chessboard(9, 6, 25))
    fakes.begun.clear()
    fakes.goes_on.clear()
    browser.say("take")
    assert fakes.begun.wait(300)
    browser.say("board", pattern="chessboard", columns=9, rows=6, square=26.5)
    told, _ = browser.take("board", square=26.5)
    assert len(told["pictures"]) == 1
    fakes.goes_on.set()
    wait_for(lambda: len(lens.taken) == 2)
    for one in lens.taken.corners.values():
        np.testing.assert_allclose(one.positions.max(axis=0), (8 * 26.5, 5 * 26.5))
    browser.say("board", pattern="chessboard", columns=8, rows=6, square=25)
    assert "remove the 2 pictures first" in browser.take("note", level="error")[0]["text"]
    assert lens.board == Chessboard(9, 6, 26.5)
    tool.drop_boards(1)
    with pytest.raises(ValueError, match="remove the picture first"):
        tool.take_board(Chessboard(8, 6))


@pytest.mark.long
def test_more_pictures_than_enough_are_refused(tool, browser, fakes):
    lens = tool._view.lens
    for _ in range(60):
        tool.take_board()
    for message, fields in (("take", {}), ("watch", {"on": True})):
        browser.say(message, **fields)
        assert "there are already 60 pictures" in browser.take("note", level="error")[0]["text"]
    with pytest.raises(ValueError, match="already 60 pictures"):
        tool.take_board()
    assert len(lens.taken) == 60
    assert not lens.watches


@pytest.mark.long
@pytest.mark.parametrize("count", [41, 81])
def test_pictures_of_a_whole_film_are_taken(tool, fakes, monkeypatch, count):
    lens, looked = tool._view.lens, []
    source = tool._view.source
    picture = source.at(0)
    monkeypatch.setattr(source, "count", count, raising=False)
    monkeypatch.setattr(source, "at", lambda k: looked.append(k) or picture)
    tool._view.ask(lens.take_all)
    tool.load(np.zeros((48, 64, 3), np.uint8))  # the film goes on
    wait_for(lambda: not tool._view.ask(lambda: lens.is_busy))
    assert len(lens.taken) == len(looked) <= 40
    assert looked[-1] >= count - 3
