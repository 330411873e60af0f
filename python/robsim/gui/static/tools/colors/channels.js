// The histograms of Y, U and V of a region, with the ranges of a class, whose ends are dragged.
import { asFloats } from "../../base/buffers.js";
import { fitCanvas, make, painter, text } from "../../base/dom.js";
import { heldValue } from "../../base/fields.js";
import { ARROWS, listenToDrags, listenToKeys } from "../../base/gestures.js";

const CHANNELS = ["y", "u", "v"];
const LEVELS = 256;
const GRIP = 12; // px beside an end that take it

/** Make the channels' editor; Python receives three [lower, upper], both included. */
export function makeChannels(context) {
  let counts = null; // 3 x 256
  let ranges = null; // of the chosen class
  const canvases = CHANNELS.map((name) =>
    make("canvas.robsim-channel", { tabIndex: 0, role: "slider",
      ariaLabel: text(`channel.${name}`) }));
  const outputs = CHANNELS.map(() => make("output.robsim-number"));
  const countsOf = (i) => counts?.subarray(LEVELS * i, LEVELS * (i + 1));
  const later = painter(() => canvases.forEach((canvas, i) =>
    paintChannel(canvas, context.ink, countsOf(i), ranges?.[i])));
  const show = (shown) => {
    ranges = shown;
    outputs.forEach((output, i) => {
      output.textContent = ranges ? ranges[i].join("\u2009–\u2009") : "–";
      canvases[i].setAttribute("aria-valuetext", output.textContent);
    });
    later();
  };
  const held = heldValue(show, (next, goesOn) =>
    context.send({ type: "ranges", ranges: next, goes_on: goesOn }));
  const setEnd = (i, end, level) => {
    const next = ranges.map((range) => [...range]);
    const inside = Math.min(Math.max(Math.round(level), 0), LEVELS - 1);
    next[i][end] = end == 0 ? Math.min(inside, next[i][1]) : Math.max(inside, next[i][0]);
    held.set(next);
  };
  canvases.forEach((canvas, i) => listen(canvas, { hold: held.hold, range: () => ranges?.[i],
    set: (end, level) => setEnd(i, end, level) }));

  context.on("histograms", (_, [buffer]) => {
    counts = asFloats(buffer);
    later();
  });
  context.on("state", ({ region, classes, chosen }) => {
    held.tell(classes.find(({ name }) => name == chosen)?.ranges ?? null);
    if (!region) counts = null;
    later();
  });
  context.on("theme", later);
  const resizes = new ResizeObserver(later);
  canvases.forEach((canvas) => resizes.observe(canvas));
  const rows = CHANNELS.map((name, i) =>
    make("div.robsim-channel-row", { title: text(`channel.${name}.title`) },
      make("span.robsim-quiet", { textContent: name.toUpperCase() }),
      canvases[i], outputs[i]));
  return make("div.robsim-channels", ...rows);
}

/** Let the ends of a range be dragged; arrow keys move the lower one, with Shift the upper one. */
function listen(canvas, { hold, range, set }) {
  const level = ({ clientX }) => {
    const { left, width } = canvas.getBoundingClientRect();
    return ((clientX - left) / width) * LEVELS - 0.5;
  };
  /** The nearest end, and how far away it is (px). */
  const nearest = (event) => {
    const to = level(event);
    const away = range().map((value) => Math.abs(value - to) * (canvas.clientWidth / LEVELS));
    const end = away[0] < away[1] || (away[0] == away[1] && to < range()[0]) ? 0 : 1;
    return [end, away[end]];
  };
  canvas.addEventListener("pointermove", (event) => {
    const isNear = range() && nearest(event)[1] < GRIP;
    canvas.style.cursor = isNear ? "ew-resize" : "default";
  });
  listenToDrags(canvas, (event) => {
    if (!range()) return null;
    const [end] = nearest(event);
    hold();
    set(end, level(event));
    return { move: (to) => set(end, level(to)) };
  });
  listenToKeys(canvas, ({ key, shiftKey }) => {
    if (!(key in ARROWS) || !range()) return false;
    const [right, down] = ARROWS[key];
    const end = shiftKey ? 1 : 0;
    set(end, range()[end] + right - down);
  });
}

function paintChannel(canvas, ink, counts, range) {
  fitCanvas(canvas);
  const { width, height } = canvas;
  const pen = canvas.getContext("2d");
  pen.fillStyle = ink("raised");
  pen.fillRect(0, 0, width, height);
  const x = (level) => (level / LEVELS) * width;
  if (range) {
    pen.fillStyle = ink("accent-soft");
    pen.fillRect(x(range[0]), 0, x(range[1] + 1) - x(range[0]), height);
  }
  if (counts) paintBars(pen, counts, { x, height, fill: ink("quiet") });
  if (!range) return;
  const line = 2 * devicePixelRatio;
  pen.fillStyle = ink("accent");
  for (const at of [x(range[0]), x(range[1] + 1)])
    pen.fillRect(Math.min(Math.max(at - line / 2, 0), width - line), 0, line, height);
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
