// A magnifying glass on the camera's picture: the pixels around a point as the camera has them.
import { asBytes } from "../base/buffers.js";
import { fitCanvas, make, painter } from "../base/dom.js";

const GLASS_GRID = 7; // magnification from which pixels have edges.
const SLACK = 10; // pixels of the camera beyond the glass, for moving it.
const MOST_HALF = 100; // pixels of the camera to each side
const ANSWER_PATIENCE = 400; // ms, after which it is asked again

/**
 * A magnifying glass: the camera's own pixels around a point. `glass` is its number; `zoom()` how
 * many px of the screen a pixel of the camera is; `over(view)` draws on it, where `view.at(pixel)`
 * is; `imageOf(box, buffers)` makes the image of an answer. It shows nothing until `show(at)`.
 */
export function makeGlass(context, { glass, zoom, over, label = "", imageOf = plainImage }) {
  const canvas = make("canvas.robsim-glass", { ariaLabel: label });
  let middle = null; // the pixel in its middle
  const later = painter(() => paint());
  const half = () => {
    const side = Math.max(canvas.clientWidth, canvas.clientHeight);
    return Math.min(Math.ceil(side / zoom() / 2) + SLACK, MOST_HALF);
  };
  const detail = makeDetail(context, { glass, half, imageOf, changed: later });
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
    over(view);
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

/**
 * The pixels around a point as the camera has them: asked of Python, always for the newest point,
 * and one answer after the other.
 * `glass` is its number, which comes back with the answer; `half()` how many pixels it wants to
 * each side; `changed` is called after each answer.
 */
function makeDetail(context, { glass, half, imageOf, changed }) {
  let wanted = null; // [u, v]
  let isAsked = false; // and there was no answer yet
  let isOld = true; // whether point or picture have changed since the request
  let timer = 0;
  const detail = { box: null, image: null };
  const ask = () => {
    const reach = half();
    if (!wanted || isAsked || !isOld || !Number.isFinite(reach)) return; // hidden by a tool
    [isAsked, isOld] = [true, false];
    timer = setTimeout(() => {
      isAsked = false;
      again();
    }, ANSWER_PATIENCE);
    context.send({ type: "magnify", at: wanted, half: reach, glass });
  };
  context.on("detail", (head, buffers) => {
    if (head.glass != glass) return;
    clearTimeout(timer);
    isAsked = false;
    Object.assign(detail, { box: head.box, image: imageOf(head.box, buffers.map(asBytes)) });
    changed();
    ask();
  });
  /** Request the same point again, such as with more surroundings. */
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

/** The image of pixels that come as red, green, blue; null without pixels. */
const plainImage = (box, [colors]) => imageFrom(box, (i) => colors.subarray(3 * i, 3 * i + 3));

/** Return a canvas with the colours of the pixels of a box; null without pixels. */
export function imageFrom([, , width, height], colorOf) {
  if (!width || !height) return null;
  const pixels = new ImageData(width, height);
  for (let i = 0; i < width * height; i++) {
    pixels.data.set(colorOf(i), 4 * i);
    pixels.data[4 * i + 3] = 255;
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return canvas;
}
