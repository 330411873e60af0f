"""Colour classes and their files."""

import re
import tomllib

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import robsim
from robsim import ColorClass, load_colors
from robsim.vision import colors_to_toml, rgb_to_yuv, save_colors

# --- classes


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


def test_the_shipped_colors_catch_what_they_should():
    for rgb, expected in (
        *(((198, 36, 40), ["red"]), ((255, 0, 0), ["red"])),
        *(((0, 0, 255), ["blue"]), ((30, 60, 220), ["blue"])),
        *((grey, []) for grey in ((255, 255, 255), (0, 0, 0), (128, 128, 128))),
        *((other, []) for other in ((0, 255, 0), (255, 255, 0), (255, 0, 255))),
    ):
        blobs = robsim.find_blobs(np.full((8, 8, 3), rgb, np.uint8), load_colors())
        assert [color for color, found in blobs.items() if found] == expected


def test_a_correct_file(color_file):
    path = color_file("[b]\ny = [1, 2]\nu = [3, 4]\nv = [5, 5]\n\n[a]\nv = [0, 255]\n[c]\n")
    b, a, c = load_colors(path)
    assert (b.name, a.name, c.name) == ("b", "a", "c")
    assert ranges(b) == {"y": (1, 2), "u": (3, 4), "v": (5, 5)}
    assert ranges(a) == ranges(c) == dict.fromkeys(CHANNELS, (0, 255))
    assert [color.name for color in load_colors(str(path))] == ["b", "a", "c"]


def test_windows_line_ends_and_other_letters(color_file):
    (color,) = load_colors(color_file("\ufeff# Grün\r\n['grün hell']\r\ny = [1, 2]\r\n"))
    assert (color.name, color.y) == ("grün hell", (1, 2))


def test_broken_values_name_file_color_and_key(color_file):
    ranges = {
        "y": ("1", "'ab'", "[2, 1]", "[-1, 1]", "[0, 256]", f"[0, {10**20}]"),
        "u": ("[1]", "[1, 2, 3]", "[1.0, 2]", "[nan, inf]", "[true, false]"),
        "v": ("['1', '2']", "[[1, 2]]", "{lower = 1, upper = 2}", "2020-01-01"),
    }
    cases = [(f"[red]\n{key} = {value}", key) for key, values in ranges.items() for value in values]
    cases += [("red = 1", "red"), ("red = [0, 255]", "red"), ("[[red]]", "red"), ("[red.v]", "v")]
    cases += [("[red]\nw = [0, 1]", "w"), ("[red]\nY = [0, 1]", "Y"), ("['']", "name")]
    for content, key in [*cases, ("", "no colours")]:
        path = color_file(content)
        with pytest.raises(ValueError, match=re.escape(str(path))) as caught:
            load_colors(path)
        assert re.search(rf"\b{key}\b", str(caught.value)), content
        assert "red" in str(caught.value) or "red" not in content


def test_what_is_no_toml_names_the_file(color_file, tmp_path):
    for content in (
        *("[red", "[red]\n[red]", "[red]\ny = [0, 1]\ny = [0, 1]", "y", "\0"),
        *(b"\xff\xfe[\0r", b"\x89PNG\r\n\x1a\n", "red = " + "[" * 10_000),
    ):
        path = color_file(content)
        with pytest.raises(ValueError, match=re.escape(str(path))):
            load_colors(path)
    with pytest.raises(FileNotFoundError, match=re.escape(str(tmp_path / "no.toml"))):
        load_colors(tmp_path / "no.toml")
    with pytest.raises((OSError, ValueError), match=re.escape(str(tmp_path))):
        load_colors(tmp_path)


# --- ColorClass


@given(lower=st.integers(-300, 300), upper=st.integers(-300, 300))
@example(-1, 255)
@example(0, 256)
@example(5, 4)
@example(-(2**31), 2**31 - 1)
def test_ranges_beyond_the_limits_are_refused(lower, upper):
    if 0 <= lower <= upper <= 255:
        return
    for name in CHANNELS:
        with pytest.raises(ValueError, match=rf"{name} of colour class 'red'"):
            ColorClass("red", **{name: (lower, upper)})


def test_a_simulation_takes_classes_or_their_file(color_file):
    red, blue = load_colors()

    def colors_of(colors):
        return robsim.Simulation(colors=colors, resolution=(60, 60)).colors

    assert tuple(colors_of(None)) == (red, blue)
    assert tuple(colors_of([blue, red])) == (blue, red)
    assert tuple(colors_of(color for color in (red,))) == (red,)
    with pytest.raises(ValueError, match="colors"):
        colors_of([])
    assert [color.name for color in colors_of(color_file("[green]"))] == ["green"]


