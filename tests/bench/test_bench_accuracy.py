"""The benchmark of the errors: what it counts, what the others measure, what the command says."""

import json
import sys

import numpy as np
import pytest

import benches
import robsim
from bench_accuracy import apriltag, result, run

cv2 = pytest.importorskip("cv2")

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
