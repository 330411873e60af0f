"""The main panel in a tab, as it is used with the mouse, and what it shows then."""

import base64
import re

import numpy as np

from waiting import wait_for

INKS = {  # in the light theme
    "true": (214, 33, 156),
    "measured": (18, 161, 80),
    "estimated": (31, 111, 235),
    "held": (0, 0, 0),
    "accent": (87, 80, 211),
    "red": (229, 72, 77),
    "blue": (59, 130, 246),
}
_BOX = {"left": 44, "right": 9}  # px beside the data of a chart
_PIXELS = (
    "c => [c.width, c.height, btoa(Array.from(c.getContext('2d')"
    ".getImageData(0, 0, c.width, c.height).data, b => String.fromCharCode(b)).join(''))]"
)
_TIP = """new Promise((done) => requestAnimationFrame(() => setTimeout(() => {
  const tip = [...document.querySelectorAll(".robsim-tip")].find((one) => one.checkVisibility());
  const words = (row) => [row.querySelector("span").textContent, row.lastChild.textContent];
  done([tip.querySelector("strong").textContent, ...[...tip.querySelectorAll("div")].map(words)]);
})))"""


def number(text):
    """Return a number as the panel writes it: with a minus, a unit or an error behind it."""
    return float(re.match(r"[-\d.e]+", text.replace("\u2212", "-")).group())


class ToolMouse:
    """A tool in a tab, as it is used with the mouse; places are pixels of its picture."""

    def __init__(self, tool, tab):
        self.tool, self.tab = tool, tab
        self.canvas = tab.locator(".robsim-camera > canvas").first
        wait_for(lambda: tool._view.picture is not None)

    def _measured(self):
        """Return the size of the picture, its rotation (2, 2), its middle, its scale."""
        size = np.array(self.tool._view.picture.frame.image.shape[1::-1])
        turned = np.radians(self.tool._view.state().get("turned", 0))
        rotation = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
        box = self.canvas.bounding_box()
        shown = np.array((box["width"], box["height"]))
        scale = min(shown / (np.abs(rotation) @ size))
        return size, rotation, np.array((box["x"], box["y"])) + shown / 2, scale

    @property
    def scale(self):
        return self._measured()[3]

    def at(self, point):
        """Return the place on the screen of a pixel."""
        size, rotation, middle, scale = self._measured()
        return (middle + scale * rotation @ (np.array(point, float) + 0.5 - size / 2)).tolist()

    def click(self, point):
        self.tab.mouse.click(*self.at(point))

    def drag(self, start, end):
        self.tab.mouse.move(*self.at(start))
        self.tab.mouse.down()
        self.tab.mouse.move(*self.at(end), steps=5)
        self.tab.mouse.up()

    def choose_part(self, part):
        """Choose what of a robot is drawn; the page has it from Python then."""
        self.tab.click(f".robsim-segments [value={part}]")
        self.tab.wait_for_selector(f".robsim-segments [value={part}][aria-checked=true]")


class Mouse:
    """A panel that `open_panel` has opened."""

    def __init__(self, view, tab):
        self.view = view
        self.tab = tab

    @property
    def n_steps(self):
        return self.view.record.n_steps

    def press(self, name):
        """Click a button of the tool bar."""
        self.tab.click(f".robsim-transport [name={name}]")

    def pause(self):
        self.press("pause")
        self.tab.wait_for_selector("main[data-state=paused]")
        shown = self.tab.locator(".robsim-title-step")
        wait_for(lambda: shown.inner_text() == f"step {self.n_steps - 1}")

    def run(self, steps):
        """Start if it does not run, let it do some steps more, and pause."""
        if self.tab.get_attribute("main", "data-state") != "running":
            self.press("start")
        upto = self.n_steps + steps
        wait_for(lambda: self.n_steps >= upto)
        self.pause()

    def choose(self, group, choice):
        """Click one of the choices that stand side by side, and wait until Python has it."""
        segments = self.tab.get_by_role("radiogroup", name=group)
        segments.get_by_role("radio", name=choice, exact=True).click()

    def open(self, tab):
        """Click a tab."""
        self.tab.get_by_role("tab", name=tab, exact=True).click()

    def paint(self):
        painted = "new Promise((done) => requestAnimationFrame(() => setTimeout(done)))"
        self.tab.evaluate(painted)

    def picture(self):
        """Return what is painted of the camera's picture, int (H, W, 3)."""
        return pixels(self.tab.locator(".robsim-camera > canvas"))[..., :3].astype(int)

    def chart(self, label):
        return Chart(self, label)


class Chart:
    """A chart, by the beginning of its label."""

    def __init__(self, mouse, label):
        self.mouse = mouse
        tab = mouse.tab
        self.over = tab.locator(f'canvas[role=slider][aria-label^="{label}"]:visible')

    def inked(self, ink):
        """Return where pixels of a colour are below the title, bool (H, W)."""
        canvas = self.over if ink == "accent" else self.over.locator("xpath=preceding-sibling::*")
        painted = pixels(canvas).astype(int)
        near = np.abs(painted[..., :3] - INKS[ink]).max(axis=2) < 40
        near &= painted[..., 3] > 200
        near[:22] = False
        return near

    def count(self, ink):
        """Return how many pixels of a colour there are."""
        return int(self.inked(ink).sum())

    def marked(self):
        """Return at which part of the width the step that is shown is marked; None: nowhere."""
        lines = np.flatnonzero(self.inked("accent").mean(axis=0) > 0.3)
        width = self.over.bounding_box()["width"] - _BOX["left"] - _BOX["right"]
        return None if not len(lines) else (lines.mean() - _BOX["left"]) / width

    def at(self, part):
        """Return the place on the screen at a part of the width."""
        box = self.over.bounding_box()
        width = box["width"] - _BOX["left"] - _BOX["right"]
        return box["x"] + _BOX["left"] + part * width, box["y"] + box["height"] / 2

    def key(self, *keys):
        """Press keys on it; return what it says then."""
        self.over.focus()
        for key in keys:
            self.mouse.tab.keyboard.press(key)
        self.mouse.paint()
        return self.over.get_attribute("aria-valuetext") or ""

    def read(self, part):
        """Point somewhere; return the step there, and what the tip says: {name: text}."""
        self.mouse.tab.mouse.move(*self.at(part))
        step, *rows = self.mouse.tab.evaluate(_TIP)
        return int(step.split()[1]), dict(rows)


def pixels(canvas):
    """Return the pixels of a canvas, uint8 (H, W, 4)."""
    width, height, text = canvas.evaluate(_PIXELS)
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)
