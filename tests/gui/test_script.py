"""The module for the browser, which is joined from files; its texts and its colours."""

import json
import re
import shutil
import subprocess
from collections import Counter
from itertools import product

import numpy as np
import pytest

from robsim.gui._hosts.script import STATIC, page_script, script

_NAMES = re.compile(r"^(?:export )?(?:async )?(?:const|let|class|function) (\w+)", re.MULTILINE)


def test_no_name_stands_in_two_files():
    # Each file alone is right then, and the module that they are joined into is not.
    files = [file.read_text("utf-8") for file in STATIC.rglob("*.js") if file.name != "page.js"]
    names = Counter(name for code in files for name in _NAMES.findall(code))
    assert len(names) > 100
    assert [name for name, count in names.items() if count > 1] == []


def test_the_module_imports_nothing():
    assert re.findall(r"^(?:import|export (?!default))", script(), re.MULTILINE) == []


def test_no_text_becomes_code_or_elements():
    ways = r"(?:inner|outer)HTML|insertAdjacentHTML|document\.write|srcdoc|\beval\(|new Function"
    handlers = r"setAttribute\(['\"`]on|javascript:"
    code = script() + page_script()
    assert re.findall(f"{ways}|createContextualFragment|parseFromString|{handlers}", code) == []


@pytest.mark.long
def test_node_can_read_it(tmp_path):
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node")
    (tmp_path / "view.mjs").write_text(script(), "utf-8")
    assert subprocess.run([node, "--check", tmp_path / "view.mjs"], check=False).returncode == 0


TEXTS = json.loads((STATIC / "texts.json").read_text("utf-8"))
CODE = {file.name: file.read_text("utf-8") for file in STATIC.rglob("*.js")}


def test_every_text_that_is_asked_for_is_there():
    asked = {
        (file, name)
        for file, code in CODE.items()
        for name in re.findall(r'\b(?:text|makeButton)\(\s*"([^"]+)"(?!, \{\}, )', code)
    }
    assert len(asked) > 50
    assert {(file, name) for file, name in asked if name not in TEXTS} == set()


def test_names_that_are_made_up_begin_as_texts_do():
    made = {
        (file, start)
        for file, code in CODE.items()
        for start in re.findall(r"\btext\(\s*`([\w.]+\.)\$\{", code)
    }
    assert {one for one in made if not any(name.startswith(one[1]) for name in TEXTS)} == set()


_BLOCK = re.compile(r"^\.robsim((?:\[[^]]+\])*) \{(.*?)^\}", re.MULTILINE | re.DOTALL)
_COLOR = re.compile(r"--robsim-([\w-]+): (#[0-9a-f]{6});")


def colors(theme, palette):
    """The colours of a theme and a palette, as the cascade gives them."""
    chosen = {f'[data-theme="{theme}"]', f'[data-palette="{palette}"]'}
    blocks = _BLOCK.findall((STATIC / "css/theme.css").read_text())
    fitting = [(set(re.findall(r"\[[^]]+\]", where)), text) for where, text in blocks]
    fitting = sorted((b for b in fitting if b[0] <= chosen), key=lambda block: len(block[0]))
    return {name: css for _, text in fitting for name, css in _COLOR.findall(text)}


def linear(css):
    """Linear RGB of a colour, 0 to 1."""
    srgb = np.array([int(css[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def contrast(one, other):
    """The ratio of WCAG."""
    high, low = sorted(
        (linear(css) @ [0.2126, 0.7152, 0.0722] for css in (one, other)), reverse=True
    )
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_texts_can_be_read_and_curves_seen(theme):
    css = colors(theme, "historical")
    surfaces = ("ground", "raised", "sunken")
    words = ("text", "quiet", "link", "good", "warning", "bad")
    pairs = [*product(words, surfaces), ("accent-text", "accent"), ("bad-fill-text", "bad-fill")]
    pairs += [(name, f"{name}-soft") for name in ("good", "warning", "bad")]
    pairs += [("link", "accent-soft"), ("active-text", "active")]
    poor = {pair: contrast(css[pair[0]], css[pair[1]]) for pair in pairs}
    assert {pair: ratio for pair, ratio in poor.items() if ratio < 4.5} == {}

    for palette in ("historical", "distinct"):
        css = colors(theme, palette)
        curves = ("true", "measured", "held", "estimated")
        assert min(contrast(css[name], css["raised"]) for name in curves) >= 3
