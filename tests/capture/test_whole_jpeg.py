"""Which JPEG images are whole, of every coding that cameras have."""

import io

import numpy as np
import pytest
from PIL import Image

from robsim._core import is_whole_jpeg

CODINGS = {
    "4:2:0": {},
    "4:2:2": {"subsampling": 1},
    "4:4:4": {"subsampling": 0},
    "progressive": {"progressive": True},
    "own tables": {"optimize": True},
    "restart markers": {"restart_marker_blocks": 3},
    "restart markers in 4:4:4": {"restart_marker_rows": 1, "subsampling": 0},
}


def coded(rng, mode, **coding):
    width, height = map(int, rng.integers(1, 120, 2))
    pixels = rng.integers(0, 256, (height, width, 3), dtype=np.uint8)
    data = io.BytesIO()
    quality = int(rng.integers(30, 98))
    Image.fromarray(pixels).convert(mode).save(data, "JPEG", quality=quality, **coding)
    return data.getvalue()


@pytest.mark.long
@pytest.mark.parametrize("coding", CODINGS)
def test_whole_ones_are_known_and_cut_ones_refused(rng, coding):
    for mode in ("RGB", "L") * 8:
        data = coded(rng, mode, **CODINGS[coding])
        assert is_whole_jpeg(data)
        assert is_whole_jpeg(data + bytes(7))  # some cameras fill up
        for cut in rng.integers(0, len(data) - 2, 8):
            assert not is_whole_jpeg(data[:cut])
            if coding != "progressive":
                assert not is_whole_jpeg(data[:cut] + b"\xff\xd9")
                assert not is_whole_jpeg(data[: max(cut, 700)] + data) or cut < 700


def test_any_bytes_are_looked_at_without_harm(rng):
    for _ in range(4):
        whole = coded(rng, "RGB")
        for _ in range(100):
            data = bytearray(whole)
            for place in rng.integers(2, len(data), 5):
                data[place] = rng.integers(256)
            is_whole_jpeg(bytes(data))
            is_whole_jpeg(b"\xff\xd8" + rng.bytes(200))
