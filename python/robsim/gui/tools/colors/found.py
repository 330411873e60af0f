"""What colour classes find in a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim._core import ColorClass, Frame, MarkerLayout, PlaneMap, classify, detect, find_blobs
from robsim.gui._frames import boxes_of, numbers
from robsim.vision.markers.color_files import paint_of

_LARGEST = 1600  # px along a side of a mask


def found_in(frame: Frame, colors: Sequence[ColorClass], markers: MarkerLayout) -> dict[str, Any]:
    """Return the boxes of the blobs, the pose of the robot, or why it was not found at once."""
    blobs = find_blobs(frame, list(colors), markers=markers)
    found = detect(blobs, markers, plane_map=frame.plane_map, image=frame, colors=list(colors))
    pose = None if found.measurement is None else numbers(found.measurement.pose)
    missed = found.explanation if found.by_second_chance or pose is None else None
    return {"boxes": boxes_of(blobs), "found": pose, "missed": missed}


def painted(
    frame: Frame, colors: Sequence[ColorClass], markers: MarkerLayout
) -> tuple[NDArray[np.uint8], list[tuple[int, ...]]]:
    """Return which pixel belongs to which class, from 1, and the RGB of each class.

    Of a large picture it has each second pixel, or each third, and so on.
    """
    step = -(-max(frame.image.shape[:2]) // _LARGEST)
    if step > 1:
        to_area = frame.plane_map.matrix @ np.diag((step, step, 1.0))
        pixels = np.ascontiguousarray(frame.image[::step, ::step])
        frame = Frame(pixels, plane_map=PlaneMap(to_area))
    masks = classify(frame, list(colors), markers=markers)  # as where blobs are found
    index = np.zeros(frame.image.shape[:2], np.uint8)
    for number, mask in enumerate(masks.values(), start=1):
        index[mask] = number
    inks = [paint_of(name, number) for number, name in enumerate(masks)]
    return index, inks
