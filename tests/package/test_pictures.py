"""The pictures of the README are those that the code draws today."""

import importlib.util
import json
import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "assets" / "readme"

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not FOLDER.is_dir(), reason="needs the sources"),
]

REMEDY = "the picture {} of the README is out of date: ./run pictures, look at it, commit it"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")

# Grey levels of 255, for pictures reduced to blocks of 16 x 16 px: what other fonts and another
# version of matplotlib may change, but nothing that one sees.
MOST_DIFFERENCE = 2.5


def loaded(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / f"assets/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def script():
    return loaded("draw_readme")


@pytest.fixture(scope="module")
def figures(script):
    return script.figures()


@pytest.fixture(scope="module")
def pictures(figures, script):
    return {name: script.picture(figure) for name, figure in figures.items()}


def numbers(texts):
    return [float(number) for text in texts for number in NUMBER.findall(text)]


def words(texts):
    return [NUMBER.sub("#", text) for text in texts]


def difference(one, other):
    """The mean difference of two images of about the same size, coarsely (grey levels)."""
    size = (one.width // 16, one.height // 16)
    a, b = (
        np.asarray(i.convert("RGB").resize(size, Image.Resampling.BOX), float) for i in (one, other)
    )
    return np.abs(a - b).mean()


@pytest.fixture(scope="module")
def contents():
    return json.loads((FOLDER / "contents.json").read_text())


def test_every_picture_has_its_contents_and_is_in_the_readme(figures, script, contents):
    drawn = {*figures, script.PANEL}
    assert set(contents) == drawn
    assert {file.name for file in FOLDER.iterdir()} == {*drawn, script.FILM, "contents.json"}
    shown = re.findall(r"!\[[^]]*\]\(assets/readme/([^)]+)\)", (ROOT / "README.md").read_text())
    assert sorted(shown) == sorted({*drawn, script.FILM})
    assert (FOLDER / script.FILM).stat().st_size < 2_000_000
    assert all((FOLDER / name).stat().st_size < 150_000 for name in drawn)


@pytest.mark.parametrize("name", ["traces.png"])
def test_the_picture_is_what_the_code_draws(name, figures, script, contents):
    assert script.marks(figures[name]) == contents[name]["marks"], REMEDY.format(name)
    stored, drawn = contents[name]["texts"], script.texts(figures[name])
    assert words(drawn) == words(stored), REMEDY.format(name)
    # The last digit may differ between processors.
    for now, then in zip(numbers(drawn), numbers(stored), strict=True):
        assert math.isclose(now, then, rel_tol=2e-3, abs_tol=2e-3), REMEDY.format(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["traces.png"])
def test_the_picture_looks_as_the_code_draws_it(name, pictures):
    drawn = pictures[name]
    with Image.open(FOLDER / name) as stored:
        assert abs(stored.width / drawn.width - 1) < 0.03, REMEDY.format(name)
        assert abs(stored.height / drawn.height - 1) < 0.03, REMEDY.format(name)
        assert difference(stored, drawn) < MOST_DIFFERENCE, REMEDY.format(name)
        flipped = stored.convert("RGB").transpose(Image.Transpose.FLIP_LEFT_RIGHT)
        assert difference(flipped, drawn) > 3 * MOST_DIFFERENCE


@pytest.mark.slow
def test_the_picture_of_the_panel_is_what_chromium_shows(script, contents):
    pytest.importorskip("playwright")
    if shutil.which("chromium") is None:
        pytest.skip("needs chromium")
    panel = loaded("draw_panel")
    shown, texts = panel.panel_picture()
    assert words(texts) == words(contents[script.PANEL]["texts"]), REMEDY.format(script.PANEL)
    with Image.open(FOLDER / script.PANEL) as stored:
        assert stored.size == shown.size
        assert difference(stored, panel.small(shown)) < MOST_DIFFERENCE, REMEDY.format(script.PANEL)
