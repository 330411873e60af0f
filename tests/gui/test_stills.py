"""The still pictures of panels and tools in a saved notebook."""

import io
import math

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import FakeBrowser, panel_of
from robsim.estimation.reference import ExtendedKalmanFilter
from small_runs import done
from threads import together
from waiting import wait_for

pytestmark = pytest.mark.long


# --- the panel


def still_of(shown, **options):
    with robsim.panel(shown, **options) as panel:
        return panel.snapshot()


def pixels_of(png):
    picture = Image.open(io.BytesIO(png))
    assert picture.format == "PNG"
    assert picture.size == (1000, 500)
    return np.asarray(picture.convert("RGB")).astype(int)


def is_there(pixels, color):
    """Whether there are some pixels near a colour."""
    return np.count_nonzero(np.abs(pixels - color).max(axis=2) < 40) > 50


@pytest.fixture(scope="module")
def simulation():
    simulation = robsim.Simulation(
        measure=True,
        estimate_state=ExtendedKalmanFilter(),
        noise=robsim.UniformNoise(40),
        dropout=robsim.Dropout(0.2),
        seed=1,
    )
    simulation.run(60)
    return simulation


@pytest.fixture(scope="module")
def bare(simulation):
    return still_of(simulation)


def test_it_shows_camera_traces_and_histograms_in_few_bytes(bare):
    pixels = pixels_of(bare)
    assert len(bare) < 150_000
    camera, traces, histograms = (
        pixels[40:480, 10:450],
        pixels[40:480, 530:820],
        pixels[40:480, 870:],
    )
    assert is_there(camera, (200, 40, 40))  # the red square on the floor
    assert is_there(traces, (209, 0, 201))  # the truth
    assert is_there(histograms, (128, 200, 138))


def test_a_goal_is_drawn_with_its_heading(simulation, bare):
    pictures = bare, *(still_of(simulation, goals=at) for at in ((600, 600), (600, 600, 0.0)))
    none, at, posed = (pixels_of(one)[40:480, 10:450] for one in pictures)
    rings, arrows = (np.argwhere(abs(one - none).max(axis=2) > 60) for one in (at, posed))
    assert len(rings) > 50
    assert np.ptp(rings, axis=0).max() < 40
    assert np.ptp(arrows[:, 1]) > np.ptp(rings[:, 1]) + 10  # to the right
    assert np.ptp(arrows[:, 0]) < np.ptp(rings[:, 0]) + 5


def test_before_the_first_step_it_shows_the_start():
    pixels = pixels_of(still_of(robsim.Simulation(measure=True, seed=1)))
    assert is_there(pixels[40:480, 10:450], (200, 40, 40))
    assert not is_there(pixels[40:60, 10:70], (198, 40, 40))  # "not seen" would stand there
    assert (pixels[260:, 480:] > 250).all()


def test_there_is_one_of_a_trace_without_frames_and_of_an_experiment_without_a_robot(simulation):
    trace = robsim.Experiment([simulation.render_step(0)]).run()
    for shown in (trace, robsim.Experiment([None])):
        pixels_of(still_of(shown))


def test_a_callback_that_fails_at_the_start_leaves_the_picture_out_and_two_may_ask():
    def define_model():
        raise ValueError("wrong")

    found = []
    with robsim.panel(robsim.Simulation(define_model=define_model, seed=1)) as panel:
        together(*[lambda: found.append(panel.snapshot())] * 2)
    pixels_of(found[0])
    assert found[0] == found[1]


def test_steps_are_kept_for_those_alone_who_have_a_place_for_a_picture():
    with panel_of(robsim.Simulation(measure=True, seed=1)) as (view, browser):
        done(view.driver.step())
        assert view.still._shot is None
        browser.keeps_still, browser.keep = True, lambda picture: None
        done(view.driver.step())
        assert view.still._shot.k == 1


# --- tools


SIDE, LEFT, TOP = 455, 6, 34  # of the picture on the sheet (px)
YELLOW, RED_INK, WHITE, ACCENT = (255, 213, 0), (229, 72, 77), (255, 255, 255), (87, 80, 211)
FLOOR, RED = (120, 122, 118), (210, 40, 30)
FIRST_LEVEL, LAST_LEVEL = 502, 904  # px: where the histograms begin and end
ROWS = {"y": 72, "u": 138, "v": 204}  # px: the tops of the histograms


