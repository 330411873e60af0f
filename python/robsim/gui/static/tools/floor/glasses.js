// The two magnifying glasses: one beside the pointer, and one on the chosen point, in which it is
// dragged by parts of a pixel.
import { asBytes } from "../../base/buffers.js";
import { fitCanvas, make, painter, text } from "../../base/dom.js";
import { listenToDrags, listenToKeys } from "../../base/gestures.js";
import { drawCross } from "../../camera/strokes.js";
import { makeRow } from "../pieces.js";

const HOVER_ZOOM = 8; // px of the screen for one of the camera
const BESIDE = 22; // px on the screen, from the pointer to the glass
const ZOOMS = [2, 4, 8, 16, 32];
const GLASS_GRID = 7; // times as large: from here on the pixels have edges
const SLACK = 10; // pixels of the camera beyond the glass, for when it is moved
const MOST_HALF = 100; // pixels of the camera to each side
const ANSWER_PATIENCE = 400; // ms, after which it is asked again

/** The one beside the pointer: `show(pixel, where)` on the canvas `below`; null hides it. */
export function makeHoverGlass(context, crosses, below) {
  const cross = { at: null, ink: "#ffffff", isIt: true };
  const glass = makeGlass(context, { glass: 0, zoom: () => HOVER_ZOOM,
    marks: () => [...crosses().filter(({ isIt }) => !isIt), { ...cross, at: glass.middle() }] });
  const { canvas } = glass;
  canvas.classList.add("robsim-glass-hover", "robsim-away");
  canvas.setAttribute("aria-hidden", "true");
  const place = ([x, y]) => {
    const side = canvas.offsetWidth;
    const { clientWidth, clientHeight } = below;
    const room = matchMedia("(pointer: coarse)").matches ? 2 * BESIDE : BESIDE;
    const left = x + room + side < clientWidth ? x + room : x - room - side;
    const top = y - room - side > 0 ? y - room - side : y + room;
    const inside = (at, most) => Math.max(4, Math.min(at, most - side - 4));
    canvas.style.left = `${inside(left, clientWidth)}px`;
    canvas.style.top = `${inside(top, clientHeight)}px`;
  };
  return {
    canvas,
    show: (pixel, where) => {
      canvas.classList.toggle("robsim-away", !pixel);
      if (pixel && where) place(where.map((side) => side / devicePixelRatio));
      glass.show(pixel);
    },
  };
}

/** The one on the chosen point. */
export function makeChosenGlass(context, picture, marks) {
  let zoom = 8;
  let isStill = false; // while a point is dragged in it: the cross moves, the ground does not
  const glass = makeGlass(context, { glass: 1, zoom: () => zoom, marks: marks.crosses,
    label: text("glass_label") });
  const { canvas } = glass;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.classList.add("robsim-glass-chosen");
  const [words, zooms] = [1, 2].map(() => make("output.robsim-number.robsim-quiet"));
  const zoomBy = (steps) => {
    const to = ZOOMS.indexOf(zoom) + steps;
    zoom = ZOOMS[Math.min(Math.max(to, 0), ZOOMS.length - 1)];
    zooms.textContent = `${zoom}\u00d7`;
    glass.zoomed();
  };
  zoomBy(0);
  const show = () => {
    const { at, key: number } = marks.chosen() ?? {};
    element.hidden = !at;
    if (!at) return;
    if (!isStill) glass.show(at);
    words.textContent = text("point_at", { number, u: at[0].toFixed(2), v: at[1].toFixed(2) });
  };
  listenToDrags(canvas, ({ clientX, clientY }) => {
    const point = marks.chosen();
    if (!point) return null;
    isStill = picture.hold(point);
    const move = (event) => {
      const by = [event.clientX - clientX, event.clientY - clientY];
      if (by.some(Boolean)) picture.move(point.at.map((side, i) => side + by[i] / zoom));
      glass.later();
      show();
    };
    const drop = () => {
      isStill = false;
      picture.drop();
      show();
    };
    return { move, drop };
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(event.deltaY < 0 ? 1 : -1);
  }, { passive: false });
  const keys = { "+": 1, "=": 1, "-": -1 };
  listenToKeys(canvas, (event) => {
    if (!keys[event.key]) return marks.press(event);
    zoomBy(keys[event.key]);
  });
  const row = makeRow(words, zooms);
  row.classList.add("robsim-glass-words");
  const element = make("div.robsim-glass-box", { hidden: true }, canvas, row);
  context.on("state", show);
  return element;
}

