"""The picture of the panel in the README: ./run pictures takes it, in Chromium."""

from __future__ import annotations

import io
import time
from typing import Any

from PIL import Image
from playwright.sync_api import Page as Tab

import robsim
from bench_panel.browser import open_chromium
from robsim.gui.hosts.page import Page
from robsim.gui.panels.view import PanelView

_WINDOW = {"width": 1440, "height": 900}
_STEPS = 400
_EXACT, _OTHERS = 6, 96  # colours
_PATIENCE = 30.0  # s


def panel_picture() -> tuple[Image.Image, list[str]]:
    """Return the panel of a run as Chromium shows it, and the texts in it."""
    view = PanelView(_simulation())
    page = Page(view)
    try:
        with open_chromium() as browser:
            tab = browser.new_page(viewport=_WINDOW, color_scheme="light")
            tab.goto(page.url)
            tab.get_by_role("radiogroup", name="State estimation").get_by_text("Default").click()
            for _ in range(_STEPS):
                view.driver.step().result()
            picture = _settled(tab)
            tab.locator("select").evaluate_all("all => all.forEach((menu) => menu.remove())")
            texts = tab.inner_text("body").splitlines()  # without what is folded away
    finally:
        page.close()
        view.close()
    return picture, [text.strip() for text in texts if text.strip()]


def small(image: Image.Image) -> Image.Image:
    """Return a picture of the panel in few colours; its grounds are kept exactly."""
    counts: Any = image.getcolors(image.width * image.height)
    most = [rgb for _, rgb in sorted(counts, reverse=True)[:_EXACT]]
    kind = Image.Quantize.FASTOCTREE  # it keeps rare colours
    others = image.quantize(_OTHERS, kind, dither=Image.Dither.NONE).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette([level for rgb in most for level in rgb] + others[: 3 * _OTHERS])
    return image.quantize(palette=palette, dither=Image.Dither.NONE)


def _simulation() -> robsim.Simulation:
    return robsim.Simulation(
        robot="lab",
        control=robsim.DriveAround(),
        measure=True,
        estimate_parameters=True,
        headings=None,
        process_noise=robsim.WheelNoise(0.1),
        dropout=robsim.Dropout(0.02, 6),
        seed=4,
    )


def _settled(tab: Tab) -> Image.Image:
    """Return what is shown when nothing changes any more, and all has come."""
    tab.wait_for_selector("main[data-state=paused]")
    tab.wait_for_selector(f"text={_STEPS - 1} / {_STEPS - 1}")
    until = time.monotonic() + _PATIENCE
    before = b""
    while (now := tab.screenshot()) != before:
        if time.monotonic() > until:
            raise TimeoutError("the panel does not come to rest")
        before = now
        tab.wait_for_timeout(1000)
    return Image.open(io.BytesIO(now)).convert("RGB")
