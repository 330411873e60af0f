"""A host with no Python behind it: shows the module in a browser, and keeps what it says."""

import base64
import io
import json

import numpy as np
from PIL import Image

from chromium_browser import new_tab
from robsim.gui.hosts.script import script, style

ADDRESS = "http://robsim.test/"  # never looked up: an address is what localStorage needs

_DOCUMENT = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<link rel="icon" href="data:,">
<link rel="stylesheet" href="view.css">
<body class="{body}">
<main></main>
<script type="module" src="host.js"></script>
"""
_HOST = """
import view from "./view.js";
if (CHOICES) localStorage.robsim ??= CHOICES;
const listeners = new Set();
const sent = [];
const model = {
  get: () => "panel",
  send: (message) => sent.push(message),
  on: (type, listener) => type == "msg:custom" && listeners.add(listener),
  off: (_, listener) => listeners.delete(listener),
};
const bytes = (text) => {
  const letters = atob(text);
  const found = new Uint8Array(letters.length);
  for (let i = 0; i < found.length; i++) found[i] = letters.charCodeAt(i);
  return found;
};
const el = document.querySelector("main");
window.host = {
  sent,
  emit: (head, texts) => {
    const buffers = texts.map(bytes);
    return Promise.all([...listeners].map((listener) => listener(head, buffers)));
  },
  end: view.render({ model, el }),
};
setInterval(() => host.emit({ type: "alive" }, []), 2000); // as Python does
"""

SETUP = {
    "type": "setup",
    "title": "Simulation",
    "source": "simulation",
    "area": [1200, 1200],
    "dt": 1 / 30,
    "robot": {"name": "lab", "outline": [[40, -25], [40, 25], [-40, 25], [-40, -25]]},
    "colors": [{"name": "red", "css": "#e5484d"}, {"name": "blue", "css": "#3b82f6"}],
    "columns": [],
    "has_truth": True,
    "theta_true": None,
    "controls": [],
    "motors": False,
    "live": False,
    "tools": [],
}
STATE = {
    "type": "state",
    "state": "paused",
    "k": -1,
    "steps": 0,
    "resets": 0,
    "t": 0.0,
    "speed": 5,
    "values": {},
    "animate": False,
    "stage": "world",
    "goal": None,
    "path": None,
    "error": None,
    "camera": None,
    "stopped": False,
    "tool": None,
}
FRAME = {
    "type": "frame",
    "measured": None,
    "held": None,
    "estimate": None,
    "truth": None,
    "boxes": [],
    "missed": None,
    "past": False,
}


class FakeHost:
    """The module in a tab of a browser; `choices` are what that remembers."""

    def __init__(self, chromium, *, body="robsim-page", choices=None, **options):
        self.tab, self.complaints = new_tab(chromium, **options)
        kept = None if choices is None else json.dumps(choices)
        given = f"const CHOICES = {json.dumps(kept)};"
        self._files = {
            "": ("text/html", _DOCUMENT.format(body=body)),
            "view.css": ("text/css", style()),
            "view.js": ("text/javascript", script()),
            "host.js": ("text/javascript", given + _HOST),
        }
        self.tab.route(ADDRESS + "**", self._answer)
        self._n = 0
        self.load()

    def load(self):
        """Open the page, or open it again."""
        self.tab.goto(ADDRESS)
        self.tab.wait_for_selector("main.robsim")

    def emit(self, head, buffers=()):
        """Let Python say something, and let the browser paint it."""
        texts = [base64.b64encode(buffer).decode() for buffer in buffers]
        self.tab.evaluate("([head, buffers]) => host.emit(head, buffers)", [head, texts])
        self.paint()

    def sent(self, kind=None):
        """Return what the browser has said, without its name: all, or the messages of a type."""
        said = self.tab.evaluate("host.sent")
        plain = [{name: m[name] for name in m if name != "id"} for m in said]
        return [m for m in plain if kind in (None, m["type"])]

    def forget(self):
        """Forget what the browser has said."""
        self.tab.evaluate("host.sent.splice(0)")

    def paint(self):
        """Wait until it has painted."""
        painted = "new Promise((done) => requestAnimationFrame(() => setTimeout(done)))"
        self.tab.evaluate(painted)

    def rest(self, ms=100):
        """Let timers of so long run, and what they want be painted: by default `calmPainter`'s."""
        self.tab.evaluate("ms => new Promise((done) => setTimeout(done, ms))", ms + 1)
        self.paint()

    def stop_clock(self):
        """Let no time pass for the module; timers run."""
        self.tab.evaluate("(now => { performance.now = () => now })(performance.now())")

    def setup(self, **fields):
        """Say `SETUP` with other fields."""
        self.emit(SETUP | fields)

    def state(self, **fields):
        """Say `STATE` with other fields."""
        self.emit(STATE | fields)

    def frame(self, k, *, image=None, rows=None, **fields):
        """Say `FRAME` with a picture, uint8 (H, W, 3), and rows, {group of columns: rows}."""
        self._n += 1
        image = np.full((600, 600, 3), 190, np.uint8) if image is None else image
        out = io.BytesIO()
        Image.fromarray(image).save(out, "JPEG")
        entries, blocks = _packed(rows or {})
        own = {"n": self._n, "sent": 0, "k": k, "t": k / 30, "rows": entries}
        own |= {"size": image.shape[1::-1], "map": [1, 0, 0, 0, 1, 0, 0, 0, 1]}
        self.emit(FRAME | own | fields, [out.getvalue(), *blocks])

    def rows(self, rows):
        """Send rows from 0 on, {group of columns: rows}."""
        entries, blocks = _packed(rows)
        self.emit({"type": "rows", "rows": entries}, blocks)

    def close(self):
        """Close the tab; the browser must not have complained."""
        self.tab.context.close()
        assert self.complaints == []

    def _answer(self, route):
        kind, text = self._files[route.request.url.removeprefix(ADDRESS)]
        route.fulfill(body=text, content_type=f"{kind}; charset=utf-8")


def _packed(rows):
    blocks = {name: np.asarray(block, "<f4") for name, block in rows.items()}
    entries = [{"column": n, "first": 0, "width": b.shape[1]} for n, b in blocks.items()]
    return entries, [block.tobytes() for block in blocks.values()]