class Still:
    """A still picture, looked at by places in the frame's pixels."""

    def __init__(self, tool, size):
        png = tool.snapshot()
        assert len(png) <= 140_000
        self.pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)
        self.scale = SIDE / max(size)
        margins = [(SIDE - round(self.scale * length)) // 2 for length in size]
        self.corner = np.array((LEFT, TOP)) + margins

    def at(self, point):
        """The mean colour of 3 x 3 pixels of the sheet around a place in the frame."""
        x, y = np.floor(self.corner + self.scale * (np.array(point) + 0.5)).astype(int)
        return self.mean(x - 1, y - 1, x + 2, y + 2)

    def has(self, point, ink):
        """Whether one of the 5 x 5 pixels around a place has an ink: lines are thin."""
        x, y = np.floor(self.corner + self.scale * (np.array(point) + 0.5)).astype(int)
        near = self.pixels[y - 2 : y + 3, x - 2 : x + 3]
        return bool((np.abs(near - ink).max(axis=2) < 60).any())

    def mean(self, left, top, right, bottom):
        return self.pixels[top:bottom, left:right].mean(axis=(0, 1))


def is_near(color, other, far=45):
    return bool(np.abs(np.subtract(color, other)).max() < far)


@pytest.fixture
def robot_tool(user_folder):
    with robsim.gui.robot_panel(robot="lab") as tool:
        yield tool


def robot_still(tool):
    height, width = tool.value.image.shape[:2]
    return Still(tool, (width, height))


def test_corners_are_drawn_where_they_are(robot_tool):
    corner = robot_tool.value.markers["right"].polygon[0]
    moved = np.add(corner, (0, 14))
    assert not is_near(robot_still(robot_tool).at(corner), RED_INK, 20)
    robot_tool.message("part", name="red")
    assert is_near(robot_still(robot_tool).at(corner), RED_INK, 20)
    robot_tool.message("move", corner=0, at=moved.tolist(), goes_on=False)
    still = robot_still(robot_tool)
    assert is_near(still.at(moved), RED_INK, 20)
    assert not is_near(still.at(corner), RED_INK, 20)


def test_the_arrow_points_to_where_the_robot_faces(robot_tool):
    robot = robot_tool.value
    robot_tool.message("turn", degrees=90)
    angle = math.radians(-robot.alignment - 90)
    still = robot_still(robot_tool)
    ahead, beside = (
        robot.centre + 40 / still.scale * np.array((math.cos(at), math.sin(at)))
        for at in (angle, angle + math.pi / 2)
    )
    assert is_near(still.at(ahead), WHITE, 130)
    assert not is_near(still.at(beside), WHITE, 130)


def test_the_square_is_drawn_around_what_is_captured(user_folder):
    sim = robsim.Simulation(resolution=(300, 300), seed=1)
    with robsim.gui.robot_panel(sim) as tool:
        tool.message("square", at=[110, 130], side=60)
        still = Still(tool, (300, 300))
        for place in ((80, 130), (140, 130), (110, 100), (110, 160)):
            assert still.has(np.array(place) - 0.5, YELLOW)
        assert not still.has((60, 130), YELLOW)


@pytest.fixture
def color_tool(tmp_path):
    image = np.full((120, 160, 3), FLOOR, np.uint8)
    image[40:60, 40:60] = image[80:90, 100:120] = RED
    with robsim.gui.color_panel(image, file=tmp_path / "colors.toml") as tool:
        yield tool


def color_still(tool):
    return Still(tool, (160, 120))


def level(value):
    return FIRST_LEVEL + (LAST_LEVEL - FIRST_LEVEL) / 256 * value


def test_region_histograms_and_ranges_are_drawn(color_tool):
    before = color_still(color_tool)
    assert is_near(before.at((44, 50)), RED, 20)
    color_tool.message("region", region=[44, 44, 55, 55], keep=0, goes_on=False)
    still = color_still(color_tool)
    assert still.has((43.5, 50), YELLOW)
    assert not before.has((43.5, 50), YELLOW)
    color = color_tool.value[0]
    values = robsim.vision.rgb_to_yuv(np.array([[RED]], np.uint8))[0, 0]
    for name, value in zip("yuv", values, strict=True):
        top, x = ROWS[name] + 8, int(level(value))
        assert is_near(still.mean(x, top, x + 2, top + 40), (89, 98, 110), 60), name
        for end in (getattr(color, name)[0], getattr(color, name)[1] + 1):
            x = round(level(end))
            assert is_near(still.mean(x - 1, top, x + 1, top + 40), ACCENT, 60), (name, end)
        assert is_near(before.mean(x - 1, top, x + 1, top + 40), WHITE), name


def test_the_test_paints_what_belongs_to_a_class(color_tool):
    color_tool.message("region", region=[44, 44, 55, 55], keep=0, goes_on=False)
    painted = color_still(color_tool)
    assert is_near(painted.at((110, 85)), (255, 0, 0), 52)
    assert is_near(painted.at((80, 85)), FLOOR, 12)
    color_tool.message("set", name="tests", value=False, goes_on=False)
    assert is_near(color_still(color_tool).at((110, 85)), RED, 12)


def test_there_is_one_of_a_tool_that_was_closed(color_tool):
    shown = color_tool.snapshot()
    color_tool.close()
    assert color_tool.snapshot() == shown


def test_a_saved_notebook_gets_it_again_when_something_has_changed(color_tool):
    class Notebook(FakeBrowser):
        keeps_still = True

        def keep(self, picture):
            self.transmit({"type": "kept"}, [picture])

    notebook = Notebook(color_tool._view)
    notebook.say("region", region=[44, 44, 55, 55], keep=0, goes_on=False)
    _, (picture,) = notebook.take("kept")
    assert picture == color_tool.snapshot()


def test_the_still_of_a_floor_has_its_points_and_a_grid(tmp_path):
    image = np.full((300, 400, 3), FLOOR, np.uint8)
    with robsim.gui.floor_panel(image, file=tmp_path / "camera.toml") as tool:
        pixels = [(20, 20), (380, 20), (380, 280), (20, 280)]
        places = [(0, 0), (1800, 0), (1800, 1300), (0, 1300)]
        tool.put(pixels, places)
        wait_for(lambda: tool._view._state()["fit"])
        still = np.asarray(Image.open(io.BytesIO(tool.snapshot())).convert("RGB"), float)
        scale = 560 / 400
        for u, v in pixels:
            x, y = round(6 + scale * (u + 0.5)), round(34 + scale * (v + 0.5))
            assert is_near(still[y, x], (94, 224, 138), 30)
        middle = still[34 + 60 : 34 + 360, 6 + 60 : 6 + 500]
        assert (np.abs(middle - FLOOR).max(axis=2) > 60).any()  # the grid
        whole = tool.snapshot()
        tool.clear()
        assert tool.snapshot() != whole
