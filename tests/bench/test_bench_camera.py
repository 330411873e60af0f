"""The benchmark of a live camera's frames runs and says what it found."""

import json
import re

import numpy as np
import pytest

import gige_cameras
from commands import command
from needs import needs_extension
from robsim import _core
from robsim.bench import Case
from robsim.bench import _camera as camera
from robsim.bench._camera_result import CameraBench, Live, Path
from robsim.capture import CameraBusyError
from robsim.live._bench import serving
from sizes import thorough

cv2 = pytest.importorskip("cv2")

SIZE = (320, 240)


@pytest.fixture
def _small(monkeypatch):
    monkeypatch.setattr(camera, "SIZES", (SIZE,))
    monkeypatch.setattr(camera.run_camera_bench, "__kwdefaults__", {"rounds": 1, "sizes": (SIZE,)})
    monkeypatch.setattr(serving, "WAYS", ())


@pytest.mark.long
@pytest.mark.usefixtures("_small")
def test_the_command_prints_numbers_for_scripts(tmp_path):
    run = command("bench", "--camera", "--rounds", "1", "--json", cwd=tmp_path)
    assert run.exit_code == 0, run.stderr
    paths = json.loads(run.stdout)["paths"]
    assert list(paths) == [f"{format_}_320x240" for format_ in camera.FORMATS]
    for name, path in paths.items():
        assert path["to_rgb_ratio"] == pytest.approx(path["to_rgb_opencv"] / path["to_rgb"])
        if "mono8" in name:
            assert path["to_pose"] is path["to_pose_opencv"] is path["core"] is None
        else:
            assert path["core"] == pytest.approx(30 * path["to_pose"] / 1000)


def test_the_table():
    to_rgb = Case(name="", ours=0.25, others={"opencv": 12.5})
    to_pose = Case(name="", ours=1.5, others={"opencv": 123.4})
    paths = (
        Path(format="bayer_rggb", size=(1280, 960), to_rgb=to_rgb, to_pose=to_pose),
        Path(format="mono8", size=(640, 480), to_rgb=to_rgb),
    )
    text = str(CameraBench(cpu_path="avx2", paths=paths))
    assert re.search(r"bayer_rggb_1280x960 \(ms\) +0.25 +12.5 +50.0 +1.5 +123 +82.3 +4.5 %", text)
    assert re.search(r"mono8_640x480 \(ms\) +0.25 +12.5 +50.0$", text, re.MULTILINE)


def test_the_table_of_live_cameras():
    numbers = {"rate": 29.97, "lost": 2, "latency": 1.234, "latency_p95": 2.5, "core": 0.0716}
    live = (Live(transport="gige", coding="raw8", size=(1280, 960), **numbers),)
    case = Case(name="", ours=0.25, others={"opencv": 12.5})
    bench = CameraBench(
        cpu_path="avx2",
        paths=(Path(format="mono8", size=(640, 480), to_rgb=case),),
        live=live,
        left_out=("gige rgb8 is left out",),
    )
    text = str(bench)
    assert re.search(r"gige_raw8_1280x960 +30\.0 +2 +1\.23 +2\.5 +7\.2 %$", text, re.MULTILINE)
    assert "gige rgb8 is left out" in text
    assert bench.to_dict()["live"]["gige_raw8_1280x960"] == pytest.approx(numbers)


@pytest.mark.slow
def test_live_cameras_are_read_by_a_process_of_its_own(monkeypatch):
    needs_extension("firewire")
    ways = thorough(serving.WAYS, serving.WAYS[::2])
    monkeypatch.setattr(serving, "WAYS", ways)
    monkeypatch.setattr(serving, "PATIENCE", 300)
    with gige_cameras.alone():
        read = serving.read_live_cameras(seconds=0.3, size=SIZE)
    assert read.left_out == []
    assert [(row["transport"], row["coding"]) for row in read.rows] == list(ways)
    for row in read.rows:
        Live(**row)
        assert row["lost"] >= 0
        assert row["latency"] <= row["latency_p95"]


def test_a_live_camera_that_cannot_be_served_is_left_out(monkeypatch):
    def taken(lab):
        raise CameraBusyError("port 3956 is taken")

    monkeypatch.setattr(serving, "WAYS", (("gige", "raw8"),))
    monkeypatch.setattr(serving, "GigeServer", taken)
    read = serving.read_live_cameras(seconds=1.0, size=(320, 240))
    assert read.rows == []
    assert read.left_out == ["gige raw8 is left out: port 3956 is taken"]


@pytest.mark.parametrize(("format_", "most"), [("yuv411", 2), ("mono8", 0), ("rgb8", 0)])
def test_opencv_makes_the_same_image(rng, format_, most):
    image = rng.integers(0, 256, (8, 16, 3), dtype=np.uint8)
    raw = np.frombuffer(_core.from_rgb(image, format_), np.uint8)
    theirs = np.empty_like(image)
    camera.opencv_conversion(cv2, format_, theirs)(raw)
    ours = _core.to_rgb(raw, 16, 8, format_)
    assert np.abs(ours.astype(int) - theirs).max() <= most


def test_opencv_debayers_alike_but_for_the_edges(rng):
    raw = rng.integers(0, 256, 16 * 8, dtype=np.uint8)
    theirs = np.empty((8, 16, 3), np.uint8)
    camera.opencv_conversion(cv2, "bayer_rggb", theirs)(raw)
    ours = _core.to_rgb(raw, 16, 8, "bayer_rggb")
    assert np.abs(ours.astype(int) - theirs)[1:-1, 1:-1].max() <= 1


def test_opencv_reads_yuv422_as_that_of_television():
    raw = np.tile(np.array([128, 16, 128, 235], np.uint8), 8)
    theirs = np.empty((1, 16, 3), np.uint8)
    camera.opencv_conversion(cv2, "yuv422", theirs)(raw)
    assert theirs[0, :2, 0].tolist() == [0, 255]
    assert _core.to_rgb(raw, 16, 1, "yuv422")[0, :2, 0].tolist() == [16, 235]


def test_blobs_that_differ_are_no_comparison(monkeypatch):
    monkeypatch.setattr(camera, "find_blobs", lambda *_, **__: {"red": [], "blue": []})
    with pytest.raises(RuntimeError, match="same red"):
        camera.run_camera_bench(rounds=1, sizes=(SIZE,))


def test_frames_of_a_camera_come_from_one_buffer_after_the_other():
    frames = [np.array([i], np.uint8) for i in range(3)]
    buffers = camera._Buffers(frames)
    assert {int(buffers.next()[0]) for _ in range(3)} == {0, 1, 2}
