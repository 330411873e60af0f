import os
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import robsim
from robsim import Recording
from robsim.vision import Intrinsics, PlaneMap, save_image, save_video


def picture(brightness, *, width=32, height=24):
    pixels = np.zeros((height, width, 3), dtype=np.uint8)
    pixels[:] = (brightness, 20, 200)
    pixels[: height // 2, : width // 2] = (255, 0, 0)  # red, where it is upper left
    return pixels


@pytest.fixture
def folder(tmp_path):
    """Five images whose brightness is their number."""
    for number in (1, 2, 3, 10, 20):
        save_image(tmp_path / f"frame{number}.png", picture(number))
    return tmp_path


def brightness(frames):
    return [int(frame.image[-1, -1, 0]) for frame in frames]


@pytest.fixture
def video(tmp_path):
    pytest.importorskip("av")
    file = tmp_path / "100% run.mkv"
    save_video(file, [picture(number) for number in range(8)], fps=12.5)
    return file


class TestFolder:
    def test_comes_in_natural_order_again_and_again(self, folder):
        recording = Recording(folder)
        for _ in range(2):
            assert brightness(recording) == [1, 2, 3, 10, 20]
        for one, other in zip(recording, recording, strict=True):
            assert one.index == other.index
        assert (recording.count, recording.size, recording.source) == (5, (32, 24), folder)

    def test_its_frames_have_a_number_and_a_time_if_one_is_given(self, folder):
        frames = list(Recording(folder))
        assert [frame.index for frame in frames] == [0, 1, 2, 3, 4]
        assert [frame.t for frame in frames] == [None] * 5
        assert [frame.t for frame in Recording(folder, dt=2)] == [0, 2, 4, 6, 8]

    def test_without_a_dt_the_model_says_how_far_apart_the_frames_are(self, folder):
        recording = Recording(folder)
        assert recording.dt is None
        for dt in (0.2, 0.5):
            model = robsim.RobotModel(robsim.RobotParameters(dt=dt))
            sim = robsim.Experiment(recording, define_model=lambda model=model: model)
            np.testing.assert_allclose(sim.run().t, dt * np.arange(5))

    def test_other_files_are_ignored(self, folder):
        (folder / "frame4.txt").write_text("a note")
        (folder / "frame4.mpg").write_text("no picture that Pillow reads")
        (folder / "._frame4.png").write_bytes(b"what a Mac leaves on a stick")
        (folder / "frame4.png").mkdir()
        assert brightness(Recording(folder)) == [1, 2, 3, 10, 20]

    def test_names_that_are_hard_to_sort(self, tmp_path):
        names = ["2.png", "10.png", "a01.png", "a1.PNG", "a.png", "B3.png", "b\u00b2.png"]
        for number, name in enumerate(names):
            save_image(tmp_path / name, picture(number))
        assert brightness(Recording(tmp_path)) == list(range(len(names)))

    def test_every_kind_of_picture_becomes_rgb(self, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "av", None)  # they need none
        rgb = Image.fromarray(picture(90))
        for name, mode in (("0.bmp", "RGB"), ("1.png", "RGBA"), ("2.tif", "CMYK"), ("3.png", "L")):
            rgb.convert(mode).save(tmp_path / name)
        rgb.quantize().save(tmp_path / "4.gif")
        *first, grey, indexed = Recording(tmp_path)
        for frame in (*first, indexed):
            np.testing.assert_allclose(frame.image, picture(90), atol=2)
        assert grey.image.shape == (24, 32, 3)
        np.testing.assert_array_equal(np.ptp(grey.image, axis=2), 0)

    def test_without_pictures(self, tmp_path):
        (tmp_path / "notes.txt").write_text("nothing")
        with pytest.raises(ValueError, match=str(tmp_path)):
            Recording(tmp_path)
        (tmp_path / "frames.mkv").touch()  # as the folder of a session has it
        with pytest.raises(ValueError, match=r"frames\.mkv"):
            Recording(tmp_path)


class TestPlaneMap:
    def test_by_default_the_frame_is_the_work_area(self, folder):
        recording = Recording(folder)
        assert recording.area == (32, 24)
        np.testing.assert_array_equal(recording.plane_map.matrix, np.eye(3))

    def test_as_given(self, folder):
        plane_map = PlaneMap(np.diag((10.0, 20.0, 1.0)))
        recording = Recording(folder, plane_map=plane_map)
        assert recording.area == (316, 470)  # (31.5 * 10, 23.5 * 20) + 0.5
        frame = next(iter(recording))
        np.testing.assert_array_equal(frame.plane_map.matrix, plane_map.matrix)
        assert Recording(folder, plane_map=plane_map, area=(99, 88)).area == (99, 88)

    @pytest.mark.parametrize(
        "matrix",
        [[(1, 0, 0), (0, 1, 0), (0, -0.1, 1)], [(1, 0, -100), (0, 1, 0), (0, 0, 1)]],
        ids=["horizon", "beside"],
    )
    def test_that_does_not_show_how_large_the_area_is(self, folder, matrix):
        plane_map = PlaneMap(matrix)
        with pytest.raises(ValueError, match="area"):
            Recording(folder, plane_map=plane_map)
        assert Recording(folder, plane_map=plane_map, area=(99, 88)).area == (99, 88)

    def test_through_a_lens(self, folder):
        camera = [[20, 0, 15.5], [0, 20, 11.5], [0, 0, 1]]
        lens = Intrinsics(camera, (0.4, 0, 0, 0, 0))
        plane_map = PlaneMap(np.diag([100, 100, 1]), lens)
        # It bends the sides outwards: most is seen in their middles.
        width, height = plane_map.to_world([(31.5, 11.5), (15.5, 23.5)]).max(axis=0) + 0.5
        assert plane_map.to_world((31.5, 23.5))[0] < width - 50
        area = Recording(folder, plane_map=plane_map).area
        np.testing.assert_allclose(area, (width, height), atol=1)
        folded = PlaneMap(plane_map.matrix, Intrinsics(camera, (-0.4, 0, 0, 0, 0)))
        with pytest.raises(ValueError, match="area"):
            Recording(folder, plane_map=folded)


class TestVideo:
    def test_gives_its_frames_in_rgb_again_and_again(self, video):
        recording = Recording(video)
        for _ in range(2):
            frames = list(recording)
            assert len(frames) == 8
            for number, frame in enumerate(frames):
                np.testing.assert_array_equal(frame.image, picture(number))
        assert (recording.count, recording.size) == (8, (32, 24))

    def test_has_the_time_from_its_rate(self, video):
        recording = Recording(video)
        assert recording.dt == pytest.approx(0.08)
        assert [frame.t for frame in recording] == pytest.approx(np.arange(8) * 0.08)
        assert [frame.index for frame in recording] == list(range(8))
        assert Recording(video, dt=0.5).dt == 0.5

    def test_with_a_rate_that_can_not_be(self, tmp_path):
        av = pytest.importorskip("av")
        file = tmp_path / "fast.avi"
        with av.open(str(file), "w") as container:
            stream = container.add_stream("mjpeg", rate=1000)
            stream.width, stream.height, stream.pix_fmt = 32, 24, "yuvj420p"
            for number in range(3):
                frame = av.VideoFrame.from_ndarray(picture(number), format="rgb24")
                container.mux(stream.encode(frame))
            container.mux(stream.encode(None))
        with pytest.raises(ValueError, match=r"fast\.avi .*0\.001"):
            Recording(file)
        assert [frame.t for frame in Recording(file, dt=0.1)] == pytest.approx([0, 0.1, 0.2])

    @pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="needs /proc")
    def test_is_closed_when_it_is_left(self, video):
        recording = Recording(video)

        def open_files():
            fds = Path("/proc/self/fd").iterdir()
            return [fd for fd in fds if os.path.lexists(fd) and os.readlink(fd) == str(video)]

        assert not open_files()
        frames = iter(recording)
        next(frames)
        assert open_files()
        frames.close()
        assert not open_files()
        for _ in recording:
            pass
        assert not open_files()

    def test_that_is_none(self, tmp_path, capfd):
        pytest.importorskip("av")
        file = tmp_path / "walk.mp4"
        for content in (b"", b"no video", b"\x00" * 5000):
            file.write_bytes(content)
            with pytest.raises(ValueError, match=r"walk\.mp4"):
                Recording(file)
        assert capfd.readouterr().err == ""

    @pytest.mark.long
    @pytest.mark.parametrize("ending", [".mp4", ".webm", ".mkv", ".avi"])
    def test_that_is_cut_off(self, tmp_path, ending, rng, capfd):
        pytest.importorskip("av")
        whole, half = tmp_path / f"whole{ending}", tmp_path / f"half{ending}"
        frames = rng.integers(0, 256, (10, 48, 64, 3), dtype=np.uint8)
        save_video(whole, frames, fps=5)
        for share in (0.5, 0.9):
            half.write_bytes(whole.read_bytes()[: int(share * whole.stat().st_size)])
            if ending == ".mp4":  # its table of contents comes last
                with pytest.raises(ValueError, match=r"half\.mp4"):
                    Recording(half)
            else:
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    count = len(list(Recording(half)))
                assert 0 < count <= 10
                told = [str(warning.message) for warning in caught]
                assert len(told) == 1
                assert f"{half} ends after" in told[0]
        assert capfd.readouterr().err == ""

    def test_without_pyav(self, video, monkeypatch):
        monkeypatch.setitem(sys.modules, "av", None)
        with pytest.raises(ImportError, match="PyAV"):
            Recording(video)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"gone\.mp4"):
        Recording(tmp_path / "gone.mp4")


def test_options_that_can_not_be(folder):
    for dt in (0, -1, np.nan, np.inf):
        with pytest.raises(ValueError, match="dt"):
            Recording(folder, dt=dt)
    with pytest.raises(ValueError, match="area"):
        Recording(folder, area=(0, 100))


class TestAnyOrder:
    """A panel shows frames again, as somebody scrubs."""

    @pytest.mark.parametrize("source", ["folder", "video"])
    def test_is_that_of_the_iteration(self, source, request):
        recording = Recording(request.getfixturevalue(source))
        frames = list(recording)
        for index in (3, 0, 4, 3):
            again = recording._at(index)
            assert np.array_equal(again.image, frames[index].image)
            assert (again.t, again.index) == (frames[index].t, index)
        with pytest.raises(IndexError):
            recording._at(len(frames))

    def test_of_a_file_with_few_key_frames(self, tmp_path):
        pytest.importorskip("av")
        save_video(tmp_path / "run.mp4", [picture(5 * number) for number in range(40)], fps=25)
        recording = Recording(tmp_path / "run.mp4")
        frames = list(recording)
        for index in (17, 3, 38):
            assert np.array_equal(recording._at(index).image, frames[index].image)
