"""The colours of the panel: what can be read."""

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import robsim.gui

_BLOCK = re.compile(r"^\.robsim((?:\[[^]]+\])*) \{(.*?)^\}", re.MULTILINE | re.DOTALL)
_COLOR = re.compile(r"--robsim-([\w-]+): (#[0-9a-f]{6});")


def colors(theme, palette):
    """The colours of a theme and a palette, as the cascade gives them."""
    chosen = {f'[data-theme="{theme}"]', f'[data-palette="{palette}"]'}
    blocks = _BLOCK.findall((Path(robsim.gui.__file__).parent / "static/css/theme.css").read_text())
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
