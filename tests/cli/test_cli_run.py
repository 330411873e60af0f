"""The commands new, run and track, as a student types them."""

import json
import shutil
import sys

import numpy as np
import pytest

import robsim
from commands import cli, command
from disks import full_disk
from robsim.cli import main

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def first_run(tmp_path_factory):
    """Return a folder with untouched callbacks, and a first run of them in a process of its own."""
    desk = tmp_path_factory.mktemp("desk")
    assert command("new", "mine", cwd=desk).exit_code == 0
    run = cli("run", "mine", "--steps", "12", "--measure", "--seed", "1", cwd=desk)
    assert run.returncode == 0, run.stderr
    assert "Tracking" in run.stdout
    assert "12 (100 %)" in run.stdout
    assert "written to robsim-run: camera.jpg, traces.png, trace.npz" in run.stdout
    return desk, run


@pytest.fixture(scope="module")
def desk(first_run):
    return first_run[0]


@pytest.fixture
def mine(desk, tmp_path):
    shutil.copytree(desk / "mine", tmp_path / "mine")
    shutil.copytree(desk / "robsim-run", tmp_path / "robsim-run")
    return tmp_path / "mine"


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_an_untouched_folder_and_none_give_the_same_trace(desk):
    run = command(
        "run", "--steps", "12", "--measure", "--seed", "1", "--out", "plain", "--json", cwd=desk
    )
    assert json.loads(run.stdout)["tracking"]["seen"] == 12
    one, other = (
        robsim.Trace.load(desk / folder / "trace.npz") for folder in ("robsim-run", "plain")
    )
    assert one.names == other.names
    for name in one.names:
        np.testing.assert_array_equal(one[name], other[name])


def test_new_tells_what_comes_next(tmp_path):
    said = command("new", "my work", cwd=tmp_path).stdout
    assert "robsim gui 'my work'\n" in said
    assert "robsim run 'my work'\n" in said


def test_new_does_not_overwrite(desk):
    run = command("new", "mine", cwd=desk)
    assert run.exit_code == 2
    assert "mine has define_model.py" in run.stderr


def test_a_syntax_error_names_file_and_line_and_leaves_the_last_results_alone(mine):
    before = {file: file.read_bytes() for file in (mine.parent / "robsim-run").iterdir()}
    (mine / "control.py").write_text("def control(step):\n    return (0.1, 0.2\n")
    run = command("run", "mine", "--steps", "5", cwd=mine.parent)
    assert run.exit_code == 1
    assert "while loading mine/control.py" in run.stderr
    assert "line 2" in run.stderr
    assert "SyntaxError" in run.stderr
    assert "Traceback" not in run.stderr
    assert {file: file.read_bytes() for file in (mine.parent / "robsim-run").iterdir()} == before


@pytest.mark.usefixtures("undrawn")
def test_an_exception_names_the_line_and_the_steps_before_are_kept(mine):
    (mine / "control.py").write_text(
        "def control(step):\n    return 1 / (4 - step.k), 0.0\n", encoding="utf-8"
    )
    run = command("run", "mine", "--steps", "9", cwd=mine.parent)
    assert run.exit_code == 1
    assert "in the callback control at step 4" in run.stderr
    assert 'control.py", line 2, in control' in run.stderr
    assert "ZeroDivisionError" in run.stderr
    assert "simulation.py" not in run.stderr
    assert len(robsim.Trace.load(mine.parent / "robsim-run" / "cut-short.npz")) == 4


