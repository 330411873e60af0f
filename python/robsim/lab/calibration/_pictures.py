"""Pictures as a user gives them, all of one size, and their names."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from robsim._core import Frame
from robsim.base.checks import check_text
from robsim.base.text import quoted
from robsim.vision.imaging.frames import frame_size
from robsim.vision.imaging.images import Pixels, check_pixels


def images_of(pictures: Any, names: Sequence[str] | None = None) -> Iterator[Pixels]:
    """Yield the pixels of pictures of one size, one at least; raise TypeError or ValueError."""
    is_single = isinstance(pictures, (Frame, str, bytes, dict)) or (
        isinstance(pictures, np.ndarray) and pictures.ndim < 4
    )
    if is_single or not isinstance(pictures, Iterable):
        raise TypeError(f"pictures must be several, such as a list, got {quoted(pictures)}")
    size = None
    for number, picture in enumerate(pictures):
        given = picture.image if isinstance(picture, Frame) else picture
        image = check_pixels("pictures", given, 3, "Frame objects, or each ")
        found = frame_size(image)
        if size is not None and found != size:
            named = names is not None and number < len(names)
            which = names[number] if names and named else f"the one with number {number + 1}"
            raise ValueError(
                f"pictures must have one size, got {size[0]} x {size[1]} px and {found[0]} x "
                f"{found[1]} px ({which})"
            )
        size = found
        yield image
    if size is None:
        raise ValueError("pictures must not be empty")


def pixels_of(name: str, picture: Any) -> Pixels:
    """Return the pixels of one picture; raise TypeError or ValueError."""
    given = picture.image if isinstance(picture, Frame) else picture
    return check_pixels(name, given, 3, "a Frame or ")


def checked_names(names: Any) -> Sequence[str] | None:
    """Return names, a sequence of texts, or None."""
    if names is None:
        return None
    if isinstance(names, (str, bytes)) or not isinstance(names, (Sequence, np.ndarray)):
        raise TypeError(f"names must be a sequence of texts, got {quoted(names)}")
    return [check_text("names", name) for name in names]
