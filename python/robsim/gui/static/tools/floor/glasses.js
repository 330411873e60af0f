// The two magnifying glasses: one beside the pointer, and one on the chosen point, in which it is
// dragged by parts of a pixel.
import { make, text } from "../../base/dom.js";
import { listenToDrags, listenToKeys } from "../../base/gestures.js";
import { makeGlass } from "../../camera/glass.js";
import { drawCross } from "../../camera/strokes.js";
import { makeRow } from "../pieces.js";

const HOVER_ZOOM = 8; // px of the screen for one of the camera
const BESIDE = 22; // px on the screen, from the pointer to the glass
const ZOOMS = [2, 4, 8, 16, 32];

/** The one beside the pointer: `show(pixel, where)` on the canvas `below`; null hides it. */
export function makeHoverGlass(context, crosses, below) {
  const cross = { at: null, ink: "#ffffff", isIt: true };
  const marks = () => [...crosses().filter(({ isIt }) => !isIt), { ...cross, at: glass.middle() }];
  const glass = makeGlass(context, { glass: 0, zoom: () => HOVER_ZOOM, over: crossing(marks) });
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
  const glass = makeGlass(context, { glass: 1, zoom: () => zoom,
    over: crossing(marks.crosses), label: text("glass_label") });
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

/** Return what draws the crosses of points, [{at, ink, isIt}], on a glass. */
const crossing = (marks) => (view) => marks().forEach((mark) => paintCross(view, mark));

function paintCross(view, { at, ink, isIt }) {
  const [x, y] = view.at(at);
  drawCross(view, [x, y], ink, { long: isIt ? 400 : 9, width: 1.2 });
  view.pen.fillStyle = ink;
  view.pen.fillRect(x - view.unit / 2, y - view.unit / 2, view.unit, view.unit);
}
