"""Images: files, arrays, smaller copies."""

import re
import tracemalloc
import warnings
import zlib

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from PIL import Image

import robsim
from refusals import IMAGE, refuses
from robsim import Frame, _core, find_blobs
from robsim.vision import load_image, rgb_to_yuv
from robsim.vision.imaging import images

# --- files


@pytest.fixture
def pixels(rng):
    return rng.integers(0, 256, (6, 9, 3), dtype=np.uint8)


@pytest.fixture(autouse=True, params=[512, 4])
def _tile(request, monkeypatch):
    monkeypatch.setattr("robsim.vision.imaging.images._TILE", request.param)


def test_a_large_picture_is_copied_once(tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.vision.imaging.images._TILE", 512)
    Image.new("RGB", (2000, 1500)).save(tmp_path / "a.png")
    tracemalloc.start()
    try:
        pixels = load_image(tmp_path / "a.png")
        assert tracemalloc.get_traced_memory()[1] < 1.5 * pixels.nbytes
    finally:
        tracemalloc.stop()


def test_a_lossless_picture_is_read_as_it_was_written(pixels, tmp_path):
    for kind in ("png", "bmp", "tiff", "webp"):
        Image.fromarray(pixels).save(tmp_path / f"a.{kind}", lossless=True)
        np.testing.assert_array_equal(load_image(tmp_path / f"a.{kind}"), pixels)


@pytest.mark.parametrize("orientation", [3, 6])
def test_a_photo_is_read_as_it_lies_on_the_sensor(pixels, tmp_path, orientation):
    exif = Image.Exif()
    exif[0x0112] = orientation
    Image.fromarray(pixels).save(tmp_path / "photo.png", exif=exif)
    images.tell_of_turn.cache_clear()
    with pytest.raises(UserWarning, match="EXIF"):  # as all warnings here
        load_image(tmp_path / "photo.png")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        np.testing.assert_array_equal(load_image(tmp_path / "photo.png"), pixels)


@pytest.mark.parametrize("channels", [1, 3])
def test_twelve_bits_in_sixteen_are_noticed(tmp_path, channels):
    cv2 = pytest.importorskip("cv2")
    values = np.tile(np.linspace(0, 4095, 64).astype(np.uint16), (8, 1))
    cv2.imwrite(str(tmp_path / "deep.png"), np.dstack([values] * channels))
    with pytest.raises(UserWarning, match=r"deep\.png is nearly black"):
        load_image(tmp_path / "deep.png")
    cv2.imwrite(str(tmp_path / "deep.png"), np.dstack([values * 16] * channels))
    assert load_image(tmp_path / "deep.png").max() >= 254


def test_a_photo_that_phones_take_is_to_be_exported(tmp_path):
    (tmp_path / "IMG_1.HEIC").write_bytes(b"\0\0\0\x24ftypheic\0\0\0\0mif1heic")
    for read in (load_image, robsim.Recording):
        with pytest.raises(ValueError, match=r"IMG_1\.HEIC .* export it as JPEG"):
            read(tmp_path / ("IMG_1.HEIC" if read is load_image else ""))


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


def raising(error):
    def call(*_):
        raise error

    return call


def test_a_picture_for_which_there_is_no_memory_is_named(pixels, tmp_path, monkeypatch):
    Image.fromarray(pixels).save(tmp_path / "large.png")
    monkeypatch.setattr(Image.Image, "convert", raising(MemoryError))
    with pytest.raises(ValueError, match=r"large\.png .* memory"):
        load_image(tmp_path / "large.png")


@pytest.mark.parametrize("side", [10_000, 100_000])
def test_a_small_file_that_claims_to_be_huge_is_refused(tmp_path, side):
    file = tmp_path / "bomb.png"
    Image.new("1", (8, 8)).save(file)
    data = bytearray(file.read_bytes())
    data[16:24] = side.to_bytes(4, "big") * 2
    data[29:33] = zlib.crc32(bytes(data[12:29])).to_bytes(4, "big")
    file.write_bytes(data)
    with pytest.raises(ValueError, match=r"bomb\.png has too many pixels: at most 67108864"):
        load_image(file)


# --- arrays


COLORS = robsim.load_colors()
IMAGE_TAKERS = {
    "find_blobs": lambda image: find_blobs(image, COLORS),
    "rgb_to_yuv": rgb_to_yuv,
    "Frame": Frame,
    "UniformNoise.add": lambda image: robsim.UniformNoise(5).add(image, 1),
}
takes_images = pytest.mark.parametrize("take", IMAGE_TAKERS.values(), ids=IMAGE_TAKERS)


@pytest.mark.long
@takes_images
@settings(max_examples=40)
@given(shape=npst.array_shapes(min_dims=0, max_dims=5, min_side=0, max_side=9))
def test_images_of_any_shape(take, shape):
    image = np.zeros(shape, np.uint8)
    if len(shape) == 3 and shape[2] == 3 and image.size:
        take(image)
    else:
        refuses("image", take, image)


STEPS = st.sampled_from([-3, -2, -1, 1, 2, 3])


@pytest.mark.long
@takes_images
@settings(max_examples=40)
@given(rows=STEPS, columns=STEPS, channels=STEPS, fortran=st.booleans())
def test_images_of_any_stride(take, rows, columns, channels, fortran):
    whole = np.zeros((12, 12, 9), np.uint8, order="F" if fortran else "C")
    view = whole[::rows, ::columns, ::channels][:, :, :3]
    assume(view.shape[2] == 3)
    if view.strides[1:] == (3, 1):
        take(view)
    else:
        assert "ascontiguousarray(image)" in refuses("image", take, view)


def test_limits_of_a_frame():
    assert Frame(IMAGE, index=0).index == 0
    refuses("index", Frame, IMAGE, index=-1)
    refuses("t", Frame, IMAGE, t=np.nan)
    assert find_blobs(Frame(IMAGE), COLORS) == {"red": [], "blue": []}
    refuses("image", rgb_to_yuv, Frame(IMAGE))
    refuses("image", Frame, Frame(IMAGE))


# --- rows anywhere in memory


def blobs_in(image, **options):
    found = find_blobs(image, COLORS, minimum_area=1, **options)
    return {
        color: [(b.area, *b.centroid, b.bounding_box, b.at_border) for b in blobs]
        for color, blobs in found.items()
    }


VIEWS = {
    "every third row from below": lambda image: image[::-3],
    "a part": lambda image: image[1:-2, 1:-1],
    "one column": lambda image: image[:, 3:4],
    "one pixel": lambda image: image[2:3, 3:4],
    "a row, repeated": lambda image: np.broadcast_to(image[:1], image.shape),
    "read-only": lambda image: np.frombuffer(image.tobytes(), np.uint8).reshape(image.shape),
}


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@settings(max_examples=10)
@given(width=st.integers(5, 41), height=st.integers(5, 20), seed=st.integers(0, 2**32))
def test_rows_may_lie_anywhere_in_memory(view, width, height, seed):
    palette = np.array([[220, 30, 30], [30, 60, 220], [100, 100, 100]], np.uint8)
    image = palette[np.random.default_rng(seed).integers(0, 3, (height, width))]
    seen = view(image)
    copy = np.array(seen, order="C")
    assert blobs_in(seen) == blobs_in(copy)
    np.testing.assert_array_equal(rgb_to_yuv(seen), rgb_to_yuv(copy))
    np.testing.assert_array_equal(Frame(seen).image, copy)
    noise = robsim.GaussianNoise(20)
    np.testing.assert_array_equal(noise.add(seen, 1), noise.add(copy, 1))


# --- smaller copies


def means_of_blocks(image, factor):
    height, width = (side // factor for side in image.shape[:2])
    blocks = image[: height * factor, : width * factor].astype(int)
    sums = blocks.reshape(height, factor, width, factor, 3).sum((1, 3))
    return (sums + factor**2 // 2) // factor**2


def test_a_pixel_is_the_mean_of_its_block(rng):
    for size, width, factor in (
        *(((8, 8), 4, 2), ((6, 6), 2, 3), ((9, 13), 6, 2)),
        *(((41, 43), 10, 4), ((7, 6), 5, 1)),
    ):
        image = rng.integers(0, 256, (*size, 3), dtype=np.uint8)
        smaller = _core.reduced(robsim.Frame(image), width)
        np.testing.assert_array_equal(smaller, means_of_blocks(image, factor))
    part = rng.integers(0, 256, (12, 20, 3), dtype=np.uint8)[:, 4:16]
    smaller = _core.reduced(robsim.Frame(part, copy=False), 6)
    np.testing.assert_array_equal(smaller, means_of_blocks(part, 2))


def test_a_width_of_nothing_is_refused():
    with pytest.raises(ValueError, match="width"):
        _core.reduced(robsim.Frame(np.zeros((4, 4, 3), np.uint8)), 0)


def test_large_factors_go_in_steps_and_never_below_the_width():
    image = np.full((1600, 2000, 3), 255, np.uint8)
    smaller = _core.reduced(robsim.Frame(image), 230)
    assert smaller.shape == (200, 250, 3)
    assert (smaller == 255).all()
