"""The benchmarks with OpenCV: of the package, of accuracy, of a camera."""

import json
import sys

import numpy as np
import pytest

import benches
import gige_cameras
import robsim
from bench_accuracy import apriltag, result, run
from bench_camera import run as camera
from bench_camera import serving, streams
from commands import command
from robsim import _core
from robsim.cli.simulated import bench as bench_table
from sent_pixels import from_rgb
from surroundings import needs_double

cv2 = pytest.importorskip("cv2")

# --- the command `robsim bench`


#: What each case is compared with.
COMPARED = {
    "detect_clean_480": {"opencv"},
    "detect_gaussian_480": {"opencv"},
    "noise_gaussian_480": {"opencv", "numpy"},
    "render_480": {"opencv"},
    "step_gaussian_480": {"opencv"},
    "step_tracked": set(),
    "step_unseen": {"numpy"},
    "step_controller": set(),
}


@pytest.mark.long
@pytest.mark.usefixtures("small_bench")
def test_the_command_prints_numbers_for_scripts(tmp_path):
    run = command("bench", "--rounds", "1", "--json", cwd=tmp_path)
    assert run.exit_code == 0, run.stderr
    cases = json.loads(run.stdout)["cases"]
    assert [*cases] == [*COMPARED]
    for name, case in cases.items():
        assert {other for other in ("opencv", "numpy") if case[other] is not None} == COMPARED[name]
        for other in COMPARED[name]:
            assert case[f"{other}_ratio"] == pytest.approx(case[other] / case["ours"])


def test_medians_are_taken_in_turns():
    order = []
    calls = {"ours": lambda: order.append("a"), "numpy": lambda: order.append("b")}
    assert set(bench_table.timed(calls, 3)) == {"ours", "numpy"}
    assert "".join(order) == "ab" * 5  # two rounds to warm up


def test_both_find_the_same_blobs_in_strong_noise():
    noisy = bench_table.seen_robot(480, bench_table.NOISE)
    calls = bench_table.detect_calls(cv2, noisy)
    ours = max(calls["ours"]()["red"], key=lambda blob: blob.area)
    found = calls["opencv"]()["red"]
    area, *place = found[np.argmax(found[:, 0])]
    assert area == pytest.approx(ours.area, rel=0.2)
    np.testing.assert_allclose(place, ours.centroid, atol=1)


def test_other_blobs_are_refused():
    noisy = bench_table.seen_robot(480, bench_table.NOISE)
    ours = bench_table.detect_calls(cv2, noisy)["ours"]()
    none = {color: np.empty((0, 3)) for color in ours}
    with pytest.raises(RuntimeError, match="OpenCV must find the"):
        bench_table.check_same_blobs(ours, none)


@pytest.mark.long
def test_both_draw_the_same_moving_robot():
    calls = bench_table.render_calls(cv2, 480)
    ours, theirs = ([calls[n]().astype(int).copy() for _ in range(2)] for n in ("ours", "opencv"))
    for mine, other in zip(ours, theirs, strict=True):
        assert np.abs(mine - other).max() <= bench_table.MAXIMUM_DIFFERENCE
    assert np.abs(ours[0] - ours[1]).max() > 50


def test_both_go_the_same_way_without_frames():
    calls = bench_table.unseen_calls(60)
    calls["ours"]()
    assert calls["numpy"]().shape == (60, 3)


# --- accuracy


TRUTH = np.array([[100, 100, 0.1], [200, 200, 3.1], [300, 300, 0.0], [400, 400, -1.0]])


def test_errors_by_hand():
    poses = [
        np.array([103, 104, 0.1]),  # 5 px
        np.array([200, 201, 3.1 + 0.2 - 2 * np.pi]),  # 1 px, 0.2 rad
        np.array([300, 311, 0.0]),  # false: 11 px
        None,
    ]
    covariances = [np.eye(3), np.diag((1, 1, 0.01)), np.eye(3) * 1e-9, None]
    errors = result.errors_of(poses, TRUTH, covariances)
    assert (errors.misses, errors.false_poses, errors.lost) == (1, 1, 2)
    assert errors.xy == pytest.approx(np.sqrt((25 + 1) / 2))
    assert errors.heading_deg == pytest.approx(np.rad2deg(0.2 / np.sqrt(2)))
    # 3^2 + 4^2 and 1 + 0.04/0.01; neither the false pose nor the missed one
    assert errors.nees == pytest.approx((25 + 5) / 6)
    turned = result.errors_of([TRUTH[0] + (0, 0, 0.36)], TRUTH[:1])  # 20.6 degrees
    assert (turned.false_poses, np.isnan(turned.xy)) == (1, True)


