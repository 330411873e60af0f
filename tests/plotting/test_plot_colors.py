"""The figure of a colour's histograms."""

import numpy as np
import pytest

from robsim import ColorClass
from robsim.plotting import plot_color_histograms
from robsim.vision import color_histograms


@pytest.mark.long
def test_the_figure_shows_histograms_and_ranges():
    image = np.full((40, 40, 3), (150, 148, 146), np.uint8)
    image[10:30, 10:30] = (198, 36, 40)
    histograms = color_histograms(image, (10, 10, 29, 29))
    color = ColorClass.from_histograms(histograms, name="red")
    figure = plot_color_histograms(
        histograms, color, others=color_histograms(image, (0, 0, 39, 39)), picture="floor.png"
    )
    assert figure.get_suptitle() == "pixels of the colour red in floor.png"
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["no limit", "from 0 to 154", "from 156 to 255"]
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["the whole image", "pixels of red"]
    figure.canvas.draw()
    axes = np.array(figure.axes)
    assert plot_color_histograms(histograms, ColorClass("a"), axes=axes) is figure


def test_the_figure_refuses_other_shapes():
    for name in ("histograms", "others", "axes"):
        values = {"histograms": np.zeros((3, 256))} | {name: np.zeros((2, 256))}
        with pytest.raises(ValueError, match=name):
            plot_color_histograms(color=ColorClass("red"), **values)
