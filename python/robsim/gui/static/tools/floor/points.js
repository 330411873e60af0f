// The points in a list: their places on the floor, which are typed in, and how well each fits.
import { make, text } from "../../base/dom.js";
import { asWords, makeAct, makeCell, makeCut, makeDecimalField, makeFields, makeHint,
  makePlaceFields, makeRow, makeTable, makeWords, readNumber, showIn } from "../pieces.js";
import { fitsOf, standing } from "./marks.js";

/** The numbers that are typed on the `canvas` of the picture are the place of the chosen point. */
export function makePointTable(context, canvas) {
  const { table, body } = makeTable(["point", "x", "y", "mm", "px", ""]);
  const rows = new Map(); // number -> the row's elements
  const keys = ({ target, key, shiftKey }) => {
    const all = [...body.querySelectorAll("input")];
    if (key == "Enter") (all[all.indexOf(target) + (shiftKey ? -1 : 1)] ?? canvas).focus();
    if (key == "Escape") canvas.focus();
  };
  const choose = (number) => context.send({ type: "choose", point: number });
  const makePoint = (number) => {
    const fields = makePlaceFields({
      number, prefix: "", label: "point",
      known: () => context.state.points.find((one) => one.number == number)?.place,
      tell: (x, y) => context.send({ type: "place", point: number, x, y }),
    }, { onkeydown: keys, onfocus: () => number == context.state.chosen || choose(number) });
    const name = make("button.robsim-point", { type: "button",
      textContent: String(number), title: text("point.title", { number }),
      onclick: () => choose(number) });
    const [mm, px] = [makeCell(), makeCell()];
    const cut = makeCut(text("point.cut", { number }), () =>
      context.send({ type: "cut", point: number }));
    const row = make("tr", makeCell(name), ...fields.map((field) => makeCell(field)), mm, px,
      makeCell(cut));
    body.append(row);
    return { row, fields, mm, px };
  };
  const show = (state, { number, place }, fit) => {
    if (!rows.has(number)) rows.set(number, makePoint(number));
    const { row, fields, mm, px } = rows.get(number);
    fields.forEach((field, i) => showIn(field, asWords(place[i])));
    mm.textContent = fit ? fit.mm.toFixed(1) : "";
    px.textContent = fit ? fit.px.toFixed(2) : "";
    row.className = `robsim-fit-${standing(state, number) || "fine"}`;
    row.ariaSelected = String(number == state.chosen);
    if (number == state.chosen && !body.matches(":focus-within"))
      row.scrollIntoView({ block: "nearest" });
  };
  context.on("state", (state) => {
    for (const [number, { row }] of rows) {
      if (state.points.some((one) => one.number == number)) continue;
      row.remove();
      rows.delete(number);
    }
    const fits = fitsOf(state);
    for (const point of state.points) show(state, point, fits.get(point.number));
    table.hidden = !state.points.length;
  });
  canvas.addEventListener("keydown", (event) => {
    const input = rows.get(context.state.chosen)?.fields[0];
    if (!input || event.ctrlKey || event.metaKey || event.altKey) return;
    if (!/^[\d.,\u2212-]$/.test(event.key)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    input.focus();
    input.value = event.key;
  }, { capture: true });
  return make("div.robsim-points-box", table);
}

/** The actions on all points: undo, redo, clear, corners of a grid. */
export function makePointBar(context, history) {
  const clear = makeAct(context, "clear", "", undefined, "clear_points");
  const step = makeDecimalField("fill_step", () => {},
    { className: "robsim-text-field robsim-short", value: "300",
      onkeydown: ({ key }) => key == "Enter" && fill.click() });
  const fill = makeAct(context, "fill", "", () =>
    readNumber(step) && { type: "fill", step: readNumber(step) });
  context.on("state", (state) => {
    clear.disabled = !state.points.length;
    fill.disabled = !state.fit || state.by != "points";
  });
  const grid = makeRow(fill, step, makeWords("fill_unit"));
  grid.classList.add("robsim-together");
  return makeRow(...history, clear, grid);
}

/** The sheets that were found: where the cross of each lies, if it was measured. */
export function makeSheets(context) {
  const find = makeAct(context, "find_sheets", "robsim-primary", () => ({ type: "sheets" }));
  const mark = makeDecimalField("mark", (value) =>
    value != null && context.send({ type: "set", name: "mark", value }),
  { className: "robsim-text-field robsim-short", ariaLabel: text("sheet_mark") });
  const { table, body } = makeTable(["sheet", "x", "y", "mm", "px"]);
  const makeSheet = ({ number, place }, points) => {
    const fields = makePlaceFields({
      number, prefix: "sheet_", label: "sheet",
      known: () => context.state.sheets.found.find((one) => one.number == number)?.place,
      tell: (x, y) => context.send({ type: "sheet", number, x, y }),
    }, { placeholder: text("sheet_anywhere") });
    fields.forEach((field, i) => (field.value = asWords(place[i])));
    const mine = points.filter(({ name }) => name == `sheet ${number}`);
    const rms = (key, digits) => (mine.length
      ? Math.sqrt(mine.reduce((sum, one) => sum + one[key] ** 2, 0) / mine.length).toFixed(digits)
      : "");
    const cells = [String(number), ...fields, rms("mm", 1), rms("px", 2)];
    return make("tr", ...cells.map((cell) => makeCell(cell)));
  };
  context.on("state", ({ sheets, fit, by, pending }) => {
    showIn(mark, asWords(sheets.mark));
    find.disabled = pending;
    if (body.matches(":focus-within")) return; // nothing is taken from under the hands
    const points = (by == "sheets" && fit?.points) || [];
    body.replaceChildren(...sheets.found.map((sheet) => makeSheet(sheet, points)));
    table.hidden = !sheets.found.length;
  });
  return makeFields(makeRow(find, makeWords("sheet_mark"), mark, makeWords("unit_mm")),
    makeHint("sheet_hint"), table);
}