@pytest.mark.usefixtures("undrawn")
def test_a_wrong_return_and_a_hanging_callback(mine):
    (mine / "control.py").write_text("def control(step):\n    return 'left'\n")
    run = command("run", "mine", "--steps", "5", cwd=mine.parent)
    assert run.exit_code == 1
    assert "in the callback control at step 0" in run.stderr
    (mine / "control.py").write_text("def control(step):\n    while True:\n        pass\n")
    run = command("run", "mine", "--steps", "5", "--time-limit", "0.3", cwd=mine.parent)
    assert run.exit_code == 1
    assert "longer than --time-limit = 0.3 s" in run.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("dance",), "No such command 'dance'"),
        (("demo", "--steps", "20"), "--steps must be at least 50"),
        (("demo", "--seed", "-1"), "--seed must be at least 0"),
        (("demo", "--steps", "many"), "it must be a whole number, got 'many'"),
        (("run", "none"), "no folder none: robsim new none creates it"),
        (
            ("run", "--resolution", "large"),
            "--resolution must be a size such as 640x480, got 'large'",
        ),
        (("run", "--noise", "loud"), "--noise must be a noise such as gaussian:10"),
        (("run", "--noise", "gausian:4"), "got 'gausian:4'; did you mean 'gaussian'?"),
        (("run", "--noise", "gaussian:-4"), "--noise: percent must be finite and at least 0"),
        (("run", "--control", "dance"), "--control must be one of spin, drive-around, "),
        (("run", "--control", "go-to-pont:3,4"), "; did you mean 'go-to-point'?"),
        (("run", "--control", "spin:3,4"), "--control spin takes no points, got 'spin:3,4'"),
        (
            ("run", "--control", "go-to-point"),
            "--control must be go-to-point: and one point X,Y such as",
        ),
        (
            ("run", "--control", "follow-path:3"),
            "must be follow-path: and one or more points",
        ),
        (("run", "--control", "go-to-point:inf,3"), "--control: x must be finite (px), got inf"),
        (("run", "--start", "300,300"), "--start must be x,y,heading in px, px and degrees"),
        (("run", "--start", "a,300,nan"), "--start must be x,y,heading in px, px and degrees"),
        (("run", "--start", "-3,300,0"), "--start must lie within the area of 1200 x 1200 px"),
        (("run", "--steps", "-1"), "--steps must lie within 0.."),
        (("run", "--seed", "-1"), "--seed must be at least 0"),
        (("run", "--headings", "999"), "--headings must lie within 1..360"),
        (("run", "--smoothing", "99"), "--smoothing must lie within 1..15"),
        (("run", "--time-limit", "-1"), "--time-limit must be finite and above 0"),
        (("run", "--area", "5x5"), "--area must lie within 16..16384 px"),
        (("run", "--scenario", "no.toml"), "no.toml: No such file or directory"),
        (
            ("run", "--noise", "uniform"),
            "--noise must be a noise such as gaussian:10 or uniform:10",
        ),
        (("run", "--dropout", "much"), "--dropout must be a probability such as 0.2, or 0.2:5"),
        (("run", "--headings", "some"), "--headings must be a number such as 36, or continuous"),
        (("run", "--robot", "nobody"), "no robot 'nobody'"),
        (("run", "--dropout", "2"), "probability must lie within 0..1"),
        (("run", "--boundary", "fence"), "boundary must be one of"),
        (("run", "--steps", "99999999", "--video", "run.xyz"), "run.xyz: the name of a video must"),
        (("run", "--steps", "99999999", "--record", "a/run.mkv"), "there is no folder a"),
        (
            ("run", "--steps", "99999999", "--record", "a.mkv", "--video", "./a.mkv"),
            "--video and --record must be two files",
        ),
        (("run", "--steps", "99999999", "--out", sys.executable), "is a file, not a folder"),
        (("track", ".", "--out", "."), "--out . would overwrite .: give another folder"),
        (("track", "none.mp4"), "there is no file or folder none.mp4"),
        (("track", ".", "--pixels", "1,2 3,4"), "--pixels and --positions belong together"),
        (
            ("track", ".", "--pixels", "1,2", "--positions", "1,2"),
            "--pixels must be at least four points",
        ),
        (("track", "."), "there are no images in the folder"),
        (("run", "--unit", "inch"), "--unit must be one of 'px', 'mm', 'cm', 'm', got 'inch'"),
        (("run", "--unit", "mm"), "--unit mm needs --scale MM, how long a px of the work area is"),
        (("track", ".", "--unit", "mm"), "in mm, or a --calibration that says it"),
        (("run", "--scale", "2"), "--scale is for lengths in mm, cm or m: add --unit mm"),
        (("run", "--unit", "mm", "--scale", "0"), "--scale must lie within 0.001..10000 (mm)"),
    ],
)
def test_a_wrong_call_says_what_is_wrong(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = command(*arguments)
    assert run.exit_code == 2
    assert isinstance(run.exception, SystemExit)
    assert message in run.stderr.replace("\n", " ")
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("undrawn")  # those of the demo are drawn
def test_a_run_with_estimates_writes_their_figures(tmp_path):
    run = command(
        "run", "--steps", "30", "--estimate-parameters", "--boundary", "unlimited", cwd=tmp_path
    )
    assert run.exit_code == 0, run.stderr
    names = {file.name for file in (tmp_path / "robsim-run").iterdir()}
    assert names == {"camera.jpg", "traces.png", "parameters.png", "batch.png", "trace.npz"}
    assert "Batch estimate from truth" in run.stdout


@pytest.mark.usefixtures("undrawn")
def test_the_results_have_the_unit_that_was_asked_for(tmp_path):
    run = command(
        *("run", "--steps", "10", "--measure", "--seed", "1", "--unit", "cm", "--scale", "2"),
        *("--estimate-parameters", "--json"),
        cwd=tmp_path,
    )
    assert run.exit_code == 0, run.stderr
    numbers = json.loads(run.stdout)
    assert numbers["batch_estimate"]["parameters"]["b1X"]["true"] == pytest.approx(0.2083333 / 5)
    trace = robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")
    assert (trace.info.unit, trace.info.mm_per_px) == ("cm", 2)
    assert numbers["tracking"]["rmse_xy"] == trace.tracking().rmse_xy < 0.2  # 1 px
    np.testing.assert_allclose(trace.pose_true[0, :2], (120, 120))


@pytest.mark.usefixtures("undrawn")
def test_a_recorded_run_is_tracked_from_its_file_as_it_was(tmp_path):
    pytest.importorskip("cv2")
    run = command(
        *("run", "--steps", "8", "--measure", "--seed", "2", "--headings", "continuous"),
        *("--resolution", "600x600", "--record", "run.mkv", "--video", "run.webm"),
        cwd=tmp_path,
    )
    assert run.exit_code == 0, run.stderr
    assert (tmp_path / "run.webm").stat().st_size > 10_000
    run = command("track", "run.mkv", "--area", "1200x1200", cwd=tmp_path)
    assert run.exit_code == 0, run.stderr
    assert "8 (100 %)\n" in run.stdout
    assert "the true poses are not known" in run.stdout
    one, other = (
        robsim.Trace.load(tmp_path / folder / "trace.npz")
        for folder in ("robsim-run", "robsim-track")
    )
    np.testing.assert_array_equal(one.pose_measured, other.pose_measured)
    recording = robsim.Recording(tmp_path / "robsim-track" / "tracked.mp4")
    assert len(list(recording)) == 8


@pytest.mark.usefixtures("undrawn")
def test_why_some_frames_are_without_a_detection(tmp_path):
    frames = tmp_path / "frames"
    frames.mkdir()
    image = robsim.Simulation(seed=1, resolution=(400, 400)).frame.image
    for k in range(6):
        robsim.imaging.save_image(frames / f"{k}.png", image // 100 if k in (1, 2, 4) else image)
    robsim.imaging.save_image(frames / "5.png", np.where(image[..., 2:] > 150, 90, image))
    run = command("track", "frames", "--area", "1200x1200", "--no-video", cwd=tmp_path)
    assert "2 (33.3 %)" in run.stdout
    assert (
        "no detection in 4 of 6 steps: in 3, first in step 1, the picture is dark: mean level 1 "
        "of 255. No robot was detected: more light, a longer exposure, or colours trained in this "
        "light; in 1: no blue blob"
    ) in run.stderr


@pytest.mark.usefixtures("undrawn")
@pytest.mark.filterwarnings("always")
def test_bgr_frames_are_told(tmp_path, monkeypatch, capsys):
    frames = tmp_path / "frames"
    frames.mkdir()
    image = robsim.Simulation(seed=1, resolution=(400, 400)).frame.image
    robsim.imaging.save_image(frames / "0.png", np.ascontiguousarray(image[..., ::-1]))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["robsim", "track", "frames", "--area", "1200x1200"])
    with pytest.raises(SystemExit, match="0"):
        main()
    said = capsys.readouterr().err
    assert "warning: the robot lab is seen only if red and blue are exchanged" in said


@pytest.mark.usefixtures("undrawn")
def test_more_than_four_points_say_how_well_they_fit(tmp_path):
    frames = tmp_path / "frames"
    frames.mkdir()
    image = robsim.Simulation(seed=1, resolution=(400, 400)).frame.image
    robsim.imaging.save_image(frames / "0.png", image)
    points = "0,0 399,0 399,399 0,399 200,200"
    places = "1,1 1198,1 1198,1198 1,1198 602,601"
    run = command(
        *("track", "frames", "--pixels", points, "--positions", places, "--no-video"),
        *("--area", "1200x1200"),
        cwd=tmp_path,
    )
    assert "the 5 points fit within 0.7 px of the work area (number 5), rms" in run.stderr
    assert "1 (100 %)" in run.stdout


@pytest.mark.usefixtures("undrawn")
def test_a_folder_of_images_whose_size_changes_keeps_what_was_tracked(tmp_path):
    sim = robsim.Simulation(resolution=(400, 400), seed=1)
    (tmp_path / "frames").mkdir()
    for k in range(12):
        image = sim.step().frame.image
        robsim.imaging.save_image(
            tmp_path / "frames" / f"frame{k}.png", image if k < 10 else image[:300]
        )
    run = command("track", "frames", "--area", "1200x1200", "--no-video", cwd=tmp_path)
    assert run.exit_code == 2
    assert "frame10.png is 400 x 300 px, the frames before it 400 x 400" in run.stderr
    assert "the 10 frames before the error are tracked" in run.stderr
    trace = robsim.Trace.load(tmp_path / "robsim-track" / "trace.npz")
    assert len(trace) == 10
    assert trace.seen.all()


@pytest.mark.usefixtures("undrawn")
def test_without_opencv_images_are_tracked_all_the_same(tmp_path, monkeypatch):
    frame = robsim.Simulation(resolution=(400, 400), seed=1).frame
    (tmp_path / "frames").mkdir()
    robsim.imaging.save_image(tmp_path / "frames" / "frame0.png", frame.image)
    monkeypatch.setitem(sys.modules, "cv2", None)  # importing it raises ImportError
    run = command("track", "frames", "--area", "1200x1200", cwd=tmp_path)
    assert run.exit_code == 0, run.stderr
    assert (
        "no tracked.mp4: writing a video needs OpenCV: pip install opencv-python-headless"
        in run.stderr
    )
    assert len(robsim.Trace.load(tmp_path / "robsim-track" / "trace.npz")) == 1


@pytest.mark.usefixtures("undrawn")
def test_figures_of_another_run_do_not_stay(tmp_path):
    (tmp_path / "robsim-run").mkdir()
    (tmp_path / "robsim-run" / "parameters.png").write_text("old")
    (tmp_path / "robsim-run" / "mine.txt").write_text("mine")
    assert command("run", "--steps", "3", cwd=tmp_path).exit_code == 0
    names = {file.name for file in (tmp_path / "robsim-run").iterdir()}
    assert names == {"camera.jpg", "traces.png", "trace.npz", "mine.txt"}


@pytest.mark.usefixtures("undrawn")
def test_a_controller_that_needs_a_point(tmp_path):
    arguments = ("--control", "go-to-point:700,600", "--start", "600,600,0", "--seed", "0")
    command("run", "--steps", "60", *arguments, cwd=tmp_path)
    trace = robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")
    assert trace.seen.all()
    assert trace.pose_true[-1, 0] > 680
    scenario = robsim.Scenario.of(trace)
    assert scenario.start == (600, 600, 0)
    assert scenario.seed == 0


@pytest.mark.usefixtures("undrawn")
def test_a_path_and_a_start_in_degrees(tmp_path):
    path = ("--control", "follow-path:300,400 300,500", "--start", "300,300,450")
    command("run", "--steps", "2", *path, cwd=tmp_path)
    trace = robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")
    np.testing.assert_allclose(trace.pose_true[0], (300, 300, np.pi / 2))


@pytest.mark.usefixtures("undrawn")
def test_a_second_run_says_that_it_replaces_the_first(tmp_path):
    remark = "the earlier run in robsim-run is replaced; --out gives another folder"
    assert remark not in command("run", "--steps", "2", cwd=tmp_path).stderr
    assert remark in command("run", "--steps", "3", cwd=tmp_path).stderr
    assert len(robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")) == 3


def test_a_log_has_no_progress_bar(first_run):
    _, run = first_run
    assert "it/s" not in run.stderr
    assert "\r" not in run.stderr


def test_a_disk_that_is_full_is_told_by_the_name_of_the_file(tmp_path):
    def said(*arguments, kilobytes):
        with full_disk(kilobytes * 1024):
            return command(*arguments, cwd=tmp_path).stderr

    data = {"robsim-run/trace.npz": 0, "robsim-run/camera.jpg": 8}
    for file, kilobytes in data.items():
        assert f"error: {file}: File too large" in said("run", "--steps", "5", kilobytes=kilobytes)
    assert "error: frame.png: File" in said("colors", "frame", kilobytes=8)
    assert "error: robot-lab.png: File" in said("robots", "show", "lab", kilobytes=8)
    assert not list(tmp_path.rglob(".*"))


def test_a_command_that_is_stopped_says_so(monkeypatch):
    def stopped(**options):
        raise KeyboardInterrupt

    monkeypatch.setattr("robsim.bench.run_bench", stopped)
    run = command("bench")
    assert run.stderr == "stopped\n"
    assert run.exit_code == 130


@pytest.mark.usefixtures("undrawn")
def test_a_callback_that_ends_the_program_keeps_the_steps(mine):
    (mine / "control.py").write_text(
        "def control(step):\n    if step.k == 3:\n        exit()\n    return 0, 0\n"
    )
    command("run", "mine", "--steps", "9", cwd=mine.parent)
    assert len(robsim.Trace.load(mine.parent / "robsim-run" / "cut-short.npz")) == 3


@pytest.mark.usefixtures("undrawn")
def test_what_was_not_asked_for_is_not_in_json(tmp_path):
    run = command("run", "--steps", "2", "--out", "out", "--json", cwd=tmp_path)
    assert json.loads(run.stdout) == {}


@pytest.mark.usefixtures("undrawn")
def test_unknown_numbers_are_null_in_json(tmp_path):
    frame = robsim.Simulation(resolution=(400, 400), seed=1).frame
    robsim.imaging.save_image(tmp_path / "frame0.png", frame.image)
    run = command(
        "track", ".", "--area", "1200x1200", "--out", "out", "--no-video", "--json", cwd=tmp_path
    )
    assert json.loads(run.stdout)["tracking"]["rmse_xy"] is None
    assert "NaN" not in run.stdout
