"""Pictures of colour classes, with each pixel in the colour of its class."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import ImageColor

from robsim._core import Frame, rgb_to_yuv
from robsim.base.text import quoted
from robsim.vision.imaging.images import Pixels

Mask = NDArray[np.bool_]
_SEVERAL = (255, 255, 255)
# For class names other than the name of a colour.
_OTHERS = ((255, 0, 255), (0, 255, 255), (255, 160, 0), (160, 255, 0))


def paint_classes(image: Frame | Pixels, masks: dict[str, Mask]) -> Pixels:
    """Paint each pixel in the colour of its class.

    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB; pixels without a class are painted in dark grey, by their brightness.
    masks : dict of str to array (H, W) of bool
        As from `classify`. A class whose name is a colour is painted in that colour; pixels of
        several classes are white.

    Returns
    -------
    array (H, W, 3) of uint8
        The painted image, RGB.

    Raises
    ------
    TypeError
        If `masks` is not a dict.

    Examples
    --------
    >>> frame = robsim.Simulation(seed=1).step().frame
    >>> masks = robsim.vision.classify(frame, robsim.load_colors())
    >>> painted = robsim.vision.paint_classes(frame, masks)
    >>> int((painted != frame.image).any(axis=2).sum()) > 0
    True
    """
    if not isinstance(masks, dict):
        raise TypeError(
            f"masks must be a dict of str to bool array, as from classify, got {quoted(masks)}"
        )
    luma = rgb_to_yuv(image.image if isinstance(image, Frame) else image)[..., :1]
    painted = np.repeat(luma // 2, 3, axis=2)
    count = np.zeros(luma.shape[:2], dtype=int)
    for i, (name, mask) in enumerate(masks.items()):
        painted[mask] = paint_of(name, i)
        count += mask
    painted[count > 1] = _SEVERAL
    return painted


def paint_of(name: str, index: int) -> tuple[int, ...]:
    try:
        return ImageColor.getrgb(name)[:3]
    except ValueError:
        return _OTHERS[index % len(_OTHERS)]
