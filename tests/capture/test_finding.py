"""What `find_cameras` says of cameras that are there, forbidden or missing."""

import os
from types import SimpleNamespace

import pytest

import robsim
from commands import command
from robsim.capture import (
    CameraBusyError,
    CaptureError,
    NoBackEndError,
    NoCameraError,
    NoPermissionError,
    _finding,
    find_cameras,
)
from robsim.capture._devices import opencv

NODES = {"/dev/video*": ["/dev/video10", "/dev/video2", "/dev/videodriver"]}


@pytest.fixture
def nodes(monkeypatch):
    """Two cameras by number; the first must not be read."""
    found = dict(NODES)
    monkeypatch.setattr(_finding.glob, "glob", lambda pattern: list(found[pattern]))
    access, exists = os.access, os.path.exists
    monkeypatch.setattr(
        os,
        "access",
        lambda path, mode: path != "/dev/video2" and (path in _all(found) or access(path, mode)),
    )
    monkeypatch.setattr(os.path, "exists", lambda path: path in _all(found) or exists(path))
    monkeypatch.setattr(opencv.sys, "platform", "linux")
    return found


def _all(found):
    return [node for nodes in found.values() for node in nodes]


def test_cameras_are_found_in_the_order_of_their_numbers(nodes):
    nodes["/dev/video*"] = ["/dev/video10", "/dev/video3"]
    cameras = [line for line in find_cameras().found if line.startswith("camera ")]
    assert [line.rpartition(": ")[2] for line in cameras] == [
        "robsim.Camera(3)",
        "robsim.Camera(10)",
    ]
    assert find_cameras().verdict == "2 found"


def test_a_forbidden_one_is_named_with_the_remedy(nodes):
    report = find_cameras()
    assert report.verdict == "1 found"
    (sentence,) = (line for line in report.missing if "/dev/video2" in line)
    assert "usermod -aG video" in sentence


def test_no_camera_at_all(nodes):
    nodes["/dev/video*"] = []
    report = find_cameras()
    assert report.verdict == "none found"
    assert any("there is no /dev/video*; plug one in" in line for line in report.missing)
    assert report.to_dict()["remarks"] == [*report.found, *report.missing]


def test_without_libdc1394_a_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "robsim._firewire", None)
    assert any("apt-get install libdc1394" in line for line in find_cameras().missing)
    with pytest.raises(NoBackEndError, match="apt-get install libdc1394"):
        robsim.Camera("firewire://")


def test_without_opencv(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "cv2", None)
    assert any("pip install opencv-python-headless" in line for line in find_cameras().missing)
    for source in (0, "rtsp://127.0.0.1/stream"):
        with pytest.raises(NoBackEndError, match="pip install opencv-python-headless"):
            robsim.Camera(source)


def test_the_command_says_the_same():
    run = command("cameras")
    assert run.exit_code == 0
    report = find_cameras()
    for sentence in report.found:
        assert f"found: {sentence}" in run.stdout
    for sentence in report.missing:
        assert f"missing: {sentence}" in run.stdout


class TestByNumber:
    @pytest.fixture(autouse=True)
    def _opencv(self):
        cv2 = pytest.importorskip("cv2")
        if "v4l2" not in opencv.back_ends(cv2):
            pytest.skip("this OpenCV has no V4L2")

    def test_none(self, nodes):
        with pytest.raises(NoCameraError, match="there is no /dev/video7: is the camera plugged"):
            robsim.Camera(7)

    def test_forbidden(self, nodes):
        with pytest.raises(NoPermissionError, match="no permission to read /dev/video2"):
            robsim.Camera(2)

    @pytest.mark.long
    def test_one_that_does_not_open(self, nodes):
        with pytest.raises(CameraBusyError, match="fuser /dev/video10 names it"):
            robsim.Camera(10)

    def test_a_back_end_that_is_not_there(self):
        with pytest.raises(NoBackEndError, match="has no back end 'msmf', only"):
            robsim.Camera(0, back_end="msmf")


@pytest.mark.parametrize(
    ("source", "options", "words"),
    [
        (0, {"back_end": "ffmpeg"}, "back_end must be one of 'v4l2'"),
        ("rtsp://127.0.0.1/", {"back_end": "http"}, "back_end 'http' reads http:// alone"),
        ("run.mkv", {"back_end": "ffmpeg"}, "back_end must be None for a file"),
        ("http://", {}, "an address with a host"),
        ("http://127.0.0.1:99999/", {}, "source must be an address, got .*: Port out of range"),
        (-1, {}, "source must lie within 0..99"),
    ],
)
def test_a_source_that_makes_no_sense(source, options, words):
    with pytest.raises(ValueError, match=words):
        robsim.Camera(source, **options)


def test_a_source_of_another_kind():
    with pytest.raises(TypeError, match="source must be the number of a camera"):
        robsim.Camera(1.5)


def test_a_folder_has_no_rate_of_its_own(tmp_path):
    robsim.imaging.save_image(tmp_path / "0.png", __import__("numpy").zeros((24, 32, 3), "uint8"))
    with pytest.raises(ValueError, match="fps must be given to play the folder"):
        robsim.Camera(tmp_path)


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("firewire:0", "firewire://0"),
        ("fire wire", "firewire://"),
        ("FireWire://1", "firewire://1"),
        ("gige:192.168.1.20", "gige://192.168.1.20"),
        ("GIGE", "gige://ADDRESS"),
        ("192.168.1.20", "gige://192.168.1.20"),
        ("http:/camera.local/video", "http://camera.local/video"),
        ("/dev/fw1", "firewire://"),
    ],
)
def test_what_is_almost_an_address_asks_whether_it_was_meant(given, meant):
    with pytest.raises(FileNotFoundError, match=f"did you mean '{meant}'"):
        robsim.Camera(given)


def test_a_file_that_is_not_there_is_no_address():
    with pytest.raises(FileNotFoundError) as failure:
        robsim.Camera("gige_run.mkv")
    assert "did you mean" not in str(failure.value)


def test_a_bus_that_cannot_be_listed_hides_no_other_camera(nodes, monkeypatch):
    def cameras():
        raise CaptureError("could not list the cameras: the bus was reset")

    bus = SimpleNamespace(nodes=lambda: (["/dev/fw0"], []), cameras=cameras)
    monkeypatch.setattr(_finding.firewire, "EXTENSION", SimpleNamespace(load=lambda: bus))
    report = find_cameras()
    assert report.verdict == "1 found"
    assert "cameras on FireWire: could not list the cameras: the bus was reset" in report.missing
