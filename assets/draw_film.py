"""The film of the README, an editor beside the panel: ./run pictures takes it, in Chromium."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from PIL import Image
from playwright.sync_api import Browser
from playwright.sync_api import Page as Tab

import robsim
from bench_panel.browser import open_chromium
from robsim.gui.hosts.page import Page
from robsim.gui.panels.view import PanelView

_EDITOR = {"width": 400, "height": 560}  # px
_PANEL = {"width": 1180, "height": 860}
_SMALL = 768, 560  # of the panel in the film
_PERIOD = 100  # ms of a picture
_QUALITY = 60
_LIVE = 12  # pictures of the live camera
_CONTROL = """from math import atan2
from robsim import wrap_angle

GOAL = {goal}


def control(step):
    if step.measurement is None:
        return 0, 0
    x, y, heading = step.measurement.pose
    to_goal = atan2(GOAL[1] - y, GOAL[0] - x)
    turn = 0.3 * wrap_angle(to_goal - heading)
    return {speed} + turn, {speed} - turn
"""
_GOALS = "(950, 300)", "(950, 950)"
_PAGE = """<body style="margin:0;background:#1b1e26;color:#dfe3ea;font:15px/1.6 monospace">
<div style="padding:14px 18px;color:#8b93a3">control.py</div>
<pre style="margin:0 18px;font:13.5px/1.75 monospace">{lines}</pre>
<div style="position:absolute;left:18px;bottom:26px;font:600 17px sans-serif">{caption}</div>"""


def film() -> list[Image.Image]:
    """Return the pictures of the film."""
    with TemporaryDirectory() as folder, open_chromium() as browser:
        file = Path(folder, "control.py")
        _write(file, _GOALS[0])
        editor = browser.new_page(viewport=_EDITOR)
        about = {"slots": ("control",), "measure": True}
        simulation = robsim.Simulation.from_folder(
            folder, headings=None, start=(200, 600, 0.5), seed=4, **about
        )
        with _shown(simulation, browser) as (view, tab):
            scenes = _scenes(view, tab, editor, file)
            pictures = [_beside(_shot(editor), _shot(tab)) for _ in scenes]
        _write(file, _GOALS[0])
        _show(editor, file, "In real time: robsim live.")
        world = robsim.Scenario(
            start=(200, 800, 0),
            headings=None,
            resolution=(640, 640),
            noise=robsim.GaussianNoise(8),
            seed=4,
        )
        with (
            robsim.lab.SimulatedLab(world, fps=10) as lab,
            robsim.Camera(lab) as camera,
            robsim.lab.UdpMotors(lab.address) as motors,
            robsim.Experiment.from_folder(
                folder, frames=camera, send=motors, **about
            ) as experiment,
            _shown(experiment, browser) as (view, tab),
        ):
            view.driver.start().result()
            tab.wait_for_selector("main[data-state=running]")
            for _ in range(_LIVE):
                tab.wait_for_timeout(2 * _PERIOD)
                pictures.append(_beside(_shot(editor), _shot(tab)))
            return pictures


@contextmanager
def _shown(runner: Any, browser: Browser) -> Iterator[tuple[PanelView, Tab]]:
    """Show a runner in a tab."""
    view = PanelView(runner)
    page = Page(view)
    tab = browser.new_page(viewport=_PANEL, color_scheme="light")
    try:
        tab.goto(page.url)
        tab.wait_for_selector("main[data-state=paused]")
        yield view, tab
    finally:
        tab.close()
        page.close()
        view.close()


def _scenes(view: PanelView, tab: Tab, editor: Tab, file: Path) -> Iterator[None]:
    """Play the scenes of the film; each yield is a picture."""

    def drive(pictures: int, caption: str, marked: str = "", steps: int = 3) -> Iterator[None]:
        _show(editor, file, caption, marked)
        for _ in range(pictures):
            for _ in range(steps):
                view.driver.step().result()
            tab.wait_for_selector(f"text={view.record.n_steps - 1} / {view.record.n_steps - 1}")
            tab.wait_for_timeout(150)
            yield

    yield from drive(9, "Your Python drives.")
    tab.get_by_role("radiogroup", name="Noise").get_by_text("Gaussian").click()
    tab.get_by_role("slider", name="Noise level", exact=True).fill("20")
    yield from drive(12, "20 % noise: the outline stays.")
    _write(file, _GOALS[1])
    yield from drive(14, "Edit a line: it counts at once.", marked="GOAL = ")
    tab.click("button[name=go_to]")
    box = tab.locator(".robsim-camera > canvas").bounding_box()
    assert box is not None
    tab.mouse.click(box["x"] + 0.2 * box["width"], box["y"] + 0.7 * box["height"])
    yield from drive(15, "Or click: robsim's own goes there.")


def _write(file: Path, goal: str) -> None:
    file.write_text(_CONTROL.format(goal=goal, speed=0.8))


def _show(editor: Tab, file: Path, caption: str, marked: str = "") -> None:
    lines = [
        f'<span style="background:#7a5cff66">{line}</span>' if marked and marked in line else line
        for line in file.read_text().splitlines()
    ]
    editor.set_content(_PAGE.format(lines="\n".join(lines), caption=caption))


def _shot(tab: Tab) -> Image.Image:
    return Image.open(io.BytesIO(tab.screenshot())).convert("RGB")


def _beside(editor: Image.Image, panel: Image.Image) -> Image.Image:
    picture = Image.new("RGB", (editor.width + _SMALL[0], editor.height))
    picture.paste(editor, (0, 0))
    picture.paste(panel.resize(_SMALL, Image.Resampling.LANCZOS), (editor.width, 0))
    return picture


def save(file: Path) -> None:
    """Write the film as a WebP that repeats."""
    first, *rest = film()
    about: dict[str, Any] = {"duration": _PERIOD, "loop": 0, "quality": _QUALITY, "method": 6}
    first.save(file, save_all=True, append_images=rest, **about)
