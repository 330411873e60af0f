import os
import subprocess
import sys
import threading
import warnings

import numpy as np
import pytest
from PIL import Image

import robsim
from refusals import refuses
from robsim import Recording
from robsim.vision import VideoWriter, save_video
from surroundings import full_disk

pytest.importorskip("av")

LOSSLESS = [".mkv", ".avi"]
SMALL = [".mp4", ".webm"]
CODECS = [*SMALL, *LOSSLESS]


def smooth(rng, *, width=64, height=48, count=5):
    """Frames without fine detail, which all codecs keep."""
    coarse = rng.integers(40, 216, (count, 3, 4, 3), dtype=np.uint8)
    return [np.array(Image.fromarray(pixels).resize((width, height))) for pixels in coarse]


def images(path):
    return [frame.image for frame in Recording(path)]


def files(folder):
    return sorted(file.name for file in folder.iterdir())


@pytest.mark.parametrize("ending", LOSSLESS)
def test_lossless_is_lossless(tmp_path, rng, ending):
    path = tmp_path / f"run{ending}"
    frames = rng.integers(0, 256, (6, 48, 64, 3), dtype=np.uint8)
    save_video(path, [robsim.Frame(frames[0]), *frames[1:, :, ::-1]], fps=5)
    np.testing.assert_array_equal(images(path), [frames[0], *frames[1:, :, ::-1]])
    assert files(tmp_path) == [path.name]


@pytest.mark.parametrize("ending", SMALL)
def test_small_files_look_alike(tmp_path, rng, ending):
    path = tmp_path / f"run{ending.upper()}"
    frames = smooth(rng)
    save_video(path, frames, fps=5)
    error = np.abs(np.subtract(images(path), frames, dtype=float))
    assert error.mean() < 5  # as if red and blue were swapped: 50


@pytest.mark.long
@pytest.mark.parametrize("ending", CODECS)
def test_keeps_the_rate(tmp_path, ending):
    path = tmp_path / f"run{ending}"
    for fps in (0.1, 29.97, 1 / 0.015, 500):
        save_video(path, np.zeros((3, 64, 64, 3), dtype=np.uint8), fps=fps)
        assert pytest.approx(1 / fps, rel=2e-3) == Recording(path).dt


@pytest.mark.parametrize("ending", SMALL)
def test_odd_sizes_are_filled_up(tmp_path, rng, ending):
    path = tmp_path / f"run{ending}"
    frames = smooth(rng, width=65, height=47)
    save_video(path, frames, fps=5)
    got = np.array(images(path), dtype=float)
    assert got.shape == (5, 48, 66, 3)
    assert np.abs(got[:, :47, :65] - frames).mean() < 5
    assert np.abs(got[:, 47] - got[:, 46]).mean() < 5


@pytest.mark.parametrize("ending", LOSSLESS)
def test_odd_sizes_stay_where_every_pixel_counts(tmp_path, rng, ending):
    for width, height in ((65, 48), (64, 47), (9, 15)):
        frames = rng.integers(0, 256, (3, height, width, 3), dtype=np.uint8)
        save_video(tmp_path / f"run{ending}", frames, fps=5)
        np.testing.assert_array_equal(images(tmp_path / f"run{ending}"), frames)


def test_a_change_of_size_leaves_what_came_before(tmp_path, rng):
    frames = [*smooth(rng), np.zeros((48, 66, 3), dtype=np.uint8)]
    with pytest.raises(ValueError, match="frame 5 has 66 x 48 px"):
        save_video(tmp_path / "run.mkv", frames, fps=5)
    np.testing.assert_array_equal(images(tmp_path / "run.mkv"), frames[:5])


@pytest.mark.parametrize("ending", CODECS)
def test_an_exception_leaves_what_came_before(tmp_path, rng, ending):
    def broken_off():
        yield from smooth(rng)
        raise KeyboardInterrupt

    path = tmp_path / f"run{ending}"
    with pytest.raises(KeyboardInterrupt):
        save_video(path, broken_off(), fps=5)
    assert len(images(path)) == 5
    assert files(tmp_path) == [path.name]


def test_no_frames_leave_the_old_file(tmp_path):
    path = tmp_path / "run.mp4"
    path.write_text("an older one")
    with pytest.raises(ValueError, match=r"run\.mp4"):
        save_video(path, [], fps=5)
    with pytest.raises(ZeroDivisionError):
        save_video(path, (1 / 0 for _ in range(3)), fps=5)
    assert path.read_text() == "an older one"
    assert files(tmp_path) == ["run.mp4"]


def test_the_file_gets_its_name_at_the_end(tmp_path, rng):
    with VideoWriter(tmp_path / "run.mkv", fps=5) as video:
        for pixels in smooth(rng):
            video.write(pixels)
        assert "run.mkv" not in files(tmp_path)
        assert video.count == 5
    assert files(tmp_path) == ["run.mkv"]
    before = (tmp_path / "run.mkv").read_bytes()
    video.close()
    with pytest.raises(ValueError, match=r"run\.mkv"):
        video.write(pixels)
    assert (tmp_path / "run.mkv").read_bytes() == before


