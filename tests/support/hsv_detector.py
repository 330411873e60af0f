"""What labs build from OpenCV instead: markers by hue and saturation, centroids of components."""

import numpy as np

from robsim.vision import Blob

SATURATION = 90  # at least, of 255
DARKEST = 15  # of 255: the hue of what is darker is noise
HUES = {"red": (170, 10), "blue": (100, 135)}  # of 180, from, to


def hsv_blobs(frame, markers):
    """The blobs of the markers' colours, as `find_blobs` gives them, the largest first."""
    import cv2

    width = markers.width_in(frame)
    window = 2 * int(np.clip(0.28 * width / 2, 1, 3)) + 1
    hsv = cv2.cvtColor(cv2.blur(frame.image, (window, window)), cv2.COLOR_RGB2HSV)
    hue, saturation, value = (hsv[..., i] for i in range(3))
    colored = (saturation >= SATURATION) & (value >= DARKEST)
    found = {}
    for color, (first, last) in HUES.items():
        wraps = first > last
        of_hue = (hue >= first) | (hue <= last) if wraps else (hue >= first) & (hue <= last)
        found[color] = _components(color, colored & of_hue, width**2 / 8)[: markers.maximum_blobs]
    return found


def _components(color, mask, smallest):
    import cv2

    _, _, stats, middles = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    blobs = []
    for (left, top, width, height, area), middle in zip(stats[1:], middles[1:], strict=True):
        if area >= smallest:
            box = (left, top, left + width - 1, top + height - 1)
            box = tuple(int(one) for one in box)
            blobs.append(Blob(color, area=int(area), centroid=middle, bounding_box=box))
    return sorted(blobs, key=lambda blob: -blob.area)
