import itertools
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robsim
from refusals import Refusal, options, refusals
from robsim import ColorClass, load_colors
from robsim.vision import rgb_to_yuv
from robsim.vision._color_files import as_colors

CHANNELS = ("y", "u", "v")


def ranges(color):
    return {channel: getattr(color, channel) for channel in CHANNELS}


def yuv_formula(image):
    red, green, blue = np.moveaxis(image.astype(int), -1, 0)
    y = (38 * red + 75 * green + 15 * blue) >> 7
    u = 128 + ((-22 * red - 42 * green + 64 * blue) >> 7)
    v = 128 + ((64 * red - 54 * green - 10 * blue) >> 7)
    return np.stack((y, u, v), axis=-1)


@pytest.fixture
def color_file(tmp_path):
    def write(content):
        path = tmp_path / "colors.toml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


# --- files


def test_the_shipped_colors_are_red_and_blue():
    red, blue = load_colors()
    assert (red.name, blue.name) == ("red", "blue")
    assert ranges(red) == {"y": (0, 255), "u": (0, 150), "v": (154, 255)}
    assert ranges(blue) == {"y": (0, 255), "u": (154, 255), "v": (0, 140)}


@pytest.mark.parametrize(
    ("rgb", "name"),
    [
        *((rgb, "red") for rgb in ((198, 36, 40), (255, 0, 0))),
        *((rgb, "blue") for rgb in ((0, 0, 255), (30, 60, 220))),
        *((rgb, None) for rgb in ((255, 255, 255), (0, 0, 0), (128, 128, 128))),
        *((rgb, None) for rgb in ((0, 255, 0), (255, 255, 0), (255, 0, 255))),
    ],
)
def test_the_shipped_colors_catch_what_they_should(rgb, name):
    image = np.full((8, 8, 3), rgb, np.uint8)
    blobs = robsim.find_blobs(image, load_colors())
    assert [color for color, found in blobs.items() if found] == ([name] if name else [])


def test_a_correct_file(color_file):
    path = color_file("[b]\ny = [1, 2]\nu = [3, 4]\nv = [5, 5]\n\n[a]\nv = [0, 255]\n[c]\n")
    b, a, c = load_colors(path)
    assert (b.name, a.name, c.name) == ("b", "a", "c")
    assert ranges(b) == {"y": (1, 2), "u": (3, 4), "v": (5, 5)}
    assert ranges(a) == ranges(c) == dict.fromkeys(CHANNELS, (0, 255))
    assert [color.name for color in load_colors(str(path))] == ["b", "a", "c"]


def test_windows_line_ends_and_other_letters(color_file):
    (color,) = load_colors(color_file("# Grün\r\n['grün hell']\r\ny = [1, 2]\r\n"))
    assert (color.name, color.y) == ("grün hell", (1, 2))


def test_a_byte_order_mark(color_file):
    (color,) = load_colors(color_file(b"\xef\xbb\xbf[red]\n"))
    assert color.name == "red"


@pytest.mark.parametrize(
    ("content", "key"),
    [
        *((text, "no colours") for text in ("", "# nothing\n")),
        *((text, "red") for text in ("red = 1", "red = [0, 255]", "[[red]]")),
        *((f"[red]\ny = {value}", "y") for value in ("1", "'ab'", "[2, 1]")),
        *((f"[red]\nu = {value}", "u") for value in ("[1]", "[]", "[-1, 1]")),
        *((f"[red]\nv = {value}", "v") for value in ("[1, 2, 3]", "[1.0, 2]", "[nan, inf]")),
        *((f"[red]\nv = {value}", "v") for value in ("[true, false]", "['1', '2']", "[[1, 2]]")),
        *((f"[red]\nv = {value}", "v") for value in ("{lower = 1, upper = 2}", "2020-01-01")),
        *((f"[red]\nv = [0, {value}]", "v") for value in (256, 10**20)),
        *(("[red.v]", "v"), ("[red]\nw = [0, 1]", "w"), ("[red]\nY = [0, 1]", "Y")),
        ("['']", "name"),
    ],
)
def test_broken_values_name_file_color_and_key(color_file, content, key):
    path = color_file(content)
    with pytest.raises(ValueError, match=re.escape(str(path))) as caught:
        load_colors(path)
    assert re.search(rf"\b{key}\b", str(caught.value))
    if "red" in content:
        assert "red" in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [
        *("[red", "[red]\n[red]", "[red]\ny = [0, 1]\ny = [0, 1]", "[red]\ny = [0 1]", "y", "\0"),
        *(b"\xff\xfe[\0r\0]\0", b"\x89PNG\r\n\x1a\n"),
        *("red = " + "9" * 5000, "red = " + "[" * 10_000),
    ],
    ids=lambda content: repr(content[:20]),
)
def test_what_is_no_toml_names_the_file(color_file, content):
    path = color_file(content)
    with pytest.raises(ValueError, match=re.escape(str(path))):
        load_colors(path)


