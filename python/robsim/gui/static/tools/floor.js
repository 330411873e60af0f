// The panel that calibrates a floor: points on its picture, under a magnifying glass, or sheets.
import { makeRadios } from "../base/buttons.js";
import { make, say, text } from "../base/dom.js";
import { makeField } from "../base/fields.js";
import { drawBoards, makeLensBoard } from "./floor/board.js";
import { makeChosenGlass, makeHoverGlass } from "./floor/glasses.js";
import { makeGrid, pixelToPlace } from "./floor/grid.js";
import { makeMarks, timesOf } from "./floor/marks.js";
import { makePointBar, makePointTable, makeSheets } from "./floor/points.js";
import { makeAct, makeFields, makeHint, makeList, makeNumberField, makePart, makeRow,
  makeTextField, makeVerdict, makeWords, showIn } from "./pieces.js";
import { renderTool } from "./tool.js";

const WAYS = ["points", "sheets", "lens"];
const STEPS = { width: "1", height: "1", mm_per_px: "any", marker_height: "any" };

export const renderFloor = (host) => renderTool(host, "floor", (tool) => {
  const { context, picture, film } = tool;
  let snaps = true;
  const snap = makeField({ name: "snap", kind: "switch" }, (on) => (snaps = on));
  snap.show(true);
  context.on("state", ({ by }) => (snap.element.hidden = by != "points"));

  const [grid, readout] = [makeGrid(context), makeFloorReadout(context)];
  const glass = makeHoverGlass(context, () => marks.crosses(), picture.canvas);
  const hover = (pixel, where) => {
    glass.show(context.state.by == "points" ? pixel : null, where);
    readout.show(pixel);
  };
  const marks = makeMarks(context, picture, () => snaps, hover);
  const draw = (scene) => {
    if (context.state.by == "lens") return drawBoards(scene);
    grid.draw(scene);
    readout.legend(scene.lens.scale);
  };
  return {
    hands: [{ draw, hover }, marks],
    over: [glass.canvas],
    foot: [readout.element, readout.times],
    below: makeRow(snap.element, film, makeFloorFile(context)),
    beside: [makeWays(tool, marks), makeFloorResult(context), makeArea(context)],
  };
});

/** The basis of the fit, and its controls. */
function makeWays({ context, picture, history }, marks) {
  const ways = makeRadios("robsim-segments", text("by"), (name) =>
    context.send({ type: "by", name }));
  const options = WAYS.map((value) =>
    ({ value, textContent: text(`by.${value}`), title: text(`by.${value}.title`) }));
  const table = makePointTable(context, picture.canvas);
  const hint = makeHint("floor_hint");
  const sides = {
    points: makeFields(hint, makeChosenGlass(context, picture, marks),
      makePointBar(context, history), table),
    sheets: makeSheets(context),
    lens: makeLensBoard(context),
  };
  context.on("state", ({ by, chosen }) => {
    ways.show(options, by);
    for (const [way, side] of Object.entries(sides)) side.hidden = way != by;
    hint.hidden = chosen != null;
  });
  return makePart(ways.element, ...Object.values(sides));
}

/** The position under the pointer, and the magnification of the arrows. */
function makeFloorReadout(context) {
  const what = "div.robsim-camera-readout.robsim-floor-readout.robsim-away";
  const [element, times] = [make(what), make(what)];
  const show = (pixel) => {
    element.classList.toggle("robsim-away", !pixel);
    if (!pixel) return;
    const { grid } = context.state;
    const [u, v] = pixel.map((value) => value.toFixed(1));
    const place = grid && pixelToPlace(grid)(pixel);
    const known = place?.every(Number.isFinite)
      ? text("floor_at", { x: place[0].toFixed(0), y: place[1].toFixed(0), unit: grid.unit }) : "";
    element.textContent = text("pixel_at", { u, v, known });
  };
  context.on("state", ({ fit, by }) => times.classList.toggle("robsim-away", !fit || by == "lens"));
  const legend = (scale) =>
    say(times, text("arrows_times", { times: timesOf(context.state, scale) }));
  return { element, times, show, legend };
}

/** Size and scale of the work area, the height of the markers, the lens. */
function makeArea(context) {
  const makeOne = ([name, step]) => makeNumberField(name, (value) =>
    context.send({ type: "set", name, value }),
  { step, className: "robsim-text-field robsim-short", ariaLabel: text(`area.${name}`),
    title: text(`area.${name}.title`) });
  const fields = Object.entries(STEPS).map(makeOne);
  const [width, height, scale, high] = fields;
  const size = make("span.robsim-quiet.robsim-number");
  const lens = make("span.robsim-quiet");
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

/** Figures and remarks. */
function makeFloorResult(context) {
  const verdict = makeVerdict();
  const figures = make("span.robsim-number.robsim-floor-figures");
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
function makeFloorFile(context) {
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
