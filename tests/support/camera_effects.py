"""What a camera makes of the light: blur, mosaic, noise, rounding, compression; in numpy.

Images are arrays (height, width, 3) of levels, not rounded before `photographed` does it.
"""

import numpy as np


def _blurred(image, sigma):
    reach = int(np.ceil(4 * sigma))
    bell = np.exp(-(np.arange(-reach, reach + 1) ** 2) / (2 * sigma**2))
    for _ in range(2):
        padded = np.pad(image, ((reach, reach), (0, 0), (0, 0)), mode="edge")
        rows = np.lib.stride_tricks.sliding_window_view(padded, len(bell), axis=0)
        image = (rows @ (bell / bell.sum())).transpose(1, 0, 2)
    return image


def _bayer_masks(height, width):
    """Where an RGGB sensor has R, G and B: array (3, height, width)."""
    row, column = np.mgrid[:height, :width] % 2
    return np.stack(((row == 0) & (column == 0), row != column, (row == 1) & (column == 1)))


def _demosaiced(raw):
    """RGB of a mosaic by bilinear interpolation: the mean of the neighbours that have a colour."""
    height, width = raw.shape
    result = []
    for mask in _bayer_masks(height, width):
        values, known = (np.pad(one, 1, mode="reflect") for one in (raw * mask, 1.0 * mask))
        sums, weights = np.zeros_like(raw), np.zeros_like(raw)
        for down in range(3):
            for right in range(3):
                weight = (2 - abs(down - 1)) * (2 - abs(right - 1))
                window = np.s_[down : down + height, right : right + width]
                sums += weight * values[window]
                weights += weight * known[window]
        result.append(np.where(mask, raw, sums / weights))
    return np.stack(result, axis=-1)


def _noisy(levels, case, rng):
    if case.gaussian:
        levels = levels + 2.55 * case.gaussian * rng.standard_normal(levels.shape)
    if case.uniform:
        levels = levels + 2.55 * case.uniform * rng.uniform(-1, 1, levels.shape)
    return np.clip(np.rint(levels), 0, 255)


def _compressed(image, quality):
    import cv2

    _, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    return np.ascontiguousarray(cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1])


def photographed(levels, case, rng):
    """What the camera makes of the light: array (height, width, 3) of uint8."""
    if case.blur:
        levels = _blurred(levels, case.blur)
    if case.bayer:
        masks = _bayer_masks(*levels.shape[:2])
        raw = _noisy((levels * masks.transpose(1, 2, 0)).sum(axis=-1), case, rng)
        levels = np.rint(_demosaiced(raw))
    else:
        levels = _noisy(levels, case, rng)
    image = np.ascontiguousarray(levels, np.uint8)
    return image if case.jpeg is None else _compressed(image, case.jpeg)
