"""What cameras send of an image: the formats of `to_rgb` the other way, as raw/from_rgb.cpp."""

import numpy as np

#: Pixels that share their chroma, and the order of the bytes.
_UNITS = {"yuv411": (4, "UYYVYY"), "yuv422": (2, "UYVY"), "yuyv": (2, "YUYV"), "yuv444": (1, "UYV")}
_HALF = 1 << 15  # weights are in units of 1/65536


def from_rgb(image, format_):
    """Return the bytes of an image (H, W, 3) of uint8; chroma is the mean of its pixels."""
    image = np.asarray(image, int)
    if format_ in ("rgb8", "bgr8"):
        return image[..., :: 1 if format_ == "rgb8" else -1].astype(np.uint8).tobytes()
    if format_.startswith("bayer_"):
        at = np.array(["rgb".index(letter) for letter in format_[6:]]).reshape(2, 2)
        height, width, _ = image.shape
        own = np.tile(at, (height // 2 + 1, width // 2 + 1))[:height, :width]
        return np.take_along_axis(image, own[..., None], 2).astype(np.uint8).tobytes()
    # ITU-R BT.601; JFIF 1.02
    luma = (image @ (19595, 38470, 7471) + _HALF) >> 16
    if format_.startswith("mono"):
        return np.repeat(luma, int(format_[4:]) // 8, axis=1).astype(np.uint8).tobytes()
    count, order = _UNITS[format_]
    height, width, _ = image.shape
    sums = image.reshape(height, width // count, count, 3).sum(axis=2)
    unit = count << 16
    u, v = (
        np.clip((sums @ weights + 128 * unit + unit // 2) // unit, 0, 255)
        for weights in ((-11059, -21709, 32768), (32768, -27439, -5329))
    )
    y = iter(np.moveaxis(luma.reshape(height, -1, count), 2, 0))
    columns = [{"U": u, "V": v}[letter] if letter != "Y" else next(y) for letter in order]
    return np.stack(columns, axis=2).astype(np.uint8).tobytes()
