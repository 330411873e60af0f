// @ts-check
// The histograms of Y, U and V of a region, with the ranges of a class, whose ends are dragged.
import { asFloats } from "../../base/buffers.js";
import { make, painter } from "../../base/dom.js";
import { heldValue } from "../../base/held_value.js";
import { text } from "../../base/texts.js";
import { color } from "../../base/theme.js";

const CHANNELS = ["y", "u", "v"];
const LEVELS = 256;
const HEIGHT = 72; // px
const GRIP = 12; // px beside an end that take it

/** `tell(ranges)` is told three [lower, upper], both included. */
export function makeChannels(context, tell) {
  let counts = null; // 3 x 256
  let ranges = null;
  const canvases = CHANNELS.map((name) =>
    make("canvas", { className: "robsim-channel", tabIndex: 0, role: "slider",
      ariaLabel: text(`channel.${name}`) }));
  const outputs = CHANNELS.map(() => make("output", { className: "robsim-number" }));
  const paint = () => canvases.forEach((canvas, i) =>
    paintChannel(canvas, context.el, counts?.subarray(LEVELS * i, LEVELS * (i + 1)), ranges?.[i]));
  const later = painter(paint);
  const show = (shown) => {
    ranges = shown;
    outputs.forEach((output, i) => {
      output.textContent = ranges ? ranges[i].join("\u2009–\u2009") : "–";
      canvases[i].setAttribute("aria-valuetext", output.textContent);
    });
    later();
  };
  // Compared as texts: Python's answer is another array.
  const held = heldValue(make("span"), (words) => show(words && JSON.parse(words)),
    (words) => tell(JSON.parse(words)));
  const setEnd = (i, end, level) => {
    const next = ranges.map((range) => [...range]);
    next[i][end] = end == 0 ? Math.min(level, next[i][1]) : Math.max(level, next[i][0]);
    held.set(JSON.stringify(next));
  };
  canvases.forEach((canvas, i) => listen(canvas, () => ranges?.[i], (end, level) =>
    setEnd(i, end, Math.min(Math.max(Math.round(level), 0), LEVELS - 1))));

  context.on("histograms", (_, [buffer]) => {
    counts = asFloats(buffer);
    later();
  });
  context.on("state", ({ region }) => {
    if (region) return;
    counts = null;
    later();
  });
  context.on("theme", later);
  const resizes = new ResizeObserver(later);
  canvases.forEach((canvas) => resizes.observe(canvas));
  context.onEnd(() => resizes.disconnect());
  context.onEnd(later.cancel);
  context.onEnd(held.end);
  const rows = CHANNELS.map((name, i) =>
    make("div", { className: "robsim-channel-row", title: text(`channel.${name}.title`) },
      make("span", { className: "robsim-quiet", textContent: name.toUpperCase() }),
      canvases[i], outputs[i]));
  return {
    element: make("div", { className: "robsim-channels" }, ...rows),
    show: (told) => held.tell(told ? JSON.stringify(told) : null),
  };
}

/** Let the ends of a range be dragged; arrow keys move the lower one, with Shift the upper one. */
function listen(canvas, range, set) {
  let end = null;
  const level = (event) => {
    const box = canvas.getBoundingClientRect();
    return ((event.clientX - box.left) / box.width) * LEVELS - 0.5;
  };
  const nearest = (event) => {
    if (!range()) return null;
    const box = canvas.getBoundingClientRect();
    const away = range().map((value) => Math.abs(value - level(event)) * (box.width / LEVELS));
    const found = away[0] < away[1] || (away[0] == away[1] && level(event) < range()[0]) ? 0 : 1;
    return away[found] < GRIP || event.type == "pointerdown" ? found : null;
  };
  canvas.onpointerdown = (event) => {
    if (event.button) return;
    end = nearest(event);
    if (end == null) return;
    canvas.setPointerCapture(event.pointerId);
    set(end, level(event));
  };
  canvas.onpointermove = (event) => {
    canvas.style.cursor = nearest(event) == null ? "default" : "ew-resize";
    if (end != null) set(end, level(event));
  };
  canvas.onpointerup = canvas.onpointercancel = () => (end = null);
  canvas.onkeydown = (event) => {
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (!step || !range()) return;
    event.preventDefault();
    event.stopPropagation();
    const which = event.shiftKey ? 1 : 0;
    set(which, range()[which] + step);
  };
}

function paintChannel(canvas, el, counts, range) {
  const ratio = devicePixelRatio;
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.round(HEIGHT * ratio);
  if (canvas.width != width || canvas.height != height)
    [canvas.width, canvas.height] = [width, height];
  const pen = canvas.getContext("2d");
  const ink = (name) => color(el, `--robsim-${name}`);
  pen.fillStyle = ink("raised");
  pen.fillRect(0, 0, width, height);
  const x = (level) => (level / LEVELS) * width;
  if (range) {
    pen.fillStyle = ink("accent-soft");
    pen.fillRect(x(range[0]), 0, x(range[1] + 1) - x(range[0]), height);
  }
  if (counts) paintBars(pen, counts, { x, height, fill: ink("quiet") });
  if (!range) return;
  pen.fillStyle = ink("accent");
  for (const at of [x(range[0]), x(range[1] + 1)])
    pen.fillRect(Math.min(Math.max(at - ratio, 0), width - 2 * ratio), 0, 2 * ratio, height);
}

function paintBars(pen, counts, { x, height, fill }) {
  const most = Math.max(...counts, 1);
  pen.fillStyle = fill;
  counts.forEach((count, level) => {
    if (!count) return;
    // few pixels are to be seen, too
    const high = Math.max(Math.sqrt(count / most) * (height - 4), 2);
    pen.fillRect(x(level), height - high, Math.max(x(level + 1) - x(level), 1), high);
  });
}
