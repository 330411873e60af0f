"""The colours of the panel: what can be read, and what can be told apart by all eyes."""

import re
from itertools import combinations, product

import numpy as np
import pytest

from robsim.gui._hosts.script import STATIC

_BLOCK = re.compile(r"^\.robsim((?:\[[^]]+\])*) \{(.*?)^\}", re.MULTILINE | re.DOTALL)
_COLOR = re.compile(r"--robsim-([\w-]+): (#[0-9a-f]{6});")

#: What linear RGB becomes for those who lack a cone (Machado et al. 2009, severity 1).
DEFICIENCIES = {
    "none": np.eye(3),
    "protan": [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    "deutan": [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    "tritan": [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
}


def colors(theme, palette):
    """The colours of a theme and a palette, as the cascade gives them."""
    chosen = {f'[data-theme="{theme}"]', f'[data-palette="{palette}"]'}
    blocks = _BLOCK.findall((STATIC / "css" / "theme.css").read_text())
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


def lab(rgb):
    """CIE L*a*b* of linear RGB."""
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(np.clip(to_xyz @ np.clip(rgb, 0, 1), 0.008, 1) / [0.9505, 1, 1.089])
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_texts_can_be_read(theme):
    css = colors(theme, "historical")
    surfaces = ("ground", "raised", "sunken")
    words = ("text", "quiet", "link", "good", "warning", "bad")
    pairs = [*product(words, surfaces), ("accent-text", "accent"), ("bad-fill-text", "bad-fill")]
    pairs += [(name, f"{name}-soft") for name in ("good", "warning", "bad")]
    pairs += [("link", "accent-soft"), ("active-text", "active")]
    poor = {pair: contrast(css[pair[0]], css[pair[1]]) for pair in pairs}
    assert {pair: ratio for pair, ratio in poor.items() if ratio < 4.5} == {}


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_curves_stand_out_from_the_ground_and_the_distinct_palette_for_all_eyes(theme):
    curves = ("true", "measured", "held", "estimated")
    for palette in ("historical", "distinct"):
        css = colors(theme, palette)
        assert min(contrast(css[name], css["raised"]) for name in curves) >= 3
    for cones in DEFICIENCIES.values():
        seen = {name: lab(cones @ linear(css[name])) for name in curves}
        distances = {(a, b): np.linalg.norm(seen[a] - seen[b]) for a, b in combinations(seen, 2)}
        assert {pair: d for pair, d in distances.items() if d < 20} == {}
