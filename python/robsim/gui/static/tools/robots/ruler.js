// @ts-check
// Two points of known distance on the picture, from which its size follows.
import { makeTextButton } from "../../base/buttons.js";
import { make } from "../../base/dom.js";
import { distance } from "../../base/geometry.js";
import { text } from "../../base/texts.js";

const REACH_OF_END = 16; // px on the screen
const END = 5; // px on the screen

/** `picture()` has the lens and asks for paint. */
export function makeRuler(context, picture) {
  let isOn = false;
  let ends = []; // up to two, in pixels of the picture
  let held = -1; // the end that is dragged

  const field = make("input", { type: "number", className: "robsim-text-field", min: "0",
    name: "ruler_length", step: "any", ariaLabel: text("ruler_length"),
    placeholder: text("ruler_length") });
  const button = makeTextButton("ruler", "", () => set(!isOn));
  const words = make("span", { className: "robsim-quiet" });
  const element = make("div", { className: "robsim-tool-row" }, button, field, words);

  const show = () => {
    button.setAttribute("aria-pressed", String(isOn));
    field.hidden = !isOn || ends.length < 2;
    words.textContent = text(!isOn ? "ruler_off" : ends.length < 2 ? "ruler_points" : "ruler_unit");
    button.disabled = context.state.mode != "draw";
    picture()?.later();
  };
  const set = (on) => {
    isOn = on;
    ends = [];
    show();
  };
  const put = (at) => {
    ends = ends.length < 2 ? [...ends, at] : [at];
    show();
    if (ends.length < 2) return;
    field.value = "";
    field.focus();
  };
  const tell = () => {
    if (ends.length < 2 || !(field.valueAsNumber > 0)) return;
    context.send({ type: "scale", one: ends[0], other: ends[1], distance: field.valueAsNumber });
  };
  field.onchange = tell;
  field.onkeydown = (event) => {
    event.stopPropagation();
    if (event.key == "Escape") set(false);
  };
  const near = (at) => ends.findIndex((end) =>
    distance(picture().lens.toCanvas(end), at) < REACH_OF_END * devicePixelRatio);
  context.on("state", () => (isOn && context.state.mode != "draw" ? set(false) : show()));
  return {
    element,
    isOn: () => isOn,
    click: (at) => near(at) < 0 && picture().lens.holds(at) && put(picture().lens.toPixel(at)),
    dragStart: (at) => {
      held = near(at);
      return held >= 0;
    },
    drag: (to) => {
      ends[held] = picture().lens.toPixel(to);
      picture().later();
    },
    dragEnd: () => {
      if (held >= 0) tell();
      held = -1;
    },
    giveUp: () => (held = -1),
    key: (event) => event.key == "Escape" && (set(false), true),
    draw: (scene) => isOn && drawRuler(scene, ends, context.state.size),
  };
}

function drawRuler({ pen, pixel, unit, frame }, ends, size) {
  const shown = ends.map(pixel);
  pen.beginPath();
  shown.forEach(([x, y]) => pen.lineTo(x, y));
  for (const [width, color] of [[4, "#000a"], [2, "#fff"]]) {
    pen.lineWidth = width * unit;
    pen.strokeStyle = color;
    pen.stroke();
  }
  for (const [x, y] of shown) {
    pen.beginPath();
    pen.arc(x, y, END * unit, 0, 2 * Math.PI);
    pen.fillStyle = "#fff";
    pen.fill();
    pen.lineWidth = 1.5 * unit;
    pen.strokeStyle = "#000";
    pen.stroke();
  }
  if (shown.length < 2 || !frame) return;
  const long = (distance(ends[0], ends[1]) * size) / frame.size[0];
  const [[ax, ay], [bx, by]] = shown;
  pen.font = `600 ${13 * unit}px system-ui, sans-serif`;
  pen.textAlign = "center";
  pen.lineWidth = 4 * unit;
  pen.strokeStyle = "#000a";
  pen.fillStyle = "#fff";
  const at = [(ax + bx) / 2, (ay + by) / 2 - 10 * unit];
  pen.strokeText(`${long.toFixed(1)} px`, ...at);
  pen.fillText(`${long.toFixed(1)} px`, ...at);
}