# --- rgb_to_yuv


def test_every_value_of_every_channel_fits_into_a_byte():
    levels = np.arange(0, 256, 5, dtype=np.uint8)  # 0 and 255 among them
    image = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(52, -1, 3)
    yuv = yuv_formula(image)
    assert yuv.min() >= 0
    assert yuv.max() <= 255
    np.testing.assert_array_equal(rgb_to_yuv(image), yuv)


# --- files


def range_list(color):
    return [getattr(color, channel) for channel in CHANNELS]


def same(colors, others):
    assert [(c.name, *range_list(c)) for c in colors] == [(c.name, *range_list(c)) for c in others]


NAMES = st.builds(
    str.__add__,
    st.characters(categories=("L", "Nd")),
    st.text(st.characters(categories=("L", "M", "Nd"), include_characters="-_ "), max_size=7),
)
RANGE = st.tuples(st.integers(0, 255), st.integers(0, 255)).map(lambda ends: tuple(sorted(ends)))
COLOR = st.builds(lambda name, y, u, v: ColorClass(name, y=y, u=u, v=v), NAMES, RANGE, RANGE, RANGE)


@pytest.mark.long
@settings(max_examples=15)
@given(colors=st.lists(COLOR, max_size=4, unique_by=lambda color: color.name))
def test_text_is_read_back(tmp_path_factory, colors):
    tables = tomllib.loads(colors_to_toml(colors))
    assert [(name, *map(tuple, table.values())) for name, table in tables.items()] == [
        (color.name, *range_list(color)) for color in colors
    ]
    path = tmp_path_factory.mktemp("text") / "new" / "colors.toml"
    if colors:
        save_colors(path, colors)
        same(load_colors(path), colors)
        save_colors(path, colors[::-1])
        same(load_colors(path), colors)


KEPT = """\
# mine
[red]   # the marker
y = [0, 255]
u = [0, 150]  # bluer is no red
v = [156, 255]

# the other
[green]
v = [0, 90]
"""


def test_saving_keeps_comments_and_other_colours(tmp_path):
    path = tmp_path / "colors.toml"
    path.write_text(KEPT)
    save_colors(path, ColorClass("red", u=(0, 140), v=(156, 255)))
    assert path.read_text() == KEPT.replace("150", "140")
    save_colors(path, ColorClass("blue", u=(156, 255)))
    text = path.read_text()
    assert text.startswith(KEPT.replace("150", "140"))
    assert [color.name for color in load_colors(path)] == ["red", "green", "blue"]
    save_colors(path, ColorClass("green", u=(5, 6)))
    assert load_colors(path)[1].u == (5, 6)
    assert load_colors(path)[1].v == (0, 255)
    assert path.read_text().startswith("# mine\n[red]   # the marker\n")
    assert [file.name for file in tmp_path.iterdir()] == ["colors.toml"]


def test_any_form_of_a_colour_file_can_be_changed(tmp_path):
    path = tmp_path / "colors.toml"
    new = ColorClass("red", y=(1, 200), u=(2, 100), v=(3, 50))
    for text in (
        *("red.u = [0, 9]\nred.v = [5, 6]\n", "red = {u = [0, 9]}\n", "red = {}", "[ red ]"),
        *("[red]\r\nu = [0, 9]\r\n[blue]\r\n", "\ufeff[red]\nu = [0, 9]\n", "['red']\nu=[0,9]#x"),
        *("[red]\nu = [\n  0, # low\n  9,\n]\n", "[blue]\nu=[1,2]\n[red]\nv=[1,2]", "blue={}"),
        *("blue.u = [1, 2]\nred.v = [1, 2]\nblue.v = [3, 4]\n", '"red" = {v = [0, 9], u = [1, 2]}'),
    ):
        path.write_bytes(text.encode())
        before = {color.name: color for color in load_colors(path)}
        save_colors(path, new)
        same(load_colors(path), (before | {"red": new}).values())


def test_what_is_no_colour_file_stays_as_it_is(tmp_path):
    path = tmp_path / "colors.toml"
    for content in (b"oops", b"\xff\xfe", b"[red]\nu = [1]", b"", b"[red]\nu=[0,9"):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=re.escape(str(path))):
            save_colors(path, load_colors())
        assert path.read_bytes() == content


def test_wrong_colours_are_not_saved(tmp_path):
    red = ColorClass("red")
    for colors in ([red, red], ()):
        with pytest.raises(ValueError, match="colors"):
            save_colors(tmp_path / "colors.toml", colors)
    with pytest.raises(ValueError, match="names"):
        colors_to_toml([red, red])
    assert list(tmp_path.iterdir()) == []
