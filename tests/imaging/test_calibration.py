"""The value `Calibration`, its file, and who takes it."""

import datetime
import math
import re

import numpy as np
import pytest

import robsim
from python_devices import PATIENT
from refusals import refuses
from robsim.vision import (
    Calibration,
    Intrinsics,
    PlaneMap,
    Residuals,
    load_calibration,
    save_calibration,
    save_image,
)

MATRIX = [[560.3, 0, 321.25], [0, 561.1, 242.5], [0, 0, 1]]
# What is 1500 mm below a camera that looks 30 degrees aside; a work-area px has 2 mm.
TILT = math.radians(30)
LENS = Intrinsics(MATRIX, (-0.16, 0.05, 1e-3, -6e-4, 0.0))


def floor_map():
    turn = np.array(
        [(1, 0, 0), (0, math.cos(TILT), math.sin(TILT)), (0, -math.sin(TILT), math.cos(TILT))]
    )
    to_pixel = np.array(MATRIX) @ np.column_stack([turn[:, :2], turn @ (-300, -200, 750)])
    return PlaneMap(np.linalg.inv(to_pixel))


def calibration(**options):
    given = {
        "size": (640, 480),
        "region": (320, 240, 640, 480),
        "intrinsics": LENS,
        "floor": floor_map(),
        "area": (600, 400),
        "mm_per_px": 2.0,
        "marker_height": 160.0,
        "lens_residuals": Residuals(rms=0.1 + 0.2, worst=1.2, points=600, pictures=12),
        "floor_residuals": Residuals(rms=1 / 3, worst=2.1, points=8),
        "date": datetime.datetime(2026, 3, 4, 5, 6, 7, tzinfo=datetime.UTC),
        "features": {"exposure": 0.0125, "white balance": "manual", "gain": 3, "auto": False},
        "marks": {0: (12.5, 1 / 3), 7: (620.0, -0.25)},
    }
    return Calibration(**given | options)


def test_what_is_written_is_read_again_exactly(tmp_path):
    file = tmp_path / "camera.toml"
    for one in (
        calibration(),
        calibration(region=None, features={}, date=None, lens_residuals=None),
        Calibration(size=(640, 480), intrinsics=LENS),
        Calibration(size=(64, 48), floor=PlaneMap(), area=(64, 48)),
    ):
        save_calibration(file, one)
        assert load_calibration(file) == one
    assert load_calibration(file) != calibration()


def test_its_map_is_that_of_the_markers_height():
    one = calibration()
    assert one.marker_height_px == 80
    above = one.plane_map
    assert above == PlaneMap(floor_map().matrix, intrinsics=LENS).at_height(80)
    # Straight below the camera height changes nothing; elsewhere it does.
    positions = np.array([(300.0, 200.0), (0.0, 0.0)])
    apart = np.linalg.norm(above.to_pixel(positions) - one.floor.to_pixel(positions), axis=1)
    assert apart[0] < 1
    assert apart[1] > 10
    assert calibration(marker_height=0).plane_map == one.floor


def test_what_is_wrong_is_refused_by_its_name():
    wrong = {
        "size": [(640, 480.5), (0, 480)],
        "region": [(0, 0, 640), (-1, 0, 640, 480)],
        "mm_per_px": [0],
        "marker_height": [-1, 1501],
        "date": [datetime.datetime(2026, 1, 1)],  # without a zone
        "features": [{"exposure": math.inf}, {"exposure": [1]}],
        "marks": [{0: (1, 2, 3)}, {0: (1, math.nan)}, {-1: (1, 2)}, {1001: (1, 2)}],
    }
    for name, values in wrong.items():
        for value in values:
            refuses(name, calibration, **{name: value})
    assert calibration(marker_height=1499).marker_height == 1499
    assert calibration(marks={1000: (1, 2)}).marks == {1000: (1, 2)}
    refuses("marker_height", calibration, mm_per_px=None)
    refuses("marker_height", calibration, intrinsics=None)
    refuses("floor", calibration, area=None)


