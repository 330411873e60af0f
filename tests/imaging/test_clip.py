import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

from refusals import refuses
from robsim.vision import Clip


def frames(count=6, *, width=60, height=40):
    """Frames with a bright square that moves to the right."""
    for number in range(count):
        pixels = np.full((height, width, 3), 60, dtype=np.uint8)
        pixels[10:30, 5 * number : 5 * number + 20] = (255, 200, 0)
        yield pixels


def opened(clip):
    """The picture in a clip's HTML."""
    data = re.search(r'src="data:image/webp;base64,([^"]+)"', clip._repr_html_())[1]
    return Image.open(io.BytesIO(base64.b64decode(data)))


def test_plays_all_frames_at_the_rate_for_ever():
    clip = Clip(frames(), fps=5)
    assert len(clip) == 6
    with opened(clip) as picture:
        assert (picture.format, picture.n_frames, picture.info["loop"]) == ("WEBP", 6, 0)
        for number, wanted in enumerate(frames()):
            picture.seek(number)
            picture.load()
            assert picture.info["duration"] == 200
            error = np.abs(np.asarray(picture.convert("RGB"), dtype=float) - wanted)
            assert error.mean() < 10


def test_is_reduced_to_a_width_but_never_enlarged():
    for width, size in ((30, (30, 20)), (25, (25, 17)), (1, (1, 1)), (480, (60, 40))):
        clip = Clip(frames(1), fps=5, width=width)
        with opened(clip) as picture:
            assert (picture.size, picture.n_frames) == (size, 1)
        assert f'width="{size[0]}" height="{size[1]}"' in clip._repr_html_()


@pytest.mark.parametrize("ending", [".webp", ".GIF"])
def test_save(tmp_path, ending):
    path = tmp_path / f"clip{ending}"
    Clip(frames(), fps=5).save(path)
    with Image.open(path) as picture:
        assert picture.format == ending[1:].upper()
        assert picture.n_frames == 6
        picture.seek(5)
        last = np.asarray(picture.convert("RGB"), dtype=float)
        assert picture.info["duration"] == 200
        assert picture.info["loop"] == 0
    *_, wanted = frames()
    assert np.abs(last - wanted).mean() < 15


def test_what_is_no_clip(tmp_path):
    some = list(frames())
    refuses("frames", Clip, [], fps=5)
    refuses("frames", Clip, [1, 2], fps=5)
    said = refuses("frame", Clip, [*some, np.zeros((40, 50, 3), np.uint8)], fps=5)
    assert "frame 6 has 50 x 40 px" in said
    for fps in (0, 0.09, 61, np.nan):
        refuses("fps", Clip, some, fps=fps)
    for width in (0, 16384, True):
        refuses("width", Clip, some, fps=5, width=width)
    for name in ("clip.mp4", "clip"):
        with pytest.raises(ValueError, match=r"\.webp"):
            Clip(some, fps=5).save(tmp_path / name)


def test_a_gif_keeps_the_time_of_frames_that_come_twice(tmp_path):
    a, b = (np.full((20, 20, 3), value, np.uint8) for value in (50, 200))
    Clip([a, a, a, b], fps=5).save(tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as gif:
        times = []
        for frame in range(gif.n_frames):
            gif.seek(frame)
            times.append(gif.info["duration"])
    assert times == [600, 200]
