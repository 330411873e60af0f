"""Short animations of frames for notebooks; `robsim.play` returns one."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Iterable, Iterator
from os import PathLike

from PIL import Image, ImageSequence

from robsim._core import Frame
from robsim.base.checks import check_float, check_int
from robsim.base.files import as_path, write_whole
from robsim.base.text import one_line
from robsim.vision.imaging.images import (
    Pixels,
    check_iterable,
    check_same_size,
    frame_pixels,
    frame_size,
    resized,
)

MAXIMUM_WIDTH = 16383  # px, a limit of WebP
QUALITY = 75  # of WebP, 0..100: 100 noisy frames, 480 px wide, take 1 MB
EFFORT = 2  # of WebP, 0..6: more takes seconds longer and saves little


class Clip:
    """Frames as an animation that plays in a notebook, also in a saved notebook.

    Parameters
    ----------
    frames : iterable of Frame or array (H, W, 3) of uint8
        The frames, all of one size.
    fps : float
        Frames per second, within 0.1..60.
    width : int
        Width of the clip (px), within 1..16383. Narrower frames are not enlarged.

    Raises
    ------
    TypeError, ValueError
        If there are no frames, or `fps` or `width` is out of range. If a frame has the wrong type
        or shape, or another size than the first.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1)
    >>> robsim.vision.Clip((sim.step().frame for _ in range(10)), fps=5)
    <Clip: 10 frames of 480 x 480 px, ... kB>
    """

    def __init__(self, frames: Iterable[Frame | Pixels], *, fps: float, width: int = 480) -> None:
        milliseconds = round(1000 / check_float("fps", fps, "1/s", minimum=0.1, maximum=60))
        width = check_int("width", width, minimum=1, maximum=MAXIMUM_WIDTH)
        check_iterable(frames)
        images = list(_reduced(frames, width))
        if not images:
            raise ValueError("frames must have at least one frame for a clip, got none")
        self._count = len(images)
        self._size = images[0].size
        self._webp = _animation("WEBP", images, milliseconds)
        self._milliseconds = milliseconds

    def save(self, path: str | PathLike[str]) -> None:
        """Write the clip to a file.

        Parameters
        ----------
        path : path
            File name with the suffix ``.webp`` or ``.gif``; a GIF is larger and has fewer colours.

        Raises
        ------
        TypeError, ValueError
            If `path` is not a path, or has another suffix.
        """
        file = as_path(path)
        suffix = file.suffix.lower()
        if suffix not in (".webp", ".gif"):
            raise ValueError(f"{one_line(path)}: the name of a clip must end in .webp or .gif")
        write_whole(file, self._webp if suffix == ".webp" else self._gif())

    def _gif(self) -> bytes:
        with Image.open(io.BytesIO(self._webp)) as clip:
            shown = [(p.convert("RGB"), p.info["duration"]) for p in ImageSequence.Iterator(clip)]
        # WebP merges equal consecutive frames into one of the total duration.
        images, durations = zip(*shown, strict=True)
        return _animation("GIF", list(images), list(durations))

    def _repr_html_(self) -> str:
        width, height = self._size
        data = base64.b64encode(self._webp).decode("ascii")
        return (
            f'<img src="data:image/webp;base64,{data}" width="{width}" height="{height}" '
            f'alt="a clip of {self._count} frames">'
        )

    def __len__(self) -> int:
        return self._count

    def __repr__(self) -> str:
        width, height = self._size
        kilobytes = math.ceil(len(self._webp) / 1000)
        return f"<Clip: {self._count} frames of {width} x {height} px, {kilobytes} kB>"


def _reduced(frames: Iterable[Frame | Pixels], width: int) -> Iterator[Image.Image]:
    first = None
    for index, frame in enumerate(frames):
        pixels = frame_pixels(f"frames[{index}]", frame)
        size = frame_size(pixels)
        first = first or size
        check_same_size(f"frame {index}", size, first)
        scale = min(1.0, width / size[0])
        yield Image.fromarray(
            resized(pixels, round(scale * size[0]), max(1, round(scale * size[1])))
        )


def _animation(kind: str, images: list[Image.Image], milliseconds: int | list[int]) -> bytes:
    buffer = io.BytesIO()
    images[0].save(
        buffer,
        format=kind,
        save_all=True,
        append_images=images[1:],
        duration=milliseconds,
        loop=0,
        quality=QUALITY,
        method=EFFORT,
    )
    return buffer.getvalue()
