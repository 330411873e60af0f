"""Figures of robots and their colours."""

import sys

import numpy as np
import pytest
from matplotlib.colors import same_color
from matplotlib.figure import Figure

from drawn_robots import box, painted
from robsim import ColorClass, load_robot
from robsim.plotting import plot_color_histograms, plot_robot
from robsim.plotting import style as style
from robsim.vision import BlobMarker, RobotDefinition, color_histograms, robot_from_image

# --- robots


RED, BLUE = box(240, 240, 319, 319), box(80, 200, 159, 279)


@pytest.fixture(scope="module", autouse=True)
def _no_pyplot():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "matplotlib.pyplot", None)
        yield


def robot(**changed):
    values = {"name": "toy", "image": painted(RED, BLUE), "size": 100.0, "alignment": 90.0}
    values |= {"outline": box(0, 0, 399, 399), "centre": (200, 180)} | changed
    return robot_from_image(markers={"red": RED, "blue": BLUE}, **values)


@pytest.fixture(scope="module")
def axes():
    return plot_robot(robot())


def test_the_picture_is_shown_as_it_is(axes):
    (image,) = axes.get_images()
    np.testing.assert_array_equal(image.get_array(), painted(RED, BLUE))
    assert axes.get_xlim()[0] < -0.5
    assert axes.get_ylim()[0] > 399.5 > -0.5 > axes.get_ylim()[1]  # down is down
    assert axes.get_aspect() == 1
    assert axes.get_title("left") == "toy: 100 px wide on the work area, alignment 90°"
    assert isinstance(axes, style.NotebookAxes)


def test_the_whole_title_is_in_the_figure():
    axes = plot_robot(load_robot("lab"))
    figure = axes.figure
    figure.draw_without_rendering()
    inside = figure.get_window_extent()
    drawn = axes.get_tightbbox()
    assert inside.y0 <= drawn.y0 < drawn.y1 <= inside.y1


def test_the_polygons(axes):
    shown = {patch.get_label(): patch for patch in axes.patches}
    assert list(shown) == ["outline", "right marker (red)", "left marker (blue)"]
    for name, polygon in (("outline", box(0, 0, 399, 399)), ("right marker (red)", RED)):
        np.testing.assert_array_equal(shown[name].get_xy()[:-1], polygon)
    assert same_color(shown["right marker (red)"].get_edgecolor(), "red")
    assert same_color(shown["left marker (blue)"].get_edgecolor(), "blue")


def test_the_line_between_the_markers_has_their_distance(axes):
    (line,) = [line for line in axes.get_lines() if line.get_label() == "marker centroids"]
    np.testing.assert_allclose(line.get_xydata(), [(279.5, 279.5), (119.5, 239.5)])
    distance = np.hypot(160, 40) * 100 / 400
    assert f"{distance:.1f} px" in {text.get_text() for text in axes.texts}


def test_nothing_covers_anything_with_markers_in_front_and_behind():
    front, back = box(80, 180, 119, 219), box(280, 180, 319, 219)
    toy = RobotDefinition(
        name="toy",
        image=painted(front, back),
        size=100.0,
        alignment=180.0,
        outline=box(0, 0, 399, 399),
        markers={
            "front": BlobMarker(front, "fluorescent green"),
            "back": BlobMarker(back, "orange"),
        },
    )
    drawn = plot_robot(toy)
    drawn.figure.canvas.draw()
    (distance,) = [text for text in drawn.texts if text.get_text() == "50.0 px"]
    box_of_text = distance.get_window_extent()
    line = drawn.transData.transform((200, 199.5))[1]
    assert not box_of_text.y0 - 2 < line < box_of_text.y1 + 2  # beside the arrow
    legend = drawn.get_legend().get_window_extent()
    assert legend.x0 >= 0
    assert legend.x1 <= drawn.figure.bbox.width


@pytest.mark.parametrize(
    ("alignment", "forward"),
    [(0, (1, 0)), (90, (0, -1)), (-90, (0, 1)), (150, (-np.cos(np.pi / 6), -0.5))],
)
def test_the_arrow_points_to_what_will_face_right(alignment, forward):
    definition = robot(alignment=alignment)
    (arrow,) = [text for text in plot_robot(definition).texts if text.arrow_patch]
    tip, tail = np.array(arrow.xy), np.array(arrow.get_position())
    np.testing.assert_allclose(tail, (200, 180))
    np.testing.assert_allclose((tip - tail) / np.linalg.norm(tip - tail), forward, atol=1e-12)
    drawn = plot_robot(robot(alignment=alignment, centre=(330, 60)))
    (arrow,) = [text for text in drawn.texts if text.arrow_patch]
    (left, right), (bottom, top) = drawn.get_xlim(), drawn.get_ylim()
    assert left < arrow.xy[0] < right
    assert top < arrow.xy[1] < bottom


def test_the_scale_is_a_round_number_of_px():
    for size, length in ((1, 0.1), (60, 10), (100, 10), (120, 20), (400, 50)):
        drawn = plot_robot(robot(size=size))
        assert f"{length:g} px" in {text.get_text() for text in drawn.texts}
        bar = drawn.get_lines()[-1].get_xdata()
        assert np.diff(bar) * size / 400 == pytest.approx(length)


def test_axes_that_are_given():
    mine = Figure().add_subplot()
    assert plot_robot(load_robot("lab"), ax=mine) is mine
    assert mine.get_images()
    mine.figure.draw_without_rendering()


# --- colours


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
