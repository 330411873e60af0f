"""The benchmark of a live camera's frames runs and says what it found."""

import json

import numpy as np
import pytest

import benches
import gige_cameras
from bench_camera import run as camera
from bench_camera import serving
from needs import needs_double
from robsim import _core
from sent_pixels import from_rgb

cv2 = pytest.importorskip("cv2")

SIZE = (320, 240)


@pytest.mark.long
def test_the_program_prints_numbers_for_scripts(monkeypatch, capsys):
    few = {"rounds": 1, "sizes": (SIZE,)}
    monkeypatch.setattr(camera.run_camera_bench, "__kwdefaults__", few)
    monkeypatch.setattr(serving, "WAYS", ())
    benches.main(["camera", "--rounds", "1", "--json"])
    paths = json.loads(capsys.readouterr().out)["paths"]
    assert list(paths) == [f"{format_}_320x240" for format_ in camera.FORMATS]
    for name, path in paths.items():
        assert path["to_rgb_ratio"] == pytest.approx(path["to_rgb_opencv"] / path["to_rgb"])
        if "mono8" in name:
            assert path["to_pose"] is path["to_pose_opencv"] is path["core"] is None
        else:
            assert path["core"] == pytest.approx(30 * path["to_pose"] / 1000)


@pytest.mark.slow
def test_live_cameras_are_read_by_a_process_of_its_own(monkeypatch):
    needs_double("firewire")
    monkeypatch.setattr(serving, "WAYS", serving.WAYS[::2])
    monkeypatch.setattr(serving, "PATIENCE", 300)
    with gige_cameras.alone():
        read = serving.read_live_cameras(seconds=0.3, size=SIZE)
    assert read.left_out == []
    assert [(row["transport"], row["coding"]) for row in read.rows] == list(serving.WAYS)
    for row in read.rows:
        assert row["lost"] >= 0
        assert row["latency"] <= row["latency_p95"]


@pytest.mark.parametrize(
    ("format_", "most"), [("yuv411", 2), ("mono8", 0), ("rgb8", 0), ("bayer_rggb", 1)]
)
def test_opencv_makes_the_same_image(rng, format_, most):
    raw = rng.integers(0, 256, 16 * 8, dtype=np.uint8)
    if format_ != "bayer_rggb":
        image = rng.integers(0, 256, (8, 16, 3), dtype=np.uint8)
        raw = np.frombuffer(from_rgb(image, format_), np.uint8)
    theirs = np.empty((8, 16, 3), np.uint8)
    camera.opencv_conversion(cv2, format_, theirs)(raw)
    ours = _core.to_rgb(raw, 16, 8, format_)
    assert np.abs(ours.astype(int) - theirs)[1:-1, 1:-1].max() <= most