@pytest.mark.long
@pytest.mark.parametrize("ending", CODECS)
def test_a_full_disk_leaves_no_part_of_a_video(tmp_path, ending, rng):
    frames = rng.integers(0, 256, (10, 160, 160, 3), dtype=np.uint8)
    with full_disk(20_000), pytest.raises(OSError, match=f"run{ending}"):
        save_video(tmp_path / f"run{ending}", frames, fps=5)
    assert files(tmp_path) == []


def test_what_is_no_video(tmp_path):
    for name in ("run", "run.mov", ".mp4"):
        with pytest.raises(ValueError, match=r"\.mp4, \.webm, \.mkv, \.avi"):
            save_video(tmp_path / name, [], fps=5)
    with pytest.raises(FileNotFoundError, match=r"run\.mp4.*gone"):
        save_video(tmp_path / "gone/run.mp4", [], fps=5)
    refuses(r"frames[0]", save_video, tmp_path / "run.mp4", [np.zeros((8, 8))], fps=5)
    for fps in (0, -5, 0.09, 501, np.nan, np.inf):
        refuses("fps", VideoWriter, tmp_path / "run.mp4", fps=fps)
    for name, width, height in (("a.mp4", 8200, 16), ("a.webm", 16400, 16)):  # not for the codec
        with pytest.raises(OSError, match=name):
            save_video(tmp_path / name, [np.zeros((height, width, 3), np.uint8)], fps=5)
    assert files(tmp_path) == []


def test_the_terminal_stays_clean(tmp_path, rng, capfd):
    for ending in CODECS:
        save_video(tmp_path / f"run{ending}", smooth(rng), fps=5)
        images(tmp_path / f"run{ending}")
    with pytest.raises(OSError, match="written"):
        save_video(tmp_path / "a.webm", [np.zeros((16, 16400, 3), dtype=np.uint8)], fps=5)
    assert capfd.readouterr() == ("", "")


@pytest.mark.long
def test_what_others_print_while_a_video_is_read_is_not_lost(tmp_path, rng, capfd):
    save_video(tmp_path / "run.mkv", smooth(rng), fps=5)
    damaged = bytearray((tmp_path / "run.mkv").read_bytes())
    damaged[2000:2020] = bytes(20)
    (tmp_path / "run.mkv").write_bytes(damaged)
    capfd.readouterr()
    is_done = threading.Event()
    written = 0

    def write():
        nonlocal written
        while not is_done.is_set():
            os.write(2, b"still here\n")
            written += 1

    thread = threading.Thread(target=write)
    thread.start()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it ends early
        for _ in range(10):
            images(tmp_path / "run.mkv")
    is_done.set()
    thread.join()
    assert capfd.readouterr().err == "still here\n" * written


@pytest.mark.long
def test_a_half_read_recording_at_the_end_of_python_is_silent(tmp_path, rng):
    save_video(tmp_path / "run.mkv", smooth(rng), fps=5)
    code = f"""
import robsim
frames = iter(robsim.Recording({str(tmp_path / "run.mkv")!r}))
next(frames)
class Late:
    def __init__(self, frames): self.me, self.frames = self, frames
late = Late(iter(robsim.Recording({str(tmp_path / "run.mkv")!r})))
next(late.frames)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


def test_without_pyav(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ImportError, match="PyAV"):
        save_video(tmp_path / "run.mp4", [], fps=5)


@pytest.fixture(scope="module")
def run():
    """Frames of a run and what it measured in them, (N, 3)."""
    simulation = robsim.Simulation(
        measure=True, headings=None, seed=3, control=robsim.DriveAround()
    )
    steps = [simulation.step() for _ in range(8)]
    assert all(step.measurement for step in steps)
    return [step.frame for step in steps], np.array([step.measurement.pose for step in steps])


def measured_in(path):
    colors, markers = robsim.load_colors(), robsim.load_robot("lab").marker_layout()
    found = [
        robsim.locate(robsim.find_blobs(frame, colors, markers=markers), markers, image=frame)
        for frame in Recording(path)
    ]
    return np.array([measurement.pose for measurement in found])


@pytest.mark.long
@pytest.mark.parametrize("ending", SMALL)
def test_a_run_in_a_small_video_measures_nearly_the_same(tmp_path, run, ending):
    frames, measured = run
    save_video(tmp_path / f"run{ending}", frames, fps=5)
    error = measured_in(tmp_path / f"run{ending}") - measured
    heading = np.rad2deg(robsim.wrap_angle(error[:, 2]))
    rms = np.sqrt(np.mean(np.sum(error[:, :2] ** 2, axis=1))), np.sqrt(np.mean(heading**2))
    print(f"rms: {rms[0]:.3f} px, {rms[1]:.3f} degrees")
    assert rms[0] < 0.3
    assert rms[1] < 0.5
