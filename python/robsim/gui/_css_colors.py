"""The panels' drawing colours for colour classes."""

from __future__ import annotations

import numpy as np

from robsim._core import ColorClass

_CSS_COLORS = {
    "red": "#e5484d",
    "blue": "#3b82f6",
    "green": "#30a46c",
    "yellow": "#f5d90a",
    "orange": "#f76b15",
    "magenta": "#d6409f",
}


def css_color(color: ColorClass) -> str:
    """Return the drawing colour of a class: by its name, or from the middle of its range."""
    if color.name in _CSS_COLORS:
        return _CSS_COLORS[color.name]
    # ITU-R BT.601, at half the luminance.
    u, v = (sum(limits) / 2 - 128 for limits in (color.u, color.v))
    rgb = np.clip([128 + 1.402 * v, 128 - 0.344 * u - 0.714 * v, 128 + 1.772 * u], 0, 255)
    return "#" + "".join(f"{round(part):02x}" for part in rgb)
