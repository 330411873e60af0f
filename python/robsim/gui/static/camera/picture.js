// A picture on a canvas: zoomed, moved, drawn on. What else the pointer does there is its owner's.
import { makeTextButton } from "../base/buttons.js";
import { fitCanvas, make, painter, text } from "../base/dom.js";
import { makeHands } from "./hands.js";

// times as large as they are, the pixels of a picture are to be seen as such
const COARSE_PIXELS = 3;
const USUAL_CAMERA_WIDTH = 600; // px, where nothing is laid out yet
const SIZE_REST = 200; // ms without a change before Python gets the size
const MOST_ZOOM = 20; // times

/**
 * Show the picture of `context.frame`. The owner gives `label`, a name in the texts, and the
 * `hands` on it, see hands.js, an array that may still grow. `state.turned` turns it (degrees,
 * clockwise), but not under a hand that holds something.
 */
export function makePicture(context, { label, hands }) {
  const canvas = make("canvas", { tabIndex: 0, role: "application", ariaLabel: text(label) });
  const lens = makeLens();
  const paint = () => {
    if (!handed.isHeld()) lens.turn(((context.state.turned ?? 0) * Math.PI) / 180);
    paintPicture(context, { canvas, lens, draw: handed.draw });
  };
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
  /** A finger scrolls the page unless the picture uses the gesture. */
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
  new ResizeObserver(fit).observe(canvas);
  context.on("setup local theme", later);
  context.on("state", changed);
  context.on("frame", paint); // at once: an animation frame later would be one more
  context.on("frame", widths.tell);
  return { ...handed, canvas, lens, whole, later, changed, width: () => (fit(), widths.first()) };
}

function paintPicture(context, { canvas, lens, draw }) {
  const pen = canvas.getContext("2d");
  pen.fillStyle = context.ink("sunken");
  pen.fillRect(0, 0, canvas.width, canvas.height);
  const { frame, setup } = context;
  if (!frame?.picture || !setup) return;
  lens.fit([canvas.width, canvas.height], frame.size);
  const [width, height] = lens.size.map((side) => side * lens.scale);
  pen.imageSmoothingEnabled = width < COARSE_PIXELS * frame.picture.width;
  drawWhole(pen, frame, lens);
  pen.save();
  pen.beginPath();
  pen.rect(lens.left, lens.top, width, height);
  pen.clip();
  const [{ ink }, unit] = [context, devicePixelRatio];
  draw({ pen, context, frame, lens, ink, unit, pixel: lens.toCanvas });
  pen.restore();
}

/** Draw the picture in whole pixels: each covers a whole number of the camera's pixels. */
function drawWhole(pen, { picture, size }, { toCanvas, angle, scale }) {
  const side = Math.floor(size[0] / picture.width) * scale;
  pen.save();
  pen.translate(...toCanvas([-0.5, -0.5]));
  pen.rotate(angle);
  pen.drawImage(picture, 0, 0, picture.width * side, picture.height * side);
  pen.restore();
}

/** How wide the picture is on the screen, in device pixels; no wider than the camera's. */
function shownWidth({ frame }, canvas, lens) {
  if (canvas.width <= 1) return 0; // it is hidden, as under a tool
  if (!frame?.picture) return canvas.width;
  return Math.min(Math.round(frame.size[0] * lens.scale), frame.size[0]);
}

/** How wide the picture is on the screen (device pixels): as fine as Python needs to send it. */
function makeWidthTeller(context, width) {
  let told = 0;
  let wanted = 0;
  let timer = 0;
  const known = () => width() || Math.round(USUAL_CAMERA_WIDTH * devicePixelRatio);
  const send = () => {
    if (!context.setup || known() == told) return;
    context.send({ type: "size", width: (told = known()) });
    // comes again too
    if (context.looking != null) context.send({ type: "look", k: context.looking });
  };
  return {
    /** The fields of hello. */
    first: () => (told = known()),
    tell: () => {
      if (known() == wanted) return; // frames come faster than the rest is long
      wanted = known();
      clearTimeout(timer);
      timer = setTimeout(send, SIZE_REST);
    },
  };
}

/**
 * Where the camera's pixels, counted at their centres, lie on the canvas, which has device pixels:
 * letterboxed, zoomed, moved, turned.
 */
function makeLens() {
  const lens = { zoom: 1, scale: 1, left: 0, top: 0, angle: 0, size: [1, 1] }; // of it turned
  let box = [1, 1]; // of the canvas
  let own = [1, 1]; // size of the picture
  let [cos, sin] = [1, 0];
  let middle = [0.5, 0.5]; // the picture point in the middle, as parts of the picture

  const hold = (i, zoomed) => {
    // half of what there is room for
    const shown = Math.min(box[i] / zoomed, lens.size[i]) / lens.size[i] / 2;
    return Math.min(Math.max(middle[i], shown), 1 - shown);
  };
  const place = () => {
    const { size } = lens;
    lens.scale = lens.zoom * Math.min(box[0] / size[0], box[1] / size[1]);
    middle = [hold(0, lens.scale), hold(1, lens.scale)];
    lens.left = Math.round(box[0] / 2 - middle[0] * size[0] * lens.scale);
    lens.top = Math.round(box[1] / 2 - middle[1] * size[1] * lens.scale);
  };

  lens.fit = (newBox, newSize) => {
    [box, own] = [newBox, newSize];
    const [width, height] = own;
    const [c, s] = [Math.abs(cos), Math.abs(sin)];
    lens.size = [width * c + height * s, width * s + height * c];
    place();
  };
  lens.turn = (angle) => {
    lens.angle = angle;
    [cos, sin] = [Math.cos(angle), Math.sin(angle)].map((part) => Number(part.toFixed(12)));
  };
  lens.toCanvas = ([u, v]) => {
    const [right, down] = [u + 0.5 - own[0] / 2, v + 0.5 - own[1] / 2]; // of the middle
    const [x, y] = [right * cos - down * sin, right * sin + down * cos];
    return [lens.left + (x + lens.size[0] / 2) * lens.scale,
      lens.top + (y + lens.size[1] / 2) * lens.scale];
  };
  /** Return a step on the screen as one in the picture. */
  lens.turnedBack = ([x, y]) => [x * cos + y * sin, y * cos - x * sin];
  lens.toPixel = ([x, y]) => {
    const place = [(x - lens.left) / lens.scale, (y - lens.top) / lens.scale];
    const [right, down] = lens.turnedBack(place.map((at, i) => at - lens.size[i] / 2));
    return [right + own[0] / 2 - 0.5, down + own[1] / 2 - 0.5];
  };
  lens.holds = ([x, y]) => {
    const [u, v] = lens.toPixel([x, y]);
    return u >= -0.5 && v >= -0.5 && u < own[0] - 0.5 && v < own[1] - 0.5;
  };

  /** Move the picture by so many pixels of the canvas. */
  lens.move = ([dx, dy]) => {
    const { size } = lens;
    middle = [middle[0] - dx / (lens.scale * size[0]), middle[1] - dy / (lens.scale * size[1])];
    place();
  };
  /** Zoom around a fixed point of the canvas. */
  lens.zoomAt = (at, factor) => {
    const [u, v] = lens.toPixel(at);
    lens.zoom = Math.min(Math.max(lens.zoom * factor, 1), MOST_ZOOM);
    place();
    const [x, y] = lens.toCanvas([u, v]);
    lens.move([at[0] - x, at[1] - y]);
  };
  lens.reset = () => {
    lens.zoom = 1;
    place();
  };
  return lens;
}