def load_any(path, content):
    path.write_bytes(content)
    try:
        colors = load_colors(path)
    except ValueError as error:
        message = str(error)
    else:
        assert colors
        assert all(isinstance(color, ColorClass) for color in colors)
        return
    assert str(path) in message


@given(content=st.binary(max_size=200))
def test_any_bytes_give_colors_or_a_value_error(tmp_path_factory, content):
    load_any(tmp_path_factory.getbasetemp() / "bytes.toml", content)


@pytest.mark.long
@settings(max_examples=200)
@given(content=st.text(max_size=200) | st.text("[]redyuv=,0123456789.-'\"\n {}", max_size=60))
def test_any_text_gives_colors_or_a_value_error(tmp_path_factory, content):
    load_any(tmp_path_factory.getbasetemp() / "text.toml", content.encode("utf-8", "surrogatepass"))


TOML_VALUES = st.recursive(
    st.integers(-300, 300) | st.booleans() | st.sampled_from(["nan", "1.5", "'x'", "2020-01-01"]),
    lambda values: st.lists(values, max_size=3),
)


@pytest.mark.long
@settings(max_examples=200)
@given(value=TOML_VALUES | st.lists(st.integers(-1, 256), min_size=2, max_size=2))
def test_any_value_gives_that_range_or_a_value_error(tmp_path_factory, value):
    path = tmp_path_factory.getbasetemp() / "values.toml"
    text = str(value).replace('"', "").replace("True", "true").replace("False", "false")
    path.write_text(f"[red]\ny = {text}\n")
    good = isinstance(value, list) and len(value) == 2
    good = good and all(type(end) is int for end in value) and 0 <= value[0] <= value[1] <= 255
    if good:
        assert load_colors(path)[0].y == tuple(value)
    else:
        with pytest.raises(ValueError, match=r"\by\b.* of "):
            load_colors(path)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match=re.escape(str(tmp_path / "no.toml"))):
        load_colors(tmp_path / "no.toml")


def test_a_directory(tmp_path):
    with pytest.raises((OSError, ValueError), match=re.escape(str(tmp_path))):
        load_colors(tmp_path)


# --- ColorClass


def test_a_color_class_takes_any_value_by_default():
    color = ColorClass("any")
    assert color.name == "any"
    assert ranges(color) == dict.fromkeys(CHANNELS, (0, 255))


def test_a_color_class_shows_its_ranges():
    color = ColorClass("red", y=(1, 2), v=(3, 4))
    assert repr(color) == "ColorClass('red', y=(1, 2), u=(0, 255), v=(3, 4))"
    assert ranges(eval(repr(color))) == ranges(color)


@pytest.mark.long
@pytest.mark.parametrize("name", CHANNELS)
@given(lower=st.integers(-(2**31), 2**31 - 1), upper=st.integers(-(2**31), 2**31 - 1))
def test_ranges_beyond_the_limits_are_refused(name, lower, upper):
    if 0 <= lower <= upper <= 255:
        return
    with pytest.raises(ValueError, match=rf"{name} of colour class 'red'.*\[{lower}, {upper}\]"):
        ColorClass("red", **{name: (lower, upper)})


@given(st.lists(st.integers(0, 255), min_size=6, max_size=6))
def test_ranges_within_the_limits_are_kept(ends):
    given_ranges = {
        name: (min(pair), max(pair))
        for name, pair in zip(CHANNELS, zip(ends[::2], ends[1::2], strict=True), strict=True)
    }
    assert ranges(ColorClass("red", **given_ranges)) == given_ranges


