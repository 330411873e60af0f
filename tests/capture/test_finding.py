"""What `find_cameras` says of cameras that are there, forbidden or missing."""

import os
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
from commands import command
from robsim.lab import (
    CameraBusyError,
    CaptureError,
    NoBackEndError,
    NoCameraError,
    NoPermissionError,
    find_cameras,
)
from robsim.lab.cameras import finding as _finding
from surroundings import needs_extension

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
    monkeypatch.setattr(sys, "platform", "linux")
    return found


def _all(found):
    return [node for nodes in found.values() for node in nodes]


def test_cameras_are_found_in_the_order_of_their_numbers(nodes):
    nodes["/dev/video*"] = ["/dev/video10", "/dev/video3"]
    report = find_cameras()
    cameras = [line for line in report.found if line.startswith("camera ")]
    assert [line.rpartition(": ")[2] for line in cameras] == [
        "robsim.Camera(3)",
        "robsim.Camera(10)",
    ]
    assert report.verdict == "2 found"


def test_a_forbidden_one_is_named_with_the_remedy(nodes):
    report = find_cameras()
    assert report.verdict == "1 found"
    (sentence,) = (line for line in report.missing if "/dev/video2" in line)
    assert "usermod -aG video" in sentence


def test_no_camera_at_all(nodes):
    nodes["/dev/video*"] = []
    report = find_cameras()
    assert report.verdict == "none found"
    assert any("/dev/video*" in line for line in report.missing)
    assert report.to_dict()["remarks"] == [*report.found, *report.missing]


@pytest.mark.parametrize(
    ("module", "package", "sources"),
    [
        ("robsim._firewire", "apt-get install libdc1394", ["firewire://"]),
        ("robsim._gige", "libaravis-dev", ["gige://127.0.0.1"]),
        ("cv2", "pip install opencv-python-headless", [0, "rtsp://127.0.0.1/stream"]),
    ],
)
def test_without_a_library_it_is_said_what_to_install(monkeypatch, module, package, sources):
    monkeypatch.setitem(sys.modules, module, None)
    assert any(package in line for line in find_cameras().missing)
    for source in sources:
        with pytest.raises(NoBackEndError, match=package.split()[-1]):
            robsim.Camera(source)


def test_the_command_says_the_same():
    run = command("cameras")
    assert run.exit_code == 0
    report = find_cameras()
    for sentence in report.found:
        assert f"found: {sentence}" in run.stdout
    for sentence in report.missing:
        assert f"missing: {sentence}" in run.stdout


@pytest.mark.long
def test_what_is_wrong_with_a_camera_by_number_is_told(nodes):
    cv2 = pytest.importorskip("cv2")
    if not cv2.videoio_registry.hasBackend(cv2.CAP_V4L2):
        pytest.skip("this OpenCV has no V4L2")
    for number, options, error, words in (
        (7, {}, NoCameraError, "/dev/video7"),
        (2, {}, NoPermissionError, "/dev/video2"),
        (10, {}, CameraBusyError, "/dev/video10"),
        (0, {"back_end": "msmf"}, NoBackEndError, "msmf"),
    ):
        with pytest.raises(error, match=words):
            robsim.Camera(number, **options)


@pytest.mark.parametrize(
    ("source", "options", "words"),
    [
        (0, {"back_end": "ffmpeg"}, "back_end"),
        ("gige://127.0.0.1", {"back_end": "ffmpeg"}, "back_end"),
        ("http://", {}, "host"),
        ("http://127.0.0.1:99999/", {}, "Port out of range"),
        ("gige://127.0.0.1/path", {}, "gige://"),
        ("gige://127.0.0.1?packet_size=65536", {}, "packet_size"),
        ("gige://127.0.0.1?colour=red", {}, "colour"),
        ("drp://drop", {}, "a scheme of firewire, gige, http, .*got 'drp'"),
        (-1, {}, "source"),
    ],
)
def test_a_source_that_makes_no_sense(source, options, words):
    if str(source).startswith("gige"):
        needs_extension("gige")
    with pytest.raises(ValueError, match=words):
        robsim.Camera(source, **options)


def test_a_folder_has_no_rate_of_its_own(tmp_path):
    robsim.vision.save_image(tmp_path / "0.png", np.zeros((24, 32, 3), np.uint8))
    with pytest.raises(ValueError, match="fps"):
        robsim.Camera(tmp_path)


def test_what_is_almost_an_address_asks_whether_it_was_meant():
    for given, meant in {
        "firewire:0": "firewire://0",
        "GIGE": "gige://ADDRESS",
        "192.168.1.20": "gige://192.168.1.20",
        "http:/camera.local/video": "http://camera.local/video",
        "/dev/fw1": "firewire://",
    }.items():
        with pytest.raises(FileNotFoundError, match=f"'{meant}'"):
            robsim.Camera(given)
    with pytest.raises(FileNotFoundError) as failure:
        robsim.Camera("gige_run.mkv")
    assert "did you mean" not in str(failure.value)


def test_a_bus_that_cannot_be_listed_hides_no_other_camera(nodes, monkeypatch):
    def cameras():
        raise CaptureError("the bus was reset")

    bus = SimpleNamespace(nodes=lambda: (["/dev/fw0"], []), cameras=cameras)
    monkeypatch.setattr(_finding.firewire, "EXTENSION", SimpleNamespace(load=lambda: bus))
    report = find_cameras()
    assert report.verdict == "1 found"
    assert any(line.endswith("the bus was reset") for line in report.missing)


@pytest.mark.parametrize("has_camera", [False, True])
def test_no_kind_of_camera_is_found_and_missing_at_once(nodes, monkeypatch, has_camera):
    one = ("0123456789abcdef", "IIDC", "on USB")
    answer = {"address": "192.168.1.2", "vendor": "A", "model": "B", "serial": "C"}
    bus = SimpleNamespace(nodes=lambda: ([], []), cameras=lambda: [one] * has_camera)
    network = SimpleNamespace(find_cameras=lambda: [answer] * has_camera)
    for kind, extension in ((_finding.firewire, bus), (_finding.gige, network)):
        monkeypatch.setattr(
            kind, "EXTENSION", SimpleNamespace(load=lambda extension=extension: extension)
        )
    report = find_cameras(network=True)
    for kind in ("FireWire", "GigE"):
        said = [
            any(re.match(f"cameras? on {kind}", line) for line in lines)
            for lines in (report.found, report.missing)
        ]
        assert said == [has_camera, not has_camera]
