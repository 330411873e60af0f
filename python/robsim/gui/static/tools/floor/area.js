// @ts-check
// Size and scale of the work area, the height of the markers, the lens.
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";
import { makeAct, makeNumberField, makePart, makeRow, makeWords, showIn } from "../pieces.js";

const STEPS = { width: "1", height: "1", mm_per_px: "any", marker_height: "any" };

export function makeArea(context) {
  const makeOne = ([name, step]) => makeNumberField(name, (value) =>
    context.send({ type: "set", name, value }),
  { step, className: "robsim-text-field robsim-short", ariaLabel: text(`area.${name}`),
    title: text(`area.${name}.title`) });
  const fields = Object.entries(STEPS).map(makeOne);
  const [width, height, scale, high] = fields;
  const size = make("span", { className: "robsim-quiet robsim-number" });
  const lens = make("span", { className: "robsim-quiet" });
  const forget = makeAct(context, "forget_lens", "", () => ({ type: "forget" }));
  context.on("state", (state) => {
    const values = [...state.area, state.mm_per_px, state.marker_height];
    fields.forEach((field, i) => showIn(field, String(values[i])));
    const metres = state.area.map((side) =>
      String(Number(((side * state.mm_per_px) / 1000).toFixed(2))));
    size.textContent = text("area_size", { width: metres[0], height: metres[1] });
    high.disabled = !state.lens;
    lens.textContent = lensWords(state.lens);
    forget.hidden = !state.lens;
  });
  return makePart(
    makeRow(makeWords("area"), width, makeWords("area_times"), height, makeWords("unit_px"),
      makeWords("area_each"), scale, makeWords("unit_mm"), size),
    makeRow(makeWords("area.marker_height"), high, makeWords("unit_mm")),
    makeRow(lens, forget));
}

function lensWords(lens) {
  if (!lens) return text("lens_unknown");
  return lens.rms == null ? text("lens_known") : text("lens_fits", { rms: lens.rms.toFixed(2) });
}
