"""One bad picture is one bad picture."""

import warnings
from fractions import Fraction

import numpy as np
import pytest

import robsim
from robsim.vision import save_image, save_video

RATE = [Fraction(k, 25) for k in range(40)]


def read(source):
    """Return the frames of a recording, and the warnings of reading them."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        frames = list(robsim.Recording(source))
    return frames, [str(one.message) for one in caught]


@pytest.fixture
def folder(tmp_path):
    for k in range(8):
        save_image(tmp_path / f"frame{k}.png", np.full((24, 32, 3), 10 * k, np.uint8))
    return tmp_path


def truncate(file):
    file.write_bytes(file.read_bytes()[:60])


def empty(file):
    file.write_bytes(b"")


def resize(file):
    save_image(file, np.zeros((30, 32, 3), np.uint8))


@pytest.mark.parametrize("damage", [truncate, empty, resize])
@pytest.mark.parametrize("k", [0, 3])
def test_a_picture_of_a_folder(folder, damage, k):
    damage(folder / f"frame{k}.png")
    if damage is resize and k == 0:
        k = 1  # the first one has the size that counts
        for other in range(2, 8):
            resize(folder / f"frame{other}.png")
    frames, told = read(folder)
    assert [frame.index for frame in frames] == [i for i in range(8) if i != k]
    (text,) = told
    assert f"frame{k}.png" in text
    assert "1 of 8" in text


def test_it_is_a_step_without_a_frame(folder):
    truncate(folder / "frame3.png")
    experiment = robsim.Experiment(robsim.Recording(folder), measure=None)
    with pytest.warns(UserWarning, match="1 of 8"):
        steps = [experiment.step() for _ in range(8)] and experiment.run()
    assert len(steps) == 8
    experiment = robsim.Experiment(robsim.Recording(folder), measure=None)
    seen = [experiment.step().frame for _ in range(8)]
    assert [frame and frame.index for frame in seen] == [0, 1, 2, None, 4, 5, 6, 7]
    assert experiment._source.again(3) is None
    assert experiment._source.again(4).index == 4


def test_no_picture_is_left(tmp_path):
    for k in range(3):
        (tmp_path / f"{k}.png").write_bytes(b"no picture")
    with pytest.raises(ValueError, match="no frames"):
        robsim.Recording(tmp_path)


@pytest.mark.parametrize("ending", [".mkv", ".avi"])
def test_a_frame_of_a_video_of_robsim(tmp_path, rng, ending):
    pictures = rng.integers(0, 256, (10, 48, 64, 3), dtype=np.uint8)
    file = tmp_path / f"run{ending}"
    save_video(file, pictures, fps=5)
    content = bytearray(file.read_bytes())
    middle = len(content) // 2 + 1000
    content[middle : middle + 100] = rng.bytes(100)
    file.write_bytes(content)
    frames, told = read(file)
    assert len(frames) == 9
    for frame in frames:
        np.testing.assert_array_equal(frame.image, pictures[frame.index])
        assert frame.t == pytest.approx(frame.index / 5)
    (text,) = told
    (lost,) = {*range(10)} - {frame.index for frame in frames}
    assert "1 of 10" in text
    assert f"frame {lost} " in text
    with pytest.raises(ValueError, match=f"frame {lost} "):
        robsim.Recording(file)._at(lost)


def test_a_key_frame_takes_what_depends_on_it_with_it(tmp_path, rng):
    av = pytest.importorskip("av")
    from numbered_videos import number_in, write_numbered

    file = tmp_path / "run.mp4"
    write_numbered(file, RATE, "mpeg4", tick=Fraction(1, 25), b="8M")
    with av.open(str(file)) as container:
        packets = [one for one in container.demux(video=0) if one.size]
    key, following = [k for k, one in enumerate(packets) if one.is_keyframe][1:3]
    content = bytearray(file.read_bytes())
    start, end = packets[key].pos, packets[key].pos + packets[key].size
    content[start + 20 : end] = rng.bytes(end - start - 20)
    file.write_bytes(content)
    frames, told = read(file)
    assert [frame.index for frame in frames] == [*range(key), *range(following, 40)]
    assert [number_in(frame.image) for frame in frames] == [frame.index for frame in frames]
    assert f"{following - key} of 40" in told[0]
