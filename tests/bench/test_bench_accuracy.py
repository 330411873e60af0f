"""The benchmark of the errors: what it counts, what the others measure, its table and figure."""

import json
import re
import sys

import numpy as np
import pytest

import robsim
from commands import command
from robsim.bench._accuracy import run
from robsim.bench._accuracy.apriltag import AprilTag
from robsim.bench._accuracy.blobs import BlobMethods
from robsim.bench._accuracy.result import METHODS, AccuracyCase, AccuracyResult, Errors, errors_of
from robsim.imaging import Frame
from robsim.plotting._charts.accuracy import plot_accuracy
from robsim.vision import find_blobs

cv2 = pytest.importorskip("cv2")

TRUTH = np.array([[100, 100, 0.1], [200, 200, 3.1], [300, 300, 0.0], [400, 400, -1.0]])
KEYS = {"rms_xy", "rms_heading_deg", "misses", "false"}


def test_errors_by_hand():
    poses = [
        np.array([103, 104, 0.1]),  # 5 px
        np.array([200, 201, 3.1 + 0.2 - 2 * np.pi]),  # 1 px, 0.2 rad
        np.array([300, 311, 0.0]),  # false: 11 px
        None,
    ]
    errors = errors_of(poses, TRUTH)
    assert (errors.misses, errors.false_poses, errors.lost, errors.nees) == (1, 1, 2, None)
    assert errors.xy == pytest.approx(np.sqrt((25 + 1) / 2))
    assert errors.heading_deg == pytest.approx(np.rad2deg(0.2 / np.sqrt(2)))
    turned = errors_of([TRUTH[0] + (0, 0, 0.36)], TRUTH[:1])  # 20.6 degrees
    assert (turned.false_poses, np.isnan(turned.xy)) == (1, True)
    covariances = [np.eye(3), np.diag((1, 1, 0.01)), np.eye(3) * 1e-9, None]
    # 3^2 + 4^2 and 1 + 0.04/0.01; neither the false pose nor the missed one
    assert errors_of(poses, TRUTH, covariances).nees == pytest.approx((25 + 5) / 6)
    assert errors_of(poses, TRUTH, [None, np.diag((1, 1, 0.01)), None, None]).nees == (
        pytest.approx(5 / 3)
    )


@pytest.fixture(scope="module")
def result():
    noises = (None, robsim.GaussianNoise(10), robsim.UniformNoise(10))
    return run.run_accuracy_bench(frames=4, sizes=(480,), noises=noises)


@pytest.mark.long
def test_every_case_has_numbers(result):
    cases = result.to_dict()["cases"]
    assert list(cases) == ["480_clean", "480_gaussian_10", "480_uniform_10"]
    for case in cases.values():
        others = set(METHODS) - {"robsim"}
        assert set(case) == KEYS | {"bound_xy", "bound_heading_deg", "nees"} | others
        for name in others:
            assert set(case[name]) == KEYS
        assert case["misses"] == case["false"] == 0
        assert 0 < case["bound_xy"] < 0.3
        assert 0 < case["rms_xy"] < 1
        assert 0 < case["weighted"]["rms_xy"] < 0.6
    assert cases["480_clean"]["weighted"]["rms_xy"] < 0.5 * cases["480_clean"]["counted"]["rms_xy"]
    for case in cases.values():
        assert case["rms_xy"] < case["counted"]["rms_xy"]
    assert cases["480_uniform_10"]["bound_xy"] < cases["480_gaussian_10"]["bound_xy"]
    json.loads(result.to_json())


@pytest.mark.long
def test_the_same_frames_have_the_same_errors(result):
    again = run.run_accuracy_bench(frames=4, sizes=(480,), noises=(robsim.GaussianNoise(10),))
    assert again.cases[0].errors["counted"] == result.cases[1].errors["counted"]


@pytest.mark.long
def test_what_measurements_say_of_their_errors_is_judged(result):
    noisy = result.cases[1].errors
    assert 0.1 < noisy["robsim"].nees < 3
    assert noisy["weighted"].nees is None
    assert "NEES / 3" in str(result)


def made(nees=None):
    errors = {
        name: Errors(xy=0.1 * i, heading_deg=0.2 * i, misses=i, false_poses=1)
        for i, name in enumerate(METHODS, 1)
    }
    errors["robsim"] = Errors(xy=0.3, heading_deg=0.6, misses=0, false_poses=0, nees=nees)
    cases = [
        AccuracyCase(
            name=f"{size}_{kind}",
            size=size,
            kind=kind,
            percent=percent,
            bound_xy=0.2,
            bound_heading_deg=0.15,
            errors=errors,
        )
        for size in (1200, 480)
        for kind, percent in (("clean", 0.0), ("gaussian", 5.0), ("uniform", 5.0))
    ]
    return AccuracyResult(frames=20, cases=tuple(cases))


