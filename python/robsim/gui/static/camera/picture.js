// @ts-check
// A picture on a canvas: zoomed, moved, drawn on. What else the pointer does there is its owner's.
import { makeTextButton } from "../base/buttons.js";
import { fitCanvas, make, painter } from "../base/dom.js";
import { text } from "../base/texts.js";
import { color } from "../base/theme.js";
import { makeHands } from "./hands.js";
import { makeLens } from "./lens.js";
import { makeWidthTeller } from "./width.js";

// times as large as they are, the pixels of a picture are to be seen as such
const COARSE_PIXELS = 3;

/**
 * Show the picture of `context.frame`. The owner gives `label`, a name in the texts; `inks`, names
 * of colours; the `hands` on it, see hands.js, an array that may still grow.
 */
export function makePicture(context, { label, inks = [], hands }) {
  const canvas = make("canvas", { tabIndex: 0, role: "application", ariaLabel: text(label) });
  const lens = makeLens();
  const colors = {};
  const paint = () => paintPicture(context, { canvas, lens, colors, draw: handed.draw });
  const later = painter(paint);
  const widths = makeWidthTeller(context, () => shownWidth(context, canvas, lens));

  const whole = makeTextButton("zoom_reset", "", () => zoomed(lens.reset));
  whole.ariaLabel = whole.title;
  whole.hidden = true;
  const zoomed = (zoom) => {
    zoom();
    whole.hidden = lens.zoom == 1;
    whole.textContent = `${lens.zoom.toFixed(1)}\u00d7`;
    changed();
    widths.tell();
  };
  const handed = makeHands(context, hands, { canvas, lens, later, zoomed });
  /** A finger scrolls the page unless the picture has something to do with it. */
  const changed = () => {
    canvas.style.touchAction = lens.zoom == 1 && !handed.drags() ? "pan-y" : "none";
    const cursor = lens.zoom > 1 ? "grab" : "default";
    canvas.style.cursor = handed.isOn() ? "crosshair" : cursor;
    later();
  };

  const fit = () => {
    if (!fitCanvas(canvas)) return;
    paint();
    widths.tell();
  };
  const resizes = new ResizeObserver(fit);
  resizes.observe(canvas);
  const recolor = () => {
    for (const name of [...inks, "sunken"]) colors[name] = color(context.el, `--robsim-${name}`);
    later();
  };
  context.on("setup local theme", recolor);
  context.on("state", changed);
  context.on("frame", paint); // at once: an animation frame later would be one more
  context.on("frame", widths.tell);
  context.onEnd(() => resizes.disconnect(), later.cancel);
  return { ...handed, canvas, lens, whole, later, changed, width: () => (fit(), widths.first()) };
}

function paintPicture(context, { canvas, lens, colors, draw }) {
  const pen = canvas.getContext("2d");
  pen.fillStyle = colors.sunken ?? "gray";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  const { frame, setup } = context;
  if (!frame?.picture || !setup) return;
  lens.fit([canvas.width, canvas.height], frame.size);
  const [width, height] = frame.size.map((side) => side * lens.scale);
  pen.imageSmoothingEnabled = width < COARSE_PIXELS * frame.picture.width;
  drawWhole(pen, frame, lens);
  pen.save();
  pen.beginPath();
  pen.rect(lens.left, lens.top, width, height);
  pen.clip();
  draw({ pen, context, frame, lens, colors, unit: devicePixelRatio, pixel: lens.toCanvas });
  pen.restore();
}

/** Draw the picture, of which each pixel is some whole number of the camera's, without a rest. */
function drawWhole(pen, { picture, size }, { left, top, scale }) {
  const side = Math.floor(size[0] / picture.width) * scale;
  pen.drawImage(picture, left, top, picture.width * side, picture.height * side);
}

/** How wide the picture is on the screen, in device pixels; no wider than the camera's. */
function shownWidth({ frame }, canvas, lens) {
  if (!frame?.picture) return canvas.width > 1 ? canvas.width : 0;
  return Math.min(Math.round(frame.size[0] * lens.scale), frame.size[0]);
}
