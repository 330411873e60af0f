// A magnifying glass: the camera's own pixels around a point, and the points with their crosses.
import { asBytes } from "../../base/buffers.js";
import { fitCanvas, make, painter } from "../../base/dom.js";
import { drawCross } from "../../camera/strokes.js";

const GLASS_GRID = 7; // times as large: from here on the pixels have edges
const SLACK = 10; // pixels of the camera beyond the glass, for when it is moved
const MOST_HALF = 100; // pixels of the camera to each side
const ANSWER_PATIENCE = 400; // ms, after which it is asked again

/**
 * `glass` is its number; `zoom()` how many px of the screen a pixel of the camera is; `marks()` the
 * points, [{at, ink, isIt}]. It shows nothing until `show(at)`.
 */
export function makeGlass(context, { glass, zoom, marks, label = "" }) {
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
