"""Image files of all kinds, read as they are meant."""

import re
import zlib

import numpy as np
import pytest
from PIL import Image

from robsim.vision import load_image


@pytest.fixture
def pixels(rng):
    return rng.integers(0, 256, (6, 9, 3), dtype=np.uint8)


def test_a_lossless_picture_is_read_as_it_was_written(pixels, tmp_path):
    for kind in ("png", "bmp", "tiff", "webp"):
        Image.fromarray(pixels).save(tmp_path / f"a.{kind}", lossless=True)
        np.testing.assert_array_equal(load_image(tmp_path / f"a.{kind}"), pixels)


def test_a_photo_is_turned_as_its_camera_says(pixels, tmp_path):
    exif = Image.Exif()
    for orientation, turned in ((1, pixels), (3, pixels[::-1, ::-1]), (6, np.rot90(pixels, -1))):
        exif[0x0112] = orientation
        Image.fromarray(pixels).save(tmp_path / "photo.png", exif=exif)
        np.testing.assert_array_equal(load_image(tmp_path / "photo.png"), turned)


def test_sixteen_bits_become_eight(tmp_path):
    values = np.array([[0, 257, 128 * 257, 65535]], dtype=np.uint16)
    Image.fromarray(values).save(tmp_path / "deep.png")
    np.testing.assert_array_equal(load_image(tmp_path / "deep.png")[0, :, 0], [0, 1, 128, 255])


def test_transparency_is_kept_for_those_who_ask(pixels, tmp_path):
    rgba = np.dstack((pixels, pixels[:, :, 0]))
    Image.fromarray(rgba).save(tmp_path / "a.png")
    np.testing.assert_array_equal(load_image(tmp_path / "a.png", mode="RGBA"), rgba)


def test_a_wrong_file_is_named(pixels, tmp_path):
    (tmp_path / "text.png").write_text("hello")
    Image.fromarray(pixels).save(tmp_path / "cut.png")
    (tmp_path / "cut.png").write_bytes((tmp_path / "cut.png").read_bytes()[:-60])
    Image.fromarray(np.zeros((2, 2), np.float32)).save(tmp_path / "f.tiff")
    for name in ("text.png", "cut.png", "f.tiff"):
        with pytest.raises(ValueError, match=re.escape(name)):
            load_image(tmp_path / name)
    with pytest.raises(FileNotFoundError):
        load_image(tmp_path / "none.png")


@pytest.mark.parametrize("side", [10_000, 100_000])
def test_a_small_file_that_claims_to_be_huge_is_refused(tmp_path, side):
    file = tmp_path / "bomb.png"
    Image.new("1", (8, 8)).save(file)
    data = bytearray(file.read_bytes())
    data[16:24] = side.to_bytes(4, "big") * 2
    data[29:33] = zlib.crc32(bytes(data[12:29])).to_bytes(4, "big")
    file.write_bytes(data)
    with pytest.raises(ValueError, match=r"bomb\.png has too many pixels: .*100000000"):
        load_image(file)
