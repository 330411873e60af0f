// @ts-check
// A magnifying glass: the camera's own pixels around a point, and the points with their crosses.
import { fitCanvas, make, painter } from "../../base/dom.js";
import { drawCross } from "../../camera/strokes.js";
import { makeDetail } from "./detail.js";

const GLASS_GRID = 7; // times as large: from here on the pixels have edges
const SLACK = 10; // pixels of the camera beyond the glass, for when it is moved
const MOST_HALF = 100; // pixels of the camera to each side

/**
 * `glass` is its number; `zoom()` how many px of the screen a pixel of the camera is; `marks()` the
 * points, [{at, ink, isIt}]. It shows nothing until `show(at)`.
 */
export function makeGlass(context, { glass, zoom, marks, label = "" }) {
  const canvas = make("canvas", { className: "robsim-glass", ariaLabel: label });
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
  context.onEnd(later.cancel);
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
