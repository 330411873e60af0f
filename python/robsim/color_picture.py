"""Pictures of colour classes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from PIL import ImageColor

from robsim._core import ColorClass, Frame, rgb_to_yuv
from robsim.pictures import Pixels

Mask = NDArray[np.bool_]

_SEVERAL = (255, 255, 255)
_OTHERS = ((255, 0, 255), (0, 255, 255), (255, 160, 0), (160, 255, 0))  # for names of no colour


def class_masks(
    image: Frame | Pixels, colors: Iterable[ColorClass], *, smoothing: int = 1
) -> dict[str, Mask]:
    """Return which pixels belong to which colour class.

    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB.
    colors : iterable of ColorClass
        The colours.
    smoothing : int
        A pixel is judged by the mean of the window around it, so many px wide, as in `find_blobs`.

    Returns
    -------
    dict of str to array (H, W) of bool
        A mask for each colour.
    """
    yuv = rgb_to_yuv(image.image if isinstance(image, Frame) else image).astype(np.int64)
    if smoothing > 1:
        yuv = _window_sums(yuv, smoothing) // smoothing**2
    masks = {}
    for color in colors:
        lower, upper = np.array((color.y, color.u, color.v)).T
        masks[color.name] = ((yuv >= lower) & (yuv <= upper)).all(axis=2)
    return masks


def _window_sums(values: NDArray[np.int64], window: int) -> NDArray[np.int64]:
    """Return the sum over the window around each pixel; beyond the border its pixels go on."""
    reach = window // 2
    padded = np.pad(values, ((reach + 1, reach), (reach + 1, reach), (0, 0)), "edge")
    padded[0], padded[:, 0] = 0, 0
    total = padded.cumsum(axis=0).cumsum(axis=1)
    rows = total[window:] - total[:-window]
    sums: NDArray[np.int64] = rows[:, window:] - rows[:, :-window]
    return sums


def paint_classes(image: Frame | Pixels, masks: dict[str, Mask]) -> Pixels:
    """Paint which pixel belongs to which colour class.

    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB; what belongs to no class is shown in a dark grey.
    masks : dict of str to array (H, W) of bool
        As from `class_masks`. A class whose name is a colour is painted in it; what belongs to
        several, white.

    Returns
    -------
    array (H, W, 3) of uint8
        The picture.
    """
    luma = rgb_to_yuv(image.image if isinstance(image, Frame) else image)[..., :1]
    painted = np.repeat(luma // 2, 3, axis=2)
    count = np.zeros(luma.shape[:2], dtype=int)
    for i, (name, mask) in enumerate(masks.items()):
        painted[mask] = _paint(name, i)
        count += mask
    painted[count > 1] = _SEVERAL
    return painted


def _paint(name: str, index: int) -> tuple[int, ...]:
    try:
        return ImageColor.getrgb(name)[:3]
    except ValueError:
        return _OTHERS[index % len(_OTHERS)]
