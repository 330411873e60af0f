"""`plot_color_histograms`: the YUV histograms of a colour class."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from robsim._core import ColorClass
from robsim.base.checks import Floats, as_float_array, check_text
from robsim.base.text import no_formula, one_line
from robsim.plotting import style as style
from robsim.plotting.style import Panels, check_axes, check_source

_NAMES = ("Y: brightness", "U: more = bluer", "V: more = redder")


@style.applied
def plot_color_histograms(
    histograms: ArrayLike,
    color: ColorClass,
    *,
    others: ArrayLike | None = None,
    picture: str | None = None,
    axes: Panels | None = None,
) -> Figure:
    """Draw the Y, U and V histograms of a colour's pixels, and the ranges of its class.

    Parameters
    ----------
    histograms : array_like (3, 256)
        Histograms of the pixels of the colour, as from `robsim.vision.color_histograms`.
    color : ColorClass
        The class; its ranges are shaded.
    others : array_like (3, 256), optional
        Histograms for comparison, such as from the whole image.
    picture : str, optional
        Name of the image, for the title.
    axes : array_like (3,) of matplotlib.axes.Axes, optional
        Axes to draw in: Y, U, V. Default: a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of the axes; a new one has 9 x 2.8 inches.

    Raises
    ------
    TypeError, ValueError
        If `color` is not a ColorClass, the histograms are not of shape (3, 256), or `axes` is not
        of shape (3,).

    Examples
    --------
    >>> frame, red = robsim.Simulation(seed=1).step().frame, robsim.load_colors()[0]
    >>> histograms = robsim.vision.color_histograms(frame, (0, 0, 1199, 1199))
    >>> figure = robsim.plotting.plot_color_histograms(histograms, red)
    >>> [axes.get_xlabel() for axes in figure.axes]
    ['Y: brightness', 'U: more = bluer', 'V: more = redder']
    """
    check_source("color", color, ColorClass)
    heights = _normalised("histograms", histograms)
    other_heights = None if others is None else _normalised("others", others)
    if picture is not None:
        check_text("picture", picture)
    is_new = axes is None
    if axes is None:
        figure = style.NotebookFigure(figsize=(9, 3.2))
        where = "" if picture is None else f" in {one_line(picture)}"
        figure.suptitle(f"pixels of the colour {color.name}{where}", parse_math=False)
        axes = figure.subplots(1, 3, sharey=True)
    axes = check_axes(axes, (3,))
    for i, (panel, limits) in enumerate(zip(axes, (color.y, color.u, color.v), strict=True)):
        if other_heights is not None:
            _draw_histogram(panel, other_heights[i], style.GUIDE, "the whole image")
        _draw_histogram(
            panel, heights[i], style.drawn_color(color.name), no_formula(f"pixels of {color.name}")
        )
        _draw_range(panel, limits, _NAMES[i])
    axes[0].set_ylabel("pixels (maximum = 1)")
    first: Axes = axes[0]
    handles, labels = first.get_legend_handles_labels()
    if is_new:
        first.figure.figure.legend(handles, labels, loc="outside lower center", ncols=2)
    else:
        first.legend(handles, labels, loc="lower left", bbox_to_anchor=(0, 1.1))
    return first.figure.figure


def _normalised(name: str, histograms: ArrayLike) -> Floats:
    """Return the histograms scaled to a maximum of 1."""
    counts = as_float_array(name, histograms)
    if counts.shape != (3, 256):
        raise ValueError(f"{name} must be of shape (3, 256), got {counts.shape}")
    heights: Floats = counts / np.maximum(counts.max(axis=1, keepdims=True), 1)
    return heights


def _draw_histogram(axes: Axes, heights: Floats, color: str, label: str) -> None:
    axes.stairs(heights, np.arange(257) - 0.5, fill=True, color=color, alpha=0.75, label=label)


def _draw_range(axes: Axes, limits: tuple[int, int], name: str) -> None:
    lower, upper = limits
    is_open = (lower, upper) == (0, 255)
    if not is_open:
        shade = axes.axvspan(lower - 0.5, upper + 0.5, color=style.MEASURED, linewidth=0)
        shade.set(alpha=0.15, zorder=0)
    axes.set(xlim=(-0.5, 255.5), ylim=(0, 1.05), xticks=(0, 64, 128, 192, 255))
    axes.set_yticks((0, 0.5, 1))
    axes.set_xlabel(name)
    axes.set_title("no limit" if is_open else f"from {lower} to {upper}", loc="left")
