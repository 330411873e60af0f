"""The commands new, run and track, as a student types them."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import robsim
from commands import cli, command
from robsim.cli import main
from robsim.vision import save_image
from surroundings import full_disk

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """A folder with untouched callbacks, and a first run of them in a process of its own."""
    desk = tmp_path_factory.mktemp("desk")
    assert command("new", "mine", cwd=desk).exit_code == 0
    run = cli("run", "mine", "--steps", "12", "--measure", "--seed", "1", cwd=desk)
    assert run.returncode == 0, run.stderr
    assert "\r" not in run.stderr  # a log has no progress bar
    return desk


@pytest.fixture
def mine(desk, tmp_path):
    shutil.copytree(desk / "mine", tmp_path / "mine")
    shutil.copytree(desk / "robsim-run", tmp_path / "robsim-run")
    return tmp_path / "mine"


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


@pytest.mark.usefixtures("undrawn")
def test_a_run_with_a_goal_tells_the_distance_at_the_end(tmp_path):
    words = ("run", "--control", "go-to-point:700,600", "--start", "600,600,0", "--goal", "700,600")
    mm = ("--unit", "mm", "--scale", "2", "--steps", "60", "--seed", "1", "--json")
    path = json.loads(command(*words, *mm, cwd=tmp_path).stdout)["path"]
    trace = robsim.Trace.load(tmp_path / "robsim-run/trace.npz")
    distance = np.hypot(*(trace.pose_true[-1, :2] - (1400, 1200)))
    assert path["final_distance"] == pytest.approx(distance)
    assert path["units"]["final_distance"] == "mm"


def test_new_quotes_a_folder_with_a_space_and_does_not_overwrite(desk):
    assert "robsim run 'my work'\n" in command("new", "my work", cwd=desk).stdout
    run = command("new", "mine", cwd=desk)
    assert run.exit_code == 2
    assert "define_model.py" in run.stderr


def test_a_syntax_error_names_file_and_line_and_leaves_the_last_results_alone(mine):
    before = {file: file.read_bytes() for file in (mine.parent / "robsim-run").iterdir()}
    (mine / "control.py").write_text("def control(step):\n    return (0.1, 0.2\n")
    run = command("run", "mine", "--steps", "5", cwd=mine.parent)
    assert run.exit_code == 1
    for words in ("mine/control.py", "line 2", "SyntaxError"):
        assert words in run.stderr
    assert "Traceback" not in run.stderr
    assert {file: file.read_bytes() for file in (mine.parent / "robsim-run").iterdir()} == before


@pytest.mark.usefixtures("undrawn")
def test_an_exception_names_the_line_and_the_steps_before_are_kept(mine):
    (mine / "control.py").write_text("def control(step):\n    return 1 / (4 - step.k), 0.0\n")
    run = command("run", "mine", "--steps", "9", cwd=mine.parent)
    assert run.exit_code == 1
    for words in ("control at step 4", 'control.py", line 2', "ZeroDivisionError"):
        assert words in run.stderr
    assert "simulation.py" not in run.stderr
    assert len(robsim.Trace.load(mine.parent / "robsim-run" / "cut-short.npz")) == 4


@pytest.mark.usefixtures("undrawn")
def test_a_wrong_return_and_a_hanging_callback(mine):
    (mine / "control.py").write_text("def control(step):\n    return 'left'\n")
    run = command("run", "mine", "--steps", "5", cwd=mine.parent)
    assert run.exit_code == 1
    assert "control at step 0" in run.stderr
    (mine / "control.py").write_text("def control(step):\n    while True:\n        pass\n")
    run = command("run", "mine", "--steps", "5", "--time-limit", "0.3", cwd=mine.parent)
    assert run.exit_code == 1
    assert "time_limit" in run.stderr


def test_a_wrong_call_says_what_is_wrong(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for named, arguments in [
        ("steps", ("demo", "--steps", "20")),
        ("--steps", ("demo", "--steps", "many")),
        ("--resolution", ("run", "--resolution", "large")),
        ("--dropout", ("run", "--dropout", "much")),
        ("headings", ("run", "--headings", "some")),
        ("--control", ("run", "--control", "spin:3,4")),
        ("--unit", ("run", "--scale", "2")),
        ("--scale", ("run", "--unit", "mm", "--scale", "0")),
        ("start", ("run", "--start", "-3,300,0")),
        ("--video", ("run", "--steps", "99999999", "--record", "a.mkv", "--video", "./a.mkv")),
        ("--calibration", ("track", ".", "--unit", "mm")),
        ("gaussian", ("run", "--noise", "gausian:4")),
        ("--control", ("run", "--control", "dance")),
        ("quotes", ("run", "--control", "follow-path:9,3", "8,3")),
        ("start", ("run", "--start", "a,300,nan")),
        ("--headings", ("run", "--headings", "361")),
        ("--motor-delay", ("run", "--motor-delay", "1000.5")),
        ("--identify-from", ("run", "--identify-from", "nothing")),
        ("smoothing", ("run", "--smoothing", "99")),
        ("error: --time-limit must", ("run", "--time-limit", "-1")),
        ("error: --markers: no robot", ("run", "--markers", "none")),
        ("error: --headings must", ("run", "--headings", "0")),
        ("percent must lie within 0..100", ("run", "--noise", "gaussian:200")),
        ("--dropout: steps must", ("run", "--dropout", "0.2:0")),
        ("no.toml", ("run", "--scenario", "no.toml")),
        ("nobody", ("run", "--robot", "nobody")),
        ("boundary", ("run", "--boundary", "fence")),
        ("run.xyz", ("run", "--steps", "99999999", "--video", "run.xyz")),
        ("folder a", ("run", "--steps", "99999999", "--record", "a/run.mkv")),
        (sys.executable, ("run", "--steps", "99999999", "--out", sys.executable)),
        ("--out", ("track", ".", "--out", ".")),
        ("none.mp4", ("track", "none.mp4")),
        ("robsim.Experiment", ("track", "rtsp://camera")),
        ("--pixels and --positions", ("track", ".", "--pixels", "1,2 3,4")),
        ("no images", ("track", ".")),
        ("--unit", ("run", "--unit", "inch")),
        ("--goal must be one point", ("run", "--goal", "900")),
        ("--goal", ("run", "--goal", "nan,3")),
        ("rounds", ("bench", "--rounds", "0")),
    ]:
        run = command(*arguments)
        assert run.exit_code == 2, arguments
        assert isinstance(run.exception, SystemExit)
        assert named in run.stderr, arguments
        assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("undrawn")  # those of the demo are drawn
def test_a_run_with_estimates_writes_their_figures_and_removes_those_of_another(tmp_path):
    run = ("run", "--steps", "30", "--boundary", "unlimited")
    assert command(*run, "--estimate-parameters", cwd=tmp_path).exit_code == 0
    out = tmp_path / "robsim-run"
    names = {file.name for file in out.iterdir()}
    assert names == {"camera.jpg", "traces.png", "parameters.png", "batch.png", "trace.npz"}
    (out / "mine.txt").write_text("mine")
    again = command(*run[:-2], cwd=tmp_path)
    assert "replaced" in again.stderr
    names = {file.name for file in out.iterdir()}
    assert names == {"camera.jpg", "traces.png", "trace.npz", "mine.txt"}
    command("run", "--steps", "0", cwd=tmp_path)
    assert len(robsim.Trace.load(out / "trace.npz")) == 30  # no steps replace no earlier run


@pytest.mark.usefixtures("undrawn")
def test_the_results_have_the_unit_that_was_asked_for(tmp_path):
    run = command(
        *("run", "--steps", "10", "--measure", "--seed", "1", "--unit", "cm", "--scale", "2"),
        *("--estimate-parameters", "--json"),
        cwd=tmp_path,
    )
    numbers = json.loads(run.stdout)
    assert numbers["batch_estimate"]["parameters"]["b1X"]["true"] == pytest.approx(0.2083333 / 5)
    trace = robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")
    assert (trace.info.unit, trace.info.mm_per_px) == ("cm", 2)
    assert numbers["tracking"]["rmse_xy"] == trace.tracking().rmse_xy < 0.2  # 1 px
    np.testing.assert_allclose(trace.pose_true[0, :2], (120, 120))


@pytest.mark.usefixtures("undrawn")
def test_a_scenario_is_run_and_options_change_it(tmp_path):
    scenario = robsim.Scenario(
        measure=True,
        control=robsim.DriveAround(),
        resolution=(240, 240),
        headings=None,
        noise=robsim.GaussianNoise(5),
        process_noise=robsim.WheelNoise(0.05),
        seed=3,
    )
    scenario.save(tmp_path / "noisy.toml")
    changed = scenario.replace(noise=robsim.UniformNoise(3), headings=36, seed=4)
    options = ("--noise", "uniform:3", "--headings", "36", "--seed", "4")
    for more, expected in {(): scenario, options: changed}.items():
        run = command("run", "--scenario", "noisy.toml", "--steps", "6", *more, cwd=tmp_path)
        assert run.exit_code == 0, run.stderr
        trace = robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")
        assert robsim.Scenario.of(trace) == expected
        again = robsim.Simulation(expected).run(6)
        np.testing.assert_array_equal(again.pose_measured, trace.pose_measured)


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
    trace, other = (
        robsim.Trace.load(tmp_path / folder / "trace.npz")
        for folder in ("robsim-run", "robsim-track")
    )
    np.testing.assert_array_equal(trace.pose_measured, other.pose_measured)
    recording = robsim.Recording(tmp_path / "robsim-track" / "tracked.mp4")
    assert len(list(recording)) == 8
    assert 1 / recording.dt == pytest.approx(1 / trace.info.dt, rel=0.01)


@pytest.fixture
def frames(tmp_path):
    """A folder, and what is to be seen in it."""
    (tmp_path / "frames").mkdir()
    return tmp_path / "frames", robsim.Simulation(seed=1, resolution=(400, 400)).frame.image


def tracked(folder, *options):
    """Track the images of a folder; return what is said, and the trace."""
    words = ("track", folder.name, "--area", "1200x1200", "--no-video", *options)
    run = command(*words, cwd=folder.parent)
    return run, robsim.Trace.load(folder.parent / "robsim-track/trace.npz")


@pytest.mark.usefixtures("undrawn")
def test_why_some_frames_are_without_a_detection(frames):
    folder, image = frames
    for k in range(6):
        save_image(folder / f"{k}.png", image // 100 if k in (1, 2, 4) else image)
    save_image(folder / "5.png", np.where(image[..., 2:] > 150, 90, image))
    run, trace = tracked(folder)
    assert trace.seen.tolist() == [True, False, False, True, False, False]
    assert re.search("4 of 6 steps.* 3, first in step 1.* dark.* 1: no blue blob", run.stderr)


@pytest.mark.usefixtures("undrawn")
def test_the_exit_status_tells_that_the_robot_was_never_seen(frames):
    folder, image = frames
    save_image(folder / "0.png", np.full_like(image, 150))
    run, trace = tracked(folder)
    assert not trace.seen.any()
    assert run.exit_code == 1
    assert "measure=True" not in run.stdout + run.stderr
    save_image(folder / "1.png", image)
    assert tracked(folder)[0].exit_code == 0


@pytest.mark.usefixtures("undrawn")
@pytest.mark.filterwarnings("always")
def test_bgr_frames_are_told(frames, monkeypatch, capsys):
    folder, image = frames
    save_image(folder / "0.png", np.ascontiguousarray(image[..., ::-1]))
    monkeypatch.chdir(folder.parent)
    monkeypatch.setattr(sys, "argv", ["robsim", "track", "frames", "--area", "1200x1200"])
    with pytest.raises(SystemExit, match="0"):
        main()
    assert "exchanged" in capsys.readouterr().err


@pytest.mark.usefixtures("undrawn")
def test_track_names_its_robot_as_all_poses_depend_on_it(frames):
    folder, image = frames
    save_image(folder / "0.png", image)
    said = " ".join(tracked(folder)[0].stderr.split())
    assert "robot lab (right marker red, left marker blue)" in said
    assert "true only for this robot" in said


@pytest.mark.usefixtures("undrawn")
def test_more_than_four_points_say_how_well_they_fit(frames):
    folder, image = frames
    save_image(folder / "0.png", image)
    points = ("--pixels", "0,0 399,0 399,399 0,399 200,200")
    run, trace = tracked(folder, *points, "--positions", "1,1 1198,1 1198,1198 1,1198 602,601")
    assert "within 0.7 px" in run.stderr
    assert trace.seen.all()
    four = ("--pixels", "0,0 399,0 399,399 0,399", "--positions", "1,1 1400,1 1198,1198 1,1198")
    assert "4 points are not checked" in tracked(folder, *four)[0].stderr


@pytest.mark.usefixtures("undrawn")
@pytest.mark.filterwarnings("always")
def test_pictures_that_cannot_be_read_are_steps_in_which_nothing_is_seen(frames):
    folder, image = frames
    for k in range(12):
        save_image(folder / f"frame{k}.png", image[:300] if k == 4 else image)
    (folder / "frame7.png").write_bytes(b"")
    with pytest.warns(UserWarning, match=r"2 of 12.*frame4\.png.*frame7\.png"):
        run, trace = tracked(folder, "--video")
    assert run.exit_code == 0, run.stderr
    assert trace.seen.tolist() == [k not in (4, 7) for k in range(12)]
    assert robsim.Recording(folder.parent / "robsim-track" / "tracked.mp4").count == 10


@pytest.mark.usefixtures("undrawn")
def test_without_pyav_images_are_tracked_all_the_same(frames, monkeypatch):
    folder, image = frames
    save_image(folder / "frame0.png", image)
    monkeypatch.setitem(sys.modules, "av", None)  # importing it raises ImportError
    run, trace = tracked(folder, "--video", "--json")
    assert run.exit_code == 0, run.stderr
    assert "PyAV" in run.stderr
    assert len(trace) == 1
    # What is not known of a recording is null.
    assert json.loads(run.stdout)["tracking"]["rmse_xy"] is None


@pytest.mark.usefixtures("undrawn")
def test_controllers_take_points_and_a_start_in_degrees(tmp_path):
    arguments = ("--control", "go-to-point:700,600", "--start", "600,600,0", "--seed", "0")
    command("run", "--steps", "60", *arguments, cwd=tmp_path)
    trace = robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")
    assert trace.seen.all()
    assert trace.pose_true[-1, 0] > 680
    scenario = robsim.Scenario.of(trace)
    assert (scenario.start, scenario.seed) == ((600, 600, 0), 0)
    path = ("--control", "follow-path:300,400 300,500", "--start", "300,300,450")
    command("run", "--steps", "2", *path, cwd=tmp_path)
    trace = robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")
    np.testing.assert_allclose(trace.pose_true[0], (300, 300, np.pi / 2))


def test_a_disk_that_is_full_is_told_by_the_name_of_the_file(tmp_path, monkeypatch):
    monkeypatch.setenv("ROBSIM_DATA", "data")
    for file, kilobytes, *arguments in [
        ("robsim-run/trace.npz", 0, "run", "--steps", "5"),
        ("robsim-run/camera.jpg", 8, "run", "--steps", "5"),
        ("frame.png", 8, "colors", "frame"),
        ("robot-lab.png", 8, "robots", "show", "lab"),
        ("data/robots/mine", 8, "robots", "add", "mine", "lab"),
    ]:
        with full_disk(kilobytes * 1024):
            run = command(*arguments, cwd=tmp_path)
        assert run.exit_code == 2
        assert f"error: {file}: File too large" in run.stderr
    assert not list(tmp_path.rglob(".*"))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_an_output_that_cannot_be_written():
    with open("/dev/full", "w") as full:
        words = [sys.executable, "-m", "robsim", "colors", "list"]
        run = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert run.returncode == 2
    assert "No space left on device" in run.stderr


def test_a_terminal_without_the_sign_for_degrees(monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    run = cli("robots", "list")
    assert run.returncode == 0, run.stderr
    assert "90?, faces up" in run.stdout


def test_a_command_that_is_stopped_says_so(monkeypatch):
    def stopped(**options):
        raise KeyboardInterrupt

    monkeypatch.setattr("robsim.cli.simulated.bench.run_bench", stopped)
    assert command("bench").exit_code == 130


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
    assert "--measure" in run.stderr
