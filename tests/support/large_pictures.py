"""How long a picture of 12 megapixels takes: ``python tests/support/large_pictures.py``.

Times are those of the page in Chromium, from the event of the mouse to the picture that has it.
"""

import io
import shutil
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

import robsim
from browsers import FakeBrowser
from drops import drag_file
from robsim.gui._tools.uploads import MOST_OF_A_PART

SIZE = 4000, 3000  # px
SCALE = 10  # camera's px of the photograph for one of the simulated one
TIMES = 5
#: Wait until the pixel at a place of the canvas (shares of it) fulfils a condition; then the time.
WATCH = """([event, x, y]) => {
    const canvas = document.querySelector(".robsim-camera canvas");
    const holds = (r, g, b) => CONDITION;
    window.found = null;
    const look = (start) => {
        const at = [Math.round(x * canvas.width), Math.round(y * canvas.height)];
        const [r, g, b] = canvas.getContext("2d").getImageData(...at, 1, 1).data;
        if (holds(r, g, b)) window.found = performance.now() - start;
        else requestAnimationFrame(() => look(start));
    };
    addEventListener(event, () => look(performance.now()), { capture: true, once: true });
}"""
GAPS = """() => {
    window.gaps = [];
    let last = performance.now();
    const tick = (now) => { gaps.push(now - last); last = now; requestAnimationFrame(tick); };
    requestAnimationFrame((now) => { last = now; requestAnimationFrame(tick); });
}"""


def photo():
    """A robot on a floor as a camera of 12 megapixels sees it, with its noise: a JPEG."""
    area = SIZE[0] // SCALE, SIZE[1] // SCALE
    middle = area[0] / 2, area[1] / 2, 0.0
    small = robsim.Simulation(robot="lab", area=area, start=middle, seed=2).step().frame.image
    large = np.array(Image.fromarray(small).resize(SIZE, Image.Resampling.BICUBIC), float)
    noisy = large + np.random.default_rng(1).normal(0, 4, (*large.shape[:2], 1))
    out = io.BytesIO()
    pixels = np.clip(noisy, 0, 255).astype(np.uint8)
    Image.fromarray(pixels).save(out, "JPEG", quality=92)
    return pixels, out.getvalue()


def told(name, values):
    middle = np.median(values)
    print(f"{name:44s} {min(values):5.0f} .. {max(values):.0f} ms, median {middle:.0f}")


class Tab:
    """A tool in a tab of its own, and the canvas there."""

    def __init__(self, chromium, tool):
        self.tab = chromium.new_context(viewport={"width": 1440, "height": 900}).new_page()
        self.tab.goto(tool.url)
        self.tab.wait_for_selector("main[data-state]")
        self.tab.wait_for_timeout(500)
        self.box = self.tab.locator(".robsim-camera canvas").bounding_box()

    def timed(self, event, place, condition, act):
        self.tab.evaluate(WATCH.replace("CONDITION", condition), [event, *place])
        act()
        while (found := self.tab.evaluate("window.found")) is None:
            self.tab.wait_for_timeout(100)
        return found

    def point(self, x, y):
        return self.box["x"] + x * self.box["width"], self.box["y"] + y * self.box["height"]

    def place(self, u, v):
        """Where a pixel of a picture of 4 : 3 is, in shares of the canvas."""
        return (u + 0.5) / SIZE[0], (1 - 0.75) / 2 + 0.75 * (v + 0.5) / SIZE[1]


def drops(chromium, tool, file, shown, back):
    """Times from the drop to the first pixels of the picture, which is taken away in between."""
    tab = Tab(chromium, tool)
    times = []
    for _ in range(TIMES):
        times.append(tab.timed("drop", *shown, lambda: drag_file(tab.tab, file)))
        tab.tab.click(back)
        tab.tab.wait_for_timeout(500)
    tab.tab.context.close()
    return times