def test_frames_of_another_size_or_region_are_refused():
    one = calibration()
    one.check_frames((640, 480))
    one.check_frames((640, 480), (320, 240, 640, 480))
    with pytest.raises(ValueError, match=r"1280 x 960.*640 x 480"):
        one.check_frames((1280, 960))
    for use in (Calibration.check_floor, lambda lens: lens.plane_map):
        with pytest.raises(ValueError, match="floor"):
            use(Calibration(size=(640, 480), intrinsics=LENS))
    with pytest.raises(ValueError, match=r"region \(0, 0, 640, 480\).*\(320, 240, 640, 480\)"):
        one.check_frames((640, 480), (0, 0, 640, 480))


DAMAGES = [
    *(("format = 1", new, "format") for new in ("format = 2", "", "format = true")),
    ("[frames]", "[frame]", "frame"),
    ("size = [640, 480]", "sise = [640, 480]", "sise"),
    ("[560.3, 0.0, 321.25]", "[nan, 0.0, 321.25]", "[lens] matrix"),
    ("distortion = [-0.16,", "distortion = [inf,", "[lens] distortion"),
    ("mm_per_px = 2.0", "mm_per_px = -2.0", "[floor] mm_per_px"),
    ("area = [600, 400]", "", "area"),
    ("rms = 0.30000000000000004", "rms = nan", "[lens] rms"),
    ("exposure = 0.0125", "exposure = {a = 1}", "features"),
    ("date = 2026-03-04T05:06:07Z", "date = 5", "date"),
    ("0 = [12.5,", "0 = [inf,", "marks[0]"),
    ("0 = [12.5,", "9" * 4000 + " = [1,", "marks"),
    ("7 = [620.0,", "00 = [620.0,", "marks"),
]


def test_a_damaged_file_is_refused_with_its_key(tmp_path):
    file = tmp_path / "camera.toml"
    save_calibration(file, calibration())
    text = file.read_text()
    for old, new, key in DAMAGES:
        assert old in text
        file.write_text(text.replace(old, new, 1))
        with pytest.raises(ValueError, match=re.escape(key)) as caught:
            load_calibration(file)
        assert str(file) in str(caught.value)


def frames_in(folder, size=(64, 48)):
    folder.mkdir()
    for number in range(2):
        save_image(folder / f"{number}.png", np.full((size[1], size[0], 3), 90, np.uint8))
    return folder


@pytest.fixture
def small():
    return Calibration(size=(64, 48), floor=PlaneMap.scaled((64, 48), (640, 480)), area=(640, 480))


def test_a_recording_and_a_camera_take_one(tmp_path, small):
    folder = frames_in(tmp_path / "frames")
    save_calibration(tmp_path / "camera.toml", small)
    recording = robsim.Recording(folder, calibration=tmp_path / "camera.toml")
    assert recording.calibration == small
    assert recording.area == (640, 480)
    assert all(frame.plane_map == small.plane_map for frame in recording)
    with robsim.Camera(folder, fps=100, calibration=small, **PATIENT) as camera:
        assert camera.area == (640, 480)
        assert camera.read(300).plane_map == camera.plane_map == small.plane_map


@pytest.mark.parametrize("source", [robsim.Recording, robsim.Camera])
def test_frames_of_another_size_are_refused_by_who_takes_them(tmp_path, small, source):
    folder = frames_in(tmp_path / "frames", (48, 64))
    options = {"fps": 100} if source is robsim.Camera else {}
    with pytest.raises(ValueError, match=r"48 x 64 px.*64 x 48 px"):
        source(folder, calibration=small, **options)
    with pytest.raises(ValueError, match="plane_map"):
        source(folder, calibration=small, plane_map=PlaneMap(), **options)
    with pytest.raises(ValueError, match="floor"):
        source(folder, calibration=Calibration(size=(48, 64)), **options)
