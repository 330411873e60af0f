// @ts-check
// The fit of the floor, its problems and its file.
import { make, say } from "../../base/dom.js";
import { text } from "../../base/texts.js";
import { makeAct, makeList, makePart, makeRow, makeTextField, makeVerdict } from "../pieces.js";

/** Figures, and what is said of them. */
export function makeFloorResult(context) {
  const verdict = makeVerdict();
  const figures = make("span", { className: "robsim-number robsim-floor-figures" });
  const problems = makeList();
  const remarks = makeList({ className: "robsim-remarks robsim-quiet" });
  const element = makePart(makeRow(verdict.element, figures), problems.element, remarks.element);
  element.classList.add("robsim-floor-result");
  context.on("state", ({ fit, problems: said, remarks: more, grid, by }) => {
    const kind = fit?.verdict ?? (grid && !said.length ? "known" : "open");
    verdict.show(kind, text(`floor_verdict.${kind}`));
    say(figures, fit ? figuresOf(fit) : "");
    problems.show(said);
    remarks.show(more);
    element.hidden = by == "lens";
  });
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

/** The file that is read and written. */
export function makeFloorFile(context) {
  const file = makeTextField("calibration_file", () => {}, { maxLength: 200 });
  const message = (type) => () => ({ type, file: file.value.trim() });
  const load = makeAct(context, "load_calibration", "", message("load"));
  const save = makeAct(context, "save_calibration", "robsim-primary", message("save"));
  let known = "";
  context.on("state", (state) => {
    if (state.file != known) file.value = known = state.file;
    save.disabled = Boolean(state.cannot_save);
    save.title = state.cannot_save || text("save_calibration.title");
  });
  const row = makeRow(file, load, save);
  row.classList.add("robsim-floor-file");
  return row;
}