def regions(chromium, tool, pixels):
    """Times from the end of a drag over the red marker to its mask."""
    tab = Tab(chromium, tool)
    is_red = pixels[..., 0].astype(int) - pixels[..., 2] > 90
    v, u = np.argwhere(is_red).mean(axis=0)
    x, y = tab.place(u, v)
    times = []
    for _ in range(TIMES):
        tool.value = [robsim.ColorClass("nothing", v=(0, 0))]
        tab.tab.wait_for_timeout(500)
        tab.tab.mouse.move(*tab.point(x - 0.008, y - 0.008))
        tab.tab.mouse.down()

        def act():
            tab.tab.mouse.move(*tab.point(x + 0.008, y + 0.008))
            tab.tab.mouse.up()

        times.append(tab.timed("pointermove", (x, y), "r > 225 && g < 40 && b < 40", act))
    tab.tab.context.close()
    return times


def corners(chromium, tool):
    """Gaps between the frames of the page while a corner is dragged."""
    tab = Tab(chromium, tool)
    corner = tool._view.drawing.sketch.outline[0] * (SIZE[0] / 1000)
    x, y = tab.point(*tab.place(*corner))
    tab.tab.mouse.move(x, y)
    tab.tab.mouse.down()
    tab.tab.evaluate(GAPS)
    for i in range(60):
        tab.tab.mouse.move(x + 0.3 * i, y)
    tab.tab.mouse.up()
    gaps = tab.tab.evaluate("window.gaps")
    tab.tab.context.close()
    return gaps


def live_gaps(view, content):
    """Gaps between the frames of a live tool while a picture is loaded into another one."""
    sim = robsim.Simulation(robot="lab", seed=1)
    panel = robsim.panel(sim, speed=6.0)  # 30 frames a second
    with robsim.gui.color_panel(sim) as live:
        browser = FakeBrowser(live._view, 500)
        FakeBrowser(panel._view, 500).press("start")
        gaps, is_over = {True: [], False: []}, threading.Event()
        loads = threading.Event()

        def watch():
            last = None
            while not is_over.is_set():
                browser.take("frame")
                now = time.perf_counter()
                if last is not None:
                    gaps[loads.is_set()].append(1000 * (now - last))
                last = now

        watcher = threading.Thread(target=watch)
        watcher.start()
        time.sleep(3)
        loads.set()
        other = FakeBrowser(view, 500, name="other")
        for n in range(TIMES):
            assert other.upload(content, key=str(n), part=MOST_OF_A_PART)["state"] == "taken"
        loads.clear()
        is_over.set()
        watcher.join()
    panel.close()
    return gaps


def main():
    pixels, content = photo()
    print(f"{SIZE[0]} x {SIZE[1]} px, JPEG of {len(content) / 1e6:.1f} MB")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = Path(folder) / "large.jpg"
        file.write_bytes(content)
        chromium = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        green = np.full((90, 120, 3), (10, 200, 10), np.uint8)
        in_color = (0.5, 0.3), "Math.abs(r - g) < 60 && r > 60"
        beside = (0.5, 0.05), "r > 200"  # a robot's picture is square, and grey there
        with robsim.gui.color_panel(green, file=Path(folder) / "c.toml") as tool:
            told("colours: drop to picture", drops(chromium, tool, file, in_color, "[name=back]"))
            tool.load(file)
            told("colours: region to mask", regions(chromium, tool, pixels))
            gaps = live_gaps(tool._view, content)
            told("frames of a live tool, alone", gaps[False])
            told("frames of a live tool, while it is loaded", gaps[True])
        with robsim.gui.robot_panel(robot="sheep") as tool:
            times = drops(chromium, tool, file, beside, "[name=no_camera]")
            told("robots: drop to picture", times)
            tool.load(file)
            start = time.perf_counter()
            tool.capture(whole=True)
            told(
                "robots: whole picture, with first guesses", [1000 * (time.perf_counter() - start)]
            )
            told("robots: frames of the page in a drag", corners(chromium, tool))
        chromium.close()


if __name__ == "__main__":
    sys.exit(main())
