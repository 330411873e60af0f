// @ts-check
// How well the floor fits, what is wrong or missing, the work area, the file.
import { makeTextButton } from "../../base/buttons.js";
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";

export const VERDICT_LOOKS = { good: "robsim-good", poor: "robsim-warning", bad: "robsim-bad" };

/** Figures, and what is said of them. */
export function makeFloorResult(context) {
  const chip = make("span", { className: "robsim-chip", role: "status" });
  const figures = make("span", { className: "robsim-number robsim-floor-figures" });
  const problems = make("ul", { className: "robsim-problems", role: "status" });
  const remarks = make("ul", { className: "robsim-remarks robsim-quiet" });
  context.on("state", ({ fit, problems: said, remarks: more, grid }) => {
    const kind = fit?.verdict ?? (grid && !said.length ? "known" : "open");
    chip.className = `robsim-chip ${VERDICT_LOOKS[kind] ?? ""}`;
    setWords(chip, text(`floor_verdict.${kind}`));
    setWords(figures, fit ? figuresOf(fit) : "");
    setItems(problems, said);
    setItems(remarks, more);
  });
  const row = make("div", { className: "robsim-tool-row" }, chip, figures);
  const element = make("div", { className: "robsim-tool-part robsim-floor-result" }, row, problems,
    remarks);
  context.on("state", ({ by }) => (element.hidden = by == "lens"));
  return element;
}

function figuresOf(fit) {
  const values = {
    rms: fit.rms.toFixed(2), mm: fit.rms_mm.toFixed(1), count: fit.count,
    worst: fit.worst, worst_mm: fit.worst_mm.toFixed(1),
    expected: fit.expected?.toFixed(1),
  };
  const words = [text("floor_rms", values), text("floor_worst", values)];
  if (fit.expected != null) words.push(text("floor_expected", values));
  return words.join(" \u00b7 ");
}

export function setWords(element, words) {
  if (element.textContent != words) element.textContent = words;
}

export function setItems(list, words) {
  const shown = [...list.children].map(({ textContent }) => textContent);
  list.hidden = !words.length;
  if (shown.join("\n") == words.join("\n")) return;
  list.replaceChildren(...words.map((textContent) => make("li", { textContent })));
}

/** Size and scale of the work area, the height of the markers, the lens. */
export function makeFloorArea(context) {
  const field = (name, step) => {
    const input = make("input", { type: "number", className: "robsim-text-field robsim-short",
      name, step, ariaLabel: text(`area.${name}`), title: text(`area.${name}.title`) });
    input.onchange = () => Number.isFinite(input.valueAsNumber) &&
      context.send({ type: "set", name, value: input.valueAsNumber });
    input.onkeydown = (event) => event.stopPropagation();
    return input;
  };
  const fields = {
    width: field("width", "1"), height: field("height", "1"),
    mm_per_px: field("mm_per_px", "any"), marker_height: field("marker_height", "any"),
  };
  const size = make("span", { className: "robsim-quiet robsim-number" });
  const lens = make("span", { className: "robsim-quiet" });
  const forget = makeTextButton("forget_lens", "", () => context.send({ type: "forget" }));
  context.on("state", (state) => {
    const values = { width: state.area[0], height: state.area[1], mm_per_px: state.mm_per_px,
      marker_height: state.marker_height };
    for (const [name, input] of Object.entries(fields))
      if (document.activeElement != input) input.value = String(values[name]);
    const metres = state.area.map((side) =>
      String(Number(((side * state.mm_per_px) / 1000).toFixed(2))));
    size.textContent = text("area_size", { width: metres[0], height: metres[1] });
    fields.marker_height.disabled = !state.lens;
    lens.textContent = lensWords(state.lens);
    forget.hidden = !state.lens;
  });
  const words = (id) => make("span", { className: "robsim-quiet", textContent: text(id) });
  const row = (...parts) => make("div", { className: "robsim-tool-row" }, ...parts);
  return make("div", { className: "robsim-tool-part" },
    row(words("area"), fields.width, words("area_times"), fields.height, words("unit_px"),
      words("area_each"), fields.mm_per_px, words("unit_mm"), size),
    row(words("area.marker_height"), fields.marker_height, words("unit_mm")),
    row(lens, forget));
}

function lensWords(lens) {
  if (!lens) return text("lens_unknown");
  return lens.rms == null ? text("lens_known") : text("lens_fits", { rms: lens.rms.toFixed(2) });
}

/** The file that is read and written. */
export function makeFloorFile(context) {
  const file = make("input", { className: "robsim-text-field", name: "calibration_file",
    maxLength: 200, ariaLabel: text("calibration_file") });
  const tell = (type) => () => context.send({ type, file: file.value.trim() });
  const load = makeTextButton("load_calibration", "", tell("load"));
  const save = makeTextButton("save_calibration", "robsim-primary", tell("save"));
  file.onkeydown = (event) => event.stopPropagation();
  let known = "";
  context.on("state", (state) => {
    if (state.file != known) file.value = known = state.file;
    save.disabled = Boolean(state.cannot_save);
    save.title = state.cannot_save || text("save_calibration.title");
  });
  return make("div", { className: "robsim-tool-row robsim-floor-file" }, file, load, save);
}
