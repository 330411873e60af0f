"""A robot that no code of ours has drawn: defined from a photo by the mouse, tracked in a video."""

import math

import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageFilter

import robsim
from panel_mouse import ToolMouse
from robsim import Experiment, Recording
from waiting import wait_for

pytestmark = pytest.mark.slow

SIZE = (640, 560)
ORANGE, GREEN = (240, 120, 20), (30, 150, 60)
FRONT, BACK = np.array((30, 2)), np.array((-38, 0))  # px from the middle of the body
FINE = 2  # as large as it becomes, the robot is drawn


def robot():
    """A white body, a nose to the right, orange in front, green behind."""
    image = Image.new("RGBA", (200 * FINE, 200 * FINE), (0, 0, 0, 0))
    pen = ImageDraw.Draw(image)

    def box(left, top, right, bottom, color, radius=0):
        sides = [FINE * side for side in (left, top, right, bottom)]
        pen.rounded_rectangle(sides, FINE * radius, color)

    box(20, 48, 180, 152, (235, 232, 220), 18)
    pen.polygon(
        [(FINE * x, FINE * y) for x, y in ((180, 80), (198, 100), (180, 120))], (60, 60, 60)
    )
    for middle, color in ((100 + FRONT, ORANGE), (100 + BACK, GREEN)):
        box(*(middle - 18), *(middle + 18), color, 18)
    return image


def floor(rng):
    width, height = SIZE
    grains = np.clip(150 + rng.normal(0, 14, (height // 8, width // 8)), 0, 255)
    base = np.asarray(Image.fromarray(grains.astype(np.uint8)).resize(SIZE), float)[..., None]
    light = np.linspace(1.08, 0.8, width)[None, :, None]
    return np.clip(base * light * (1, 0.96, 0.9), 0, 255).astype(np.uint8)


class World:
    """Draws the robot on the floor, with noise."""

    def __init__(self, rng):
        self.rng, self.floor, self.robot = rng, floor(rng), robot()

    def picture(self, x, y, heading):
        """The heading is clockwise from the right, in rad; x, y that of a pixel's centre."""
        turned = self.robot.rotate(-math.degrees(heading), Image.BICUBIC).resize((200, 200))
        left, top = math.floor(x - 99.5), math.floor(y - 99.5)
        shift = (1, 0, left - (x - 99.5), 0, 1, top - (y - 99.5))
        moved = turned.transform((202, 202), Image.AFFINE, shift, Image.BICUBIC)
        image = Image.fromarray(self.floor)
        image.paste(moved, (left, top), moved)
        blurred = np.asarray(image.filter(ImageFilter.GaussianBlur(0.8)), float)
        noisy = blurred + self.rng.normal(0, 4, blurred.shape)
        return np.clip(noisy, 0, 255).astype(np.uint8)


def test_from_a_photo_to_a_video_by_the_mouse(open_tool, user_folder, tmp_path):
    world = World(np.random.default_rng(77))
    x, y, heading = place = (420.0, 330.0, 0.7)
    axes = np.array(
        [(math.cos(heading), math.sin(heading)), (-math.sin(heading), math.cos(heading))]
    )
    front, back = (np.array((x, y)) + offset @ axes for offset in (FRONT, BACK))
    robsim.vision.save_image(tmp_path / "photo.jpg", world.picture(*place))

    with robsim.gui.color_panel(tmp_path / "photo.jpg", file=tmp_path / "mine.toml") as tool:
        mouse = ToolMouse(tool, open_tool(tool))
        for name, middle in (("red", front), ("blue", back)):
            mouse.tab.fill("[name=new_class]", name)
            mouse.tab.keyboard.press("Enter")
            mouse.tab.wait_for_selector(f"[role=radio][aria-checked=true]:has-text('{name}')")
            mouse.drag(middle - 8, middle + 8)
            wait_for(lambda name=name: name in [color.name for color in tool.value])
        mouse.tab.click("[name=save_colors]")
        wait_for((tmp_path / "mine.toml").exists)

    with robsim.gui.robot_panel(tmp_path / "photo.jpg", colors=tmp_path / "mine.toml") as tool:
        mouse = ToolMouse(tool, open_tool(tool))
        view, tab = tool._view, mouse.tab
        mouse.drag(view._square[:2], (x, y))
        wait_for(lambda: np.allclose(view._square[:2], (x, y), atol=3))
        u, v, side = view._square
        tab.wait_for_selector(f"text=around ({u:.0f}, {v:.0f})")
        mouse.drag((u + side / 2, v + side / 2), (u + 115, v + 115))
        wait_for(lambda: abs(view._square[2] - 230) < 8)
        tab.click("[name=capture]")
        tab.wait_for_selector("[name=resume]:visible")
        assert view.drawing.sketch.problems() == []  # all three were guessed
        width = view.drawing.sketch.image.shape[1]
        tab.fill("[name=robot_size]", str(width))  # a pixel is a px
        tab.keyboard.press("Tab")
        wait_for(lambda: view.drawing.sketch.size == width)
        turn = round(-math.degrees(heading))
        for text, degrees in (("\N{MINUS SIGN}10\N{DEGREE SIGN}", -10), ("+1\N{DEGREE SIGN}", 1)):
            for _ in range(4 if degrees == -10 else turn + 40):
                tab.click(f"button:has-text('{text}')")
        wait_for(lambda: abs(view.drawing.sketch.alignment - turn) < 0.1 or None)
        tab.fill("[name=robot_name]", "mine")
        tab.click("[name=save_robot]")
        wait_for(lambda: "mine" in robsim.vision.robot_names())

    poses = []
    (tmp_path / "video").mkdir()
    for k in range(18):
        heading += 0.12 * math.sin(k / 9)
        x, y = x + 6 * math.cos(heading), y + 6 * math.sin(heading)
        poses.append((x, y, heading))
        robsim.vision.save_image(tmp_path / f"video/{k:03}.png", world.picture(x, y, heading))
    trace = Experiment(
        Recording(tmp_path / "video"), robot="mine", colors=tmp_path / "mine.toml", area=SIZE
    ).run()
    assert trace.seen.all()
    off = trace.pose_measured - poses
    # Its centre is that of the outline that was guessed: the same throughout.
    turned = np.array([(math.cos(h), math.sin(h)) for h in np.array(poses)[:, 2]])
    ahead = (off[:, :2] * turned).sum(axis=1)
    aside = off[:, 1] * turned[:, 0] - off[:, 0] * turned[:, 1]
    assert np.std([ahead, aside], axis=1).max() < 0.2
    assert np.abs([ahead.mean(), aside.mean()]).max() < 4
    assert np.degrees(np.std(robsim.wrap_angle(off[:, 2]))) < 0.3
    assert abs(np.degrees(np.mean(robsim.wrap_angle(off[:, 2])))) < 1.5
