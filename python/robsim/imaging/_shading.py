"""Light and shadow."""

from __future__ import annotations

import numpy as np

from robsim.imaging._images import Pixels

#: Brightness in the shadow over the rightmost third of the view.
SHADOW = 0.8

# Each of the 256 values of a channel as it looks in the shadow, and back in the light.
_DARKENED = np.rint(np.arange(256) * SHADOW).astype(np.uint8)
_LIGHTENED = np.minimum(np.rint(np.arange(256) / SHADOW), 255).astype(np.uint8)


def darkened(pixels: Pixels) -> Pixels:
    """Return lit pixels as they look in the shadow."""
    dark: Pixels = _DARKENED[pixels]
    return dark


def lightened(pixels: Pixels) -> Pixels:
    """Return pixels in the shadow as they look in the light."""
    light: Pixels = _LIGHTENED[pixels]
    return light