@refusals(
    options(
        ColorClass,
        {"y": (None, 5, "ab", (1,), (1, 2, 3), (0, 1.5), (0, 2**40), ("0", "1"), (np.nan, 1))},
        "red",
    ),
    Refusal(ColorClass, "name", ("", None, 5, ["red"], b"red", b"\xff")),
    Refusal(
        as_colors,
        "colors",
        (5, 5.0, b"red", [1], [None], ["red"], [("red", (0, 1))], {"red": 1}, ColorClass("red")),
        "colors must be",
        TypeError,
    ),
)
def test_what_is_no_color_class(refusal):
    refusal()


def test_color_classes_are_read_only():
    with pytest.raises(AttributeError):
        ColorClass("red").y = (0, 1)


@pytest.mark.parametrize("channel", [0, 1, 2])
def test_both_ends_of_a_range_belong_to_it(channel):
    image = np.full((8, 8, 3), (90, 120, 200), np.uint8)
    value = int(rgb_to_yuv(image)[0, 0, channel])

    def found(lower, upper):
        color = ColorClass("test", **{CHANNELS[channel]: (lower, upper)})
        return len(robsim.find_blobs(image, [color])["test"])

    assert found(value, value) == 1
    assert found(value + 1, 255) == 0
    assert found(0, value - 1) == 0


# --- as_colors


def test_as_colors_takes_what_the_simulation_takes(color_file):
    red, blue = load_colors()
    assert [color.name for color in as_colors(None)] == ["red", "blue"]
    assert as_colors([blue, red]) == (blue, red)
    assert as_colors(color for color in (red,)) == (red,)
    assert as_colors([]) == ()
    path = color_file("[green]")
    assert [color.name for color in as_colors(path)] == ["green"]
    assert [color.name for color in as_colors(str(path))] == ["green"]


# --- rgb_to_yuv


def test_the_corners_of_the_color_cube():
    corners = np.array(list(itertools.product((0, 255), repeat=3)), np.uint8)[:, None]
    yuv = rgb_to_yuv(corners)
    assert yuv.dtype == np.uint8
    np.testing.assert_array_equal(yuv, yuv_formula(corners))


def test_pure_colors_by_hand():
    image = np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255]]], np.uint8)
    # 38 * 255/128 = 75.7, -22 * 255/128 = -43.8, 64 * 255/128 = 127.5, and so on, rounded down
    assert rgb_to_yuv(image).tolist() == [[[75, 84, 255], [149, 44, 20], [29, 255, 108]]]


def test_random_pixels(rng):
    image = rng.integers(0, 256, (50, 70, 3), dtype=np.uint8)
    np.testing.assert_array_equal(rgb_to_yuv(image), yuv_formula(image))


def test_every_value_of_every_channel_fits_into_a_byte():
    levels = np.arange(0, 256, 5, dtype=np.uint8)
    image = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(52, -1, 3)
    yuv = yuv_formula(image)
    assert yuv.min() >= 0
    assert yuv.max() <= 255
    np.testing.assert_array_equal(rgb_to_yuv(image), yuv)


def test_grey_stays_neutral():
    grey = np.repeat(np.arange(256, dtype=np.uint8), 3).reshape(1, 256, 3)
    y, u, v = np.moveaxis(rgb_to_yuv(grey), -1, 0)
    np.testing.assert_array_equal(y[0], np.arange(256))
    assert (u == 128).all()
    assert (v == 128).all()


def test_rows_may_lie_anywhere(rng):
    image = rng.integers(0, 256, (9, 7, 3), dtype=np.uint8)
    for view in (image[::2], image[::-1], image[2:5, 1:4]):
        np.testing.assert_array_equal(rgb_to_yuv(view), yuv_formula(view))


def test_a_picture_is_no_colour_file(tmp_path):
    file = tmp_path / "red.png"
    file.write_bytes(b"\x89PNG")
    with pytest.raises(ValueError, match=r"red\.png is not a TOML file: it is not UTF-8 text$"):
        load_colors(file)
