"""The panel for everybody: names, contrast, the focus, motion, and fingers."""

import pytest

import robsim

pytestmark = pytest.mark.slow

TABS = ("Traces", "Parameters", "Callbacks", "Inspector", "Estimate", "Scenario")
_SEEN = """
const isSeen = (e) => e.checkVisibility({ opacityProperty: true, visibilityProperty: true })
  && e.getBoundingClientRect().width > 0;
const controls = () => [...document.querySelectorAll(
  "button, input, select, summary, a[href], [tabindex='0']")].filter(isSeen);
"""
#: Controls without a name for a screen reader.
_NAMELESS = (
    "() => {"
    + _SEEN
    + """
  const nameOf = (e) => e.ariaLabel || e.getAttribute("aria-labelledby") || e.innerText?.trim()
    || [...(e.labels ?? [])].map((label) => label.innerText).join("").trim();
  return controls().filter((e) => !nameOf(e)).map((e) => e.outerHTML.slice(0, 120));
}"""
)
#: Texts with a contrast below 4.5. Disabled ones and those on a picture may have less.
_FAINT = (
    "() => {"
    + _SEEN
    + """
  const pen = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
  const paint = (colors) => {
    pen.clearRect(0, 0, 1, 1);
    for (const color of colors) {
      pen.fillStyle = color;
      pen.fillRect(0, 0, 1, 1);
    }
    return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3);
  };
  const light = (pixel) => {
    const linear = pixel.map((v) => v / 255)
      .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  };
  const found = new Set();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const [e, words] = [walker.currentNode.parentElement, walker.currentNode.data.trim()];
    if (!words || !isSeen(e) || e.closest("script, option, .robsim-camera, .robsim-off")) continue;
    if (e.closest(":disabled, [aria-disabled=true]")) continue;
    const grounds = [];
    for (let at = e; at; at = at.parentElement) {
      grounds.unshift(getComputedStyle(at).backgroundColor);
    }
    const [ground, ink] = [paint(grounds), paint([...grounds, getComputedStyle(e).color])];
    const [low, high] = [light(ground), light(ink)].sort((a, b) => a - b);
    const ratio = (high + 0.05) / (low + 0.05);
    if (ratio < 4.5) found.add(`${e.className}: ${words.slice(0, 40)} ${ratio.toFixed(2)}`);
  }
  return [...found];
}"""
)
_SMALL = (
    "() => {"
    + _SEEN
    + """
  return controls().filter((e) => e.matches("button, select") && !e.matches("[role=radio]"))
    .filter((e) => Math.min(e.offsetWidth, e.offsetHeight) < 24)
    .map((e) => e.outerHTML.slice(0, 120));
}"""
)
_FOCUS = """() => {
  const { outlineStyle, outlineWidth } = getComputedStyle(document.activeElement);
  return [document.activeElement.outerHTML.slice(0, 120), outlineStyle, parseFloat(outlineWidth)];
}"""
_MOVING = """() => [...document.querySelectorAll(".robsim *")].filter((e) => {
  const { transitionDuration, animationDuration } = getComputedStyle(e);
  return [transitionDuration, animationDuration].some((all) => all.split(", ").some(
    (one) => parseFloat(one) > 0.01));
}).map((e) => e.className)"""


@pytest.fixture
def page(open_panel):
    """Return a function that shows a run of some steps in a theme."""

    def show(theme="light", **options):
        sim = robsim.Simulation(measure=True, control=robsim.DriveAround(), seed=1)
        sim.run(5)
        return open_panel(sim, theme=theme, **options)[1]

    return show


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_all_controls_have_names_and_all_texts_contrast(page, theme):
    tab = page(theme)
    faults = {}
    for name in TABS:
        tab.click(f"[role=tab]:text-is('{name}')")
        faults[name] = tab.evaluate(_NAMELESS) + tab.evaluate(_FAINT)
    assert {name: found for name, found in faults.items() if found} == {}


def test_the_focus_is_seen_wherever_the_key_tab_goes(page):
    tab = page()
    for _ in range(40):
        tab.keyboard.press("Tab")
        element, style, width = tab.evaluate(_FOCUS)
        assert style != "none", element
        assert width >= 1, element


def test_nothing_moves_for_those_who_want_no_motion(page):
    tab = page()
    tab.emulate_media(reduced_motion="reduce")
    assert tab.evaluate(_MOVING) == []


def test_fingers_hit_each_button(page):
    tab = page(has_touch=True, is_mobile=True)
    faults = {}
    for name in TABS:
        tab.click(f"[role=tab]:text-is('{name}')")
        faults[name] = tab.evaluate(_SMALL)
    assert {name: found for name, found in faults.items() if found} == {}