/**
 * A magnifying glass: the camera's own pixels around a point, and the points with their crosses.
 * `glass` is its number; `zoom()` how many px of the screen a pixel of the camera is; `marks()` the
 * points, [{at, ink, isIt}]. It shows nothing until `show(at)`.
 */
function makeGlass(context, { glass, zoom, marks, label = "" }) {
  const canvas = make("canvas.robsim-glass", { ariaLabel: label });
  let middle = null; // the pixel in its middle
  const later = painter(() => paint());
  const half = () => {
    const side = Math.max(canvas.clientWidth, canvas.clientHeight);
    return Math.min(Math.ceil(side / zoom() / 2) + SLACK, MOST_HALF);
  };
  const detail = makeDetail(context, { glass, half, changed: later });
  const paint = () => {
    if (!middle || !context.frame?.picture || !canvas.clientWidth) return;
    fitCanvas(canvas);
    const scale = zoom() * devicePixelRatio;
    const view = {
      pen: canvas.getContext("2d"), scale, unit: devicePixelRatio,
      at: ([u, v]) => [
        canvas.width / 2 + (u - middle[0]) * scale, canvas.height / 2 + (v - middle[1]) * scale,
      ],
    };
    paintGround(view, canvas, context.frame);
    if (detail.image) paintDetail(view, detail);
    for (const mark of marks()) paintCross(view, mark);
  };
  context.on("frame state", later);
  return {
    canvas,
    later,
    middle: () => middle,
    zoomed: () => (detail.again(), later()),
    show: (at) => {
      middle = at;
      detail.want(at);
      later();
    },
  };
}

/** The picture as it was sent, which is coarser, wherever there are no pixels yet. */
function paintGround({ pen, scale, at }, canvas, { picture, size }) {
  pen.fillStyle = "#222";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  const side = Math.floor(size[0] / picture.width) * scale;
  const [left, top] = at([-0.5, -0.5]);
  pen.imageSmoothingEnabled = true;
  pen.drawImage(picture, left, top, picture.width * side, picture.height * side);
}

function paintDetail({ pen, scale, at, unit }, { box, image }) {
  const [left, top] = at([box[0] - 0.5, box[1] - 0.5]);
  pen.imageSmoothingEnabled = scale < GLASS_GRID * unit;
  pen.drawImage(image, left, top, box[2] * scale, box[3] * scale);
}

function paintCross(view, { at, ink, isIt }) {
  const [x, y] = view.at(at);
  drawCross(view, [x, y], ink, { long: isIt ? 400 : 9, width: 1.2 });
  view.pen.fillStyle = ink;
  view.pen.fillRect(x - view.unit / 2, y - view.unit / 2, view.unit, view.unit);
}

/**
 * The pixels around a point as the camera has them: asked of Python, always for the newest point,
 * and one answer after the other.
 * `glass` is its number, which comes back with the answer; `half()` how many pixels it wants to
 * each side; `changed` is told of each answer.
 */
function makeDetail(context, { glass, half, changed }) {
  let wanted = null; // [u, v]
  let isAsked = false; // and there was no answer yet
  let isOld = true; // another point, or another picture, than was asked for
  let timer = 0;
  const detail = { box: null, image: null };
  const ask = () => {
    if (!wanted || isAsked || !isOld) return;
    [isAsked, isOld] = [true, false];
    timer = setTimeout(() => {
      isAsked = false;
      again();
    }, ANSWER_PATIENCE);
    context.send({ type: "magnify", at: wanted, half: half(), glass });
  };
  context.on("detail", (head, [buffer]) => {
    if (head.glass != glass) return;
    clearTimeout(timer);
    isAsked = false;
    Object.assign(detail, { box: head.box, image: imageOf(head.box, asBytes(buffer)) });
    changed();
    ask();
  });
  /** Ask for the same point again, such as for more around it. */
  const again = () => {
    isOld = true;
    ask();
  };
  const want = (at) => {
    if (at && wanted && at[0] == wanted[0] && at[1] == wanted[1]) return;
    wanted = at;
    again();
  };
  context.on("frame", again);
  context.onEnd(() => clearTimeout(timer));
  return Object.assign(detail, { want, again });
}

/** Return a canvas with pixels that come as red, green, blue; null where there are none. */
function imageOf([, , width, height], bytes) {
  if (!width || !height) return null;
  const pixels = new ImageData(width, height);
  for (let i = 0, at = 0; i < bytes.length; i += 3, at += 4) {
    pixels.data.set(bytes.subarray(i, i + 3), at);
    pixels.data[at + 3] = 255;
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return canvas;
}