def test_the_table():
    text = str(made())
    place = r"1200_clean +0\.2000 +0\.300 +0\.200 +0\.300 +0\.400 +0\.500 +1\.50$"
    assert re.search(place, text, re.MULTILINE)
    assert re.search(r"480_gaussian +0 +3 +4 +5 +6$", text, re.MULTILINE)
    assert "NEES" not in text
    assert re.search(r"480_gaussian +0 +3 +4 +5 +6 +3\.10$", str(made(3.1)), re.MULTILINE)


def test_the_figure():
    figure = plot_accuracy(made())
    first, *others = figure.axes
    assert len(others) == 3
    lines = {line.get_label(): line for line in first.lines}
    np.testing.assert_allclose(lines["robsim"].get_ydata(), 0.3)
    np.testing.assert_allclose(lines["bound of the two markers"].get_ydata(), 0.2)
    assert [label.get_text() for label in others[1].get_xticklabels()] == ["clean", "5"]
    hollow = [line for line in first.lines if line.get_markerfacecolor() == "white"]
    assert sum(len(line.get_xdata()) for line in hollow) == 2 * 4  # all but robsim's
    assert "over 10 % missed or false" in [t.get_text() for t in figure.legends[0].texts]


def test_the_tag_is_found_where_it_lies():
    tag = AprilTag(cv2, 1060.0)
    for pose in ((500.2, 600.7, 0.4), (301.6, 222.3, -2.9), (800.9, 411.1, 1.2)):
        sim = robsim.Simulation(robot=tag.definition(), headings=None, start=pose)
        sim.step()
        found = tag.pose(sim.frame, near=np.array(pose))
        assert np.hypot(*(found[:2] - pose[:2])) < 0.1
        assert abs(robsim.wrap_angle(found[2] - pose[2])) < np.deg2rad(0.4)
        assert tag.pose(sim.frame, near=np.array((900.0, 900.0, 0.0))) is None


@pytest.fixture(scope="module")
def lab():
    """A frame of the lab robot at a pose, its blobs, and the ways to measure by them."""
    pose = (500.3, 600.6, 0.3)
    sim = robsim.Simulation(
        robot="lab", headings=None, resolution=(480, 480), start=pose, measure=True
    )
    sim.step()
    methods = BlobMethods(cv2, sim.colors, sim.markers, 3)
    blobs = find_blobs(sim.frame, sim.colors, markers=sim.markers)
    return sim.frame, np.array(pose), blobs, methods


def test_the_ways_by_blobs(lab):
    frame, pose, blobs, methods = lab
    found = {
        "counted": methods.counted(frame, blobs),
        "weighted": methods.weighted(frame, blobs),
        "opencv": methods.opencv(frame),
    }
    errors = {name: np.hypot(*(one - pose)[:2]) for name, one in found.items()}
    assert errors["weighted"] < 0.1
    assert max(errors.values()) < 0.6
    nothing = Frame(np.full((480, 480, 3), 90, np.uint8), plane_map=frame.plane_map)
    none = {"red": [], "blue": []}
    assert methods.counted(nothing, none) is methods.weighted(nothing, none) is None
    assert methods.opencv(nothing) is None


@pytest.mark.long
@pytest.mark.usefixtures("small_bench")
def test_the_command_writes_the_figure_and_prints_numbers(tmp_path):
    options = ("--accuracy", "--frames", "2", "--figure", "accuracy.png")
    done = command("bench", *options, "--json", cwd=tmp_path)
    assert done.exit_code == 0, done.stderr
    assert set(json.loads(done.stdout)["cases"]) == {"480_clean", "480_gaussian_10"}
    assert (tmp_path / "accuracy.png").stat().st_size > 10_000


@pytest.mark.long
def test_wrong_options_are_refused_before_anything_is_measured(tmp_path):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file").touch()
    # 10 000 frames: what measured them first would take an hour
    many = ("--accuracy", "--frames", "10000")
    for options, message in (
        (("--accuracy", "--frames", "0"), "--frames"),
        (("--accuracy", "--frames", "10001"), "--frames"),
        ((*many, "--rounds", "3"), "--rounds"),
        (("--panel", "--rounds", "3"), "--rounds"),
        (("--frames", "3"), "--frames"),
        (("--figure", "a.png"), "--figure"),
        ((*many, "--figure", "a.xyz"), "figure"),
        ((*many, "--figure", "folder.png"), "folder.png"),
        ((*many, "--figure", "file/sub/a.png"), "file"),
        (("--accuracy", "--camera"), "--camera and --accuracy"),
        (("--grading", "--camera"), "--camera and --grading"),
        (("--campaign", "--panel"), "--panel and --campaign"),
    ):
        done = command("bench", *options, cwd=tmp_path)
        assert done.exit_code != 0, options
        assert message in done.stderr
    assert sorted(file.name for file in tmp_path.iterdir()) == ["file", "folder.png"]


def test_without_opencv_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(ImportError, match="pip install opencv"):
        run.run_accuracy_bench(frames=1)
