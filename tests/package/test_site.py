"""The site: its gallery, its place for each room, and the check of its links."""

import re
from pathlib import Path

import pytest

import robsim
from check_site import faults

SITE = Path(__file__).parents[2] / "notebooks/site"
with_site = pytest.mark.skipif(not SITE.is_dir(), reason="needs the sources")


@with_site
def test_the_gallery_has_each_figure():
    text = (SITE / "gallery.md").read_text(encoding="utf-8")
    for name in robsim.plotting.__all__:
        assert re.search(rf"\b{name}\b", text), name


@with_site
def test_the_reference_has_each_room():
    text = (SITE / "reference.md").read_text(encoding="utf-8")
    for name in ("robsim", *robsim._WINGS, "estimation.reference", "teach.gym"):
        assert f"\nreference/{name}\n" in text


@pytest.mark.parametrize(
    ("html", "fault"),
    [
        ('<a href="other.html#here">', None),
        ('<a href="#own"><p id="own">', None),
        ('<a href="https://example.org/">', None),
        ('<img src="data:image/png;base64,AAAA">', None),
        ('<a href="missing.html">', "no file missing.html"),
        ('<img src="missing.png">', "no file missing.png"),
        ('<a href="other.html#there">', "no anchor other.html#there"),
        ('<script src="https://example.org/a.js">', "loads https://example.org/a.js"),
        ('<link rel="stylesheet" href="//example.org/a.css">', "loads //example.org/a.css"),
    ],
)
def test_a_link_without_target_and_a_load_from_the_internet_are_faults(tmp_path, html, fault):
    page = tmp_path / "page.html"
    page.write_text(html)
    (tmp_path / "other.html").write_text('<p id="here">')
    assert list(faults(tmp_path)) == ([f"{page.resolve()}: {fault}"] if fault else [])


def test_a_style_that_loads_a_font_from_the_internet_is_a_fault(tmp_path):
    (tmp_path / "a.css").write_text("@font-face { src: url('https://example.org/a.woff2') }")
    assert [text.split(": ")[1] for text in faults(tmp_path)] == [
        "loads https://example.org/a.woff2"
    ]
