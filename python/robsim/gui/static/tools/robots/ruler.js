// Two points of known distance on the picture, from which its size follows.
import { makeTextButton } from "../../base/buttons.js";
import { text } from "../../base/dom.js";
import { distance } from "../../base/geometry.js";
import { drawDot, drawLabel, drawLine } from "../../camera/strokes.js";
import { makeNumberField, makeRow, makeWords } from "../pieces.js";

const REACH_OF_END = 16; // px on the screen
const END = 5; // px on the screen
const RULER_INK = "#fff";

export function makeRuler(context, picture) {
  let isOn = false;
  let ends = []; // up to two, in pixels of the picture

  const button = makeTextButton("ruler", "", () => set(!isOn));
  const tell = () => ends.length == 2 && field.valueAsNumber > 0 &&
    context.send({ type: "scale", one: ends[0], other: ends[1], distance: field.valueAsNumber });
  const field = makeNumberField("ruler_length", tell, { min: "0", placeholder: text("ruler_length"),
    onkeydown: ({ key }) => key == "Escape" && set(false) });
  const words = makeWords("ruler_off");

  const show = () => {
    button.setAttribute("aria-pressed", String(isOn));
    field.hidden = !isOn || ends.length < 2;
    words.textContent = text(!isOn ? "ruler_off" : ends.length < 2 ? "ruler_points" : "ruler_unit");
    button.disabled = context.state.mode != "draw";
    picture.later();
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
  const near = (at) => picture.nearest(at, ends, REACH_OF_END);
  context.on("state", () => (isOn && context.state.mode != "draw" ? set(false) : show()));
  return {
    element: makeRow(button, field, words),
    isOn: () => isOn,
    click: (at) => near(at) < 0 && put(at),
    grab: (at) => {
      const i = near(at);
      return i < 0 ? null : { at: ends[i], move: (to) => (ends[i] = to), drop: tell };
    },
    key: ({ key }) => key == "Escape" && (set(false), true),
    draw: (scene) => isOn && drawRuler(scene, ends, context.state.size),
  };
}

function drawRuler(scene, ends, size) {
  const shown = ends.map(scene.pixel);
  drawLine(scene, shown, RULER_INK, { width: 2 });
  for (const end of shown) drawDot(scene, end, RULER_INK, END);
  if (shown.length < 2) return;
  const long = (distance(ends[0], ends[1]) * size) / scene.frame.size[0];
  const middle = [0, 1].map((i) => (ends[0][i] + ends[1][i]) / 2);
  drawLabel(scene, { at: middle, words: `${long.toFixed(1)} px`, beside: [0, -1], ink: RULER_INK,
    isStrong: true });
}
