"""Videos whose pictures carry their numbers, at times that are known."""

from fractions import Fraction

import av
import numpy as np

SIZE = (160, 96)  # px


def numbered(k):
    """A picture with the eight bits of a number as blocks, and a moving bar."""
    pixels = np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
    for bit in range(8):
        pixels[16:48, 4 + 19 * bit : 18 + 19 * bit] = 230 if k >> bit & 1 else 20
    pixels[60:80, 2 * k % 100 : 2 * k % 100 + 40] = (220, 40, 40)
    return pixels


def number_in(pixels):
    return sum(
        (pixels[24:40, 8 + 19 * bit : 14 + 19 * bit].mean() > 125) << bit for bit in range(8)
    )


def write_numbered(
    path, times, codec, *, pixels="yuv420p", tick=Fraction(1, 1000), b_frames=0, flags=0, **options
):
    """Write picture k at times[k] (s, Fraction); `flags` are of the codec, options of FFmpeg."""
    rate = 1 / tick if tick > Fraction(1, 200) else 25
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=rate, options=options)
        stream.width, stream.height = SIZE
        stream.pix_fmt = pixels
        stream.time_base = stream.codec_context.time_base = tick
        stream.codec_context.gop_size = 12
        stream.codec_context.max_b_frames = b_frames
        stream.codec_context.flags |= flags
        for k, t in enumerate(times):
            frame = av.VideoFrame.from_ndarray(numbered(k), format="rgb24")
            frame.pts, frame.time_base = round(t / tick), tick
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
