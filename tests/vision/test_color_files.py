"""Colour classes as text, and in colour files that are there already."""

import re
import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robsim import ColorClass, load_colors
from robsim.vision import colors_to_toml, save_colors

CHANNELS = ("y", "u", "v")


def ranges(color):
    return [getattr(color, channel) for channel in CHANNELS]


def same(colors, others):
    assert [(c.name, *ranges(c)) for c in colors] == [(c.name, *ranges(c)) for c in others]


NAMES = st.text(st.characters(codec="utf-8").filter(str.isprintable), min_size=1, max_size=8)
RANGE = st.tuples(st.integers(0, 255), st.integers(0, 255)).map(lambda ends: tuple(sorted(ends)))
COLOR = st.builds(lambda name, y, u, v: ColorClass(name, y=y, u=u, v=v), NAMES, RANGE, RANGE, RANGE)


@pytest.mark.long
@settings(max_examples=15)
@given(colors=st.lists(COLOR, max_size=4, unique_by=lambda color: color.name))
def test_text_is_read_back(tmp_path_factory, colors):
    tables = tomllib.loads(colors_to_toml(colors))
    assert [(name, *map(tuple, table.values())) for name, table in tables.items()] == [
        (color.name, *ranges(color)) for color in colors
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
