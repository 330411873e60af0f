// @ts-check
// The two magnifying glasses: one beside the pointer, and one on the chosen point, in which it is
// dragged by parts of a pixel.
import { ARROWS } from "../../base/arrows.js";
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";
import { makeGlass } from "./glass.js";

const HOVER_ZOOM = 8; // px of the screen for one of the camera
const BESIDE = 22; // px on the screen, from the pointer to the glass
const ZOOMS = [2, 4, 8, 16, 32];

/** The one beside the pointer: `show(pixel, at)`, `at` on the canvas of the picture; null hides. */
export function makeHoverGlass(context, crosses, below) {
  const cross = { at: null, ink: "#ffffff", isIt: true };
  const glass = makeGlass(context, { glass: 0, zoom: () => HOVER_ZOOM,
    marks: () => [...crosses().filter(({ isIt }) => !isIt), { ...cross, at: glass.middle() }] });
  const { canvas } = glass;
  canvas.classList.add("robsim-glass-hover", "robsim-away");
  canvas.setAttribute("aria-hidden", "true");
  const place = ([x, y]) => {
    const side = canvas.offsetWidth;
    const { clientWidth, clientHeight } = below();
    const room = matchMedia("(pointer: coarse)").matches ? 2 * BESIDE : BESIDE;
    const left = x + room + side < clientWidth ? x + room : x - room - side;
    const top = y - room - side > 0 ? y - room - side : y + room;
    const inside = (at, most) => Math.max(4, Math.min(at, most - side - 4));
    canvas.style.left = `${inside(left, clientWidth)}px`;
    canvas.style.top = `${inside(top, clientHeight)}px`;
  };
  return {
    canvas,
    show: (pixel, at) => {
      canvas.classList.toggle("robsim-away", !pixel);
      if (pixel && at) place(at.map((side) => side / devicePixelRatio));
      glass.show(pixel);
    },
  };
}

/** The one on the chosen point. */
export function makeChosenGlass(context, marks) {
  let zoom = 8;
  const glass = makeGlass(context, { glass: 1, zoom: () => zoom, marks: marks.crosses,
    label: text("glass_label") });
  const { canvas } = glass;
  Object.assign(canvas, { tabIndex: 0 });
  canvas.setAttribute("role", "application");
  canvas.classList.add("robsim-glass-chosen");
  const words = make("output", { className: "robsim-number robsim-quiet" });
  const zooms = make("output", { className: "robsim-number robsim-quiet" });
  const zoomBy = (steps) => {
    const to = ZOOMS.indexOf(zoom) + steps;
    zoom = ZOOMS[Math.min(Math.max(to, 0), ZOOMS.length - 1)];
    zooms.textContent = `${zoom}\u00d7`;
    glass.zoomed();
  };
  zoomBy(0);
  const show = () => {
    const at = marks.chosenAt();
    element.hidden = !at;
    if (!at) return;
    // While it is dragged, the ground stands still and the cross moves.
    if (!isDragged) glass.show(at);
    words.textContent = text("point_at",
      { number: context.state.chosen, u: at[0].toFixed(2), v: at[1].toFixed(2) });
  };
  let isDragged = false;
  listenToGlass(canvas, {
    begin: () => {
      isDragged = marks.chosenAt() != null;
      return marks.chosenAt();
    },
    move: (at) => {
      marks.moveTo(context.state.chosen, at);
      glass.later();
      show();
    },
    end: () => {
      isDragged = false;
      marks.letGo();
      show();
    },
    zoom: () => zoom,
    zoomBy,
    key: (event) => {
      if (event.key in ARROWS && marks.chosenAt()) marks.nudge(event);
      else if (event.key == "Delete" || event.key == "Backspace") marks.cut();
      else if (event.key == "+" || event.key == "=") zoomBy(1);
      else if (event.key == "-") zoomBy(-1);
      else return false;
      return true;
    },
  });
  const row = make("div", { className: "robsim-tool-row robsim-glass-words" }, words, zooms);
  const element = make("div", { className: "robsim-glass-box", hidden: true }, canvas, row);
  context.on("state", show);
  return { element };
}

function listenToGlass(canvas, { begin, move, end, zoom, zoomBy, key }) {
  let from = null; // {x, y, at}: where the drag began, and where the point was
  canvas.onpointerdown = (event) => {
    const at = !event.button && begin();
    if (!at) return;
    canvas.setPointerCapture(event.pointerId);
    from = { x: event.clientX, y: event.clientY, at };
  };
  canvas.onpointermove = (event) => {
    if (!from) return;
    const [du, dv] = [event.clientX - from.x, event.clientY - from.y].map((by) => by / zoom());
    if (du || dv) move([from.at[0] + du, from.at[1] + dv]);
  };
  canvas.onpointerup = canvas.onpointercancel = () => {
    if (from) end();
    from = null;
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(event.deltaY < 0 ? 1 : -1);
  }, { passive: false });
  canvas.onkeydown = (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !key(event)) return;
    event.preventDefault();
    event.stopPropagation();
  };
}
