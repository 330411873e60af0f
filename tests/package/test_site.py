"""The site: its gallery, its place for each room, its file formats, and the check of its links."""

import importlib
import re
from pathlib import Path

import numpy as np
import pytest

import robsim
from check_site import faults
from prose import SITE, examples
from robsim.campaigns.spec_file import load_spec
from robsim.gui.panels.replay_file import ReplayFile
from robsim.teach.assignments.classes.groups import read_groups
from robsim.trace.sessions._setup import FORMAT, Setup
from robsim.trace.sessions.rows import row_of_json
from robsim.vision.imaging.images import png_bytes

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


def loaded_robot(path):
    (path.parent / "robot.png").write_bytes(png_bytes(np.full((40, 40, 4), 255, np.uint8)))
    return robsim.load_robot(path.parent)


def loaded_assignment(path):
    """The assignment of both files, which the page has in its order."""
    for name, text in examples("formats").items():
        if name in ("assignment.toml", "limits.json"):
            (path.parent / name).write_text(text)
    (path.parent / "own_tests.py").write_text("")
    return robsim.teach.load_assignment(path.parent)


LOADED = {
    "scenario.toml": robsim.Scenario.load,
    "robot.toml": loaded_robot,
    "colors.toml": robsim.load_colors,
    "camera.toml": robsim.vision.load_calibration,
    "robsim.setup": lambda path: Setup(path.read_text(), path, FORMAT),
    "/robsim/steps": lambda path: row_of_json(path.read_text().replace("\n", "").encode()),
    "run.replay": ReplayFile.load,
    "campaign.toml": load_spec,
    "assignment.toml": loaded_assignment,
    "limits.json": loaded_assignment,
    "result.json": lambda path: robsim.teach.SubmissionResult.from_json(path.read_text()),
    "groups.csv": read_groups,
}


@with_site
@pytest.mark.parametrize("name", LOADED)
def test_robsim_loads_the_example_of_each_file_format(tmp_path, name):
    path = tmp_path / Path(name).name
    path.write_text(examples("formats")[name])
    assert LOADED[name](path)


@with_site
def test_the_page_of_formats_has_no_other_example():
    assert examples("formats").keys() == LOADED.keys()


@with_site
def test_each_error_has_a_remedy(monkeypatch):
    monkeypatch.syspath_prepend(SITE / "_tools")
    pages = importlib.import_module("reference").pages()
    (text,) = (page.decode() for path, page in pages if path.stem == "errors")
    assert ":obj:`~robsim.lab.CameraBusyError`" in text
    assert not any(line.strip() == "-" for line in text.splitlines())


@with_site
def test_each_key_of_a_file_has_a_type_and_a_meaning(monkeypatch):
    pytest.importorskip("numpydoc")
    monkeypatch.syspath_prepend(SITE / "_tools")
    formats = importlib.import_module("formats")
    text = (SITE / "formats.md").read_text(encoding="utf-8")
    for name, table in formats.tables().items():
        assert f"{{{{ {name} }}}}" in text
        heading, _, *rows = [line.split(" | ") for line in table.splitlines()] * 2
        for row in rows if "meaning" in heading[-1] else ():
            key, kind, _, meaning = row
            assert kind.strip(), (name, key)
            assert meaning.strip("| "), (name, key)


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


def test_a_line_of_llms_txt_without_page_is_a_fault(tmp_path):
    (tmp_path / "page.html").write_text("")
    (tmp_path / "llms.txt").write_text("- [a](page.html): text (b)\n- [c](missing.html)\n")
    assert [text.split(": ")[1] for text in faults(tmp_path)] == ["no file missing.html"]