def test_the_tag_is_found_where_it_lies():
    tag = apriltag.AprilTag(cv2, 1060.0)
    pose = (301.6, 222.3, -2.9)
    sim = robsim.Simulation(robot=tag.definition(), headings=None, start=pose)
    sim.step()
    found = tag.pose(sim.frame, near=np.array(pose))
    assert np.hypot(*(found[:2] - pose[:2])) < 0.1
    assert abs(robsim.wrap_angle(found[2] - pose[2])) < np.deg2rad(0.4)
    assert tag.pose(sim.frame, near=np.array((900.0, 900.0, 0.0))) is None


@pytest.mark.long
def test_the_program_writes_the_figure_and_prints_right_numbers(tmp_path, monkeypatch, capsys):
    few = {"sizes": (480,), "noises": (None, robsim.GaussianNoise(10))}
    monkeypatch.setattr(run.run_accuracy_bench, "__kwdefaults__", few)
    figure = tmp_path / "accuracy.png"
    benches.main(["accuracy", "--frames", "4", "--figure", str(figure), "--json"])
    cases = json.loads(capsys.readouterr().out)["cases"]
    assert set(cases) == {"480_clean", "480_gaussian_10"}
    for case in cases.values():
        assert case["misses"] == case["false"] == 0
        assert 0 < case["bound_xy"] < 0.3
        assert 0 < case["rms_xy"] < case["counted"]["rms_xy"]
        for other in ("weighted", "opencv", "apriltag"):
            assert 0 < case[other]["rms_xy"] < 1
    assert cases["480_clean"]["weighted"]["rms_xy"] < 0.5 * cases["480_clean"]["counted"]["rms_xy"]
    assert 0.1 < cases["480_gaussian_10"]["nees"] < 3
    assert figure.stat().st_size > 10_000


@pytest.mark.long
def test_wrong_options_are_refused_before_anything_is_measured(tmp_path, capsys):
    folder = tmp_path / "folder.png"
    folder.mkdir()
    # 10 000 frames: what measured them first would take an hour
    many = ("accuracy", "--frames", "10000")
    for options, message in (
        (("accuracy", "--frames", "10001"), "frames"),
        ((*many, "--rounds", "3"), "--rounds"),
        (("grading", "--frames", "3"), "--frames"),
        ((*many, "--figure", str(folder)), "folder.png"),
        (("accuracy", "camera"), "camera"),
        (("camera", "--rounds", "0"), "rounds"),
    ):
        with pytest.raises(SystemExit) as ended:
            benches.main(options)
        assert ended.value.code == 2, options
        assert message in capsys.readouterr().err


def test_without_opencv_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(ImportError, match="pip install opencv"):
        run.run_accuracy_bench(frames=1)


# --- a camera


SIZE = (320, 240)


@pytest.mark.long
def test_the_program_prints_numbers_for_scripts(monkeypatch, capsys):
    few = {"rounds": 1, "sizes": (SIZE,)}
    monkeypatch.setattr(camera.run_camera_bench, "__kwdefaults__", few)
    monkeypatch.setattr(serving, "WAYS", ())
    monkeypatch.setattr(streams, "CODINGS", ())
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


def test_a_missing_server_of_rtsp_is_named_with_its_packages(monkeypatch, tmp_path, capsys):
    server = tmp_path / "server.py"
    server.write_text("import there_is_no_such_module")
    monkeypatch.setattr(streams, "_SERVER", server)
    monkeypatch.setattr(streams, "PYTHON", sys.executable)
    few = {"rounds": 1, "sizes": (SIZE,)}
    monkeypatch.setattr(camera.run_camera_bench, "__kwdefaults__", few)
    monkeypatch.setattr(serving, "WAYS", ())
    benches.main(["camera", "--rounds", "1"])
    said = capsys.readouterr().out
    assert all(word in said for word in ("there_is_no_such_module", "gst-rtsp-server"))


def test_a_picture_shows_its_time(rng):
    shown = int(rng.integers(2**32))
    cells = np.array([255 * (shown >> k & 1) for k in range(streams.CELLS)])
    picture = np.repeat(cells, 20)[None, :, None] + rng.integers(-60, 60, (48, 640, 3))
    assert streams.time_of(picture.clip(0, 255)) == shown


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
