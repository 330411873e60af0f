// @ts-check
// The points in a list: their places on the floor, which are typed in, and how well each fits.
import { makeTextButton } from "../../base/buttons.js";
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";
import { isWrong, readNumber } from "./numbers.js";
import { fitsOf, standing } from "./marks.js";

const AXES = ["x", "y"];
const asWords = (value) => (value == null ? "" : String(Number(value.toFixed(3))));

/** `focus` gives the picture the keys again. */
export function makePointTable(context, focus) {
  const body = make("tbody");
  const rows = new Map(); // number -> the row's elements
  const inputs = () => [...body.querySelectorAll("input")];
  const next = (input, by) => {
    const all = inputs();
    const to = all[all.indexOf(input) + by];
    if (to) to.focus();
    else focus();
  };
  const tell = (number, axis) => {
    const made = rows.get(number);
    if (readNumber(made[axis]) === undefined) return;
    const known = context.state.points.find((one) => one.number == number)?.place ?? [];
    const [x, y] = AXES.map((name, i) => readNumber(made[name], known[i]));
    context.send({ type: "place", point: number, x, y });
  };
  const keys = (event) => {
    event.stopPropagation();
    if (event.key == "Enter") next(event.target, event.shiftKey ? -1 : 1);
    if (event.key == "Escape") focus();
  };
  const choose = (number) => context.send({ type: "choose", point: number });
  const makeRow = (number) => {
    const field = (axis) => make("input", {
      className: "robsim-text-field", name: `${axis}_${number}`, inputMode: "decimal",
      ariaLabel: text(`point.${axis}`, { number }), autocomplete: "off",
      onchange: () => tell(number, axis), onkeydown: keys,
      onfocus: () => number == context.state.chosen || choose(number),
    });
    const [x, y] = AXES.map(field);
    const name = make("button", { type: "button", className: "robsim-point",
      textContent: String(number), title: text("point.title", { number }),
      onclick: () => choose(number) });
    const [mm, px] = [make("td"), make("td")];
    const cut = make("button", { type: "button", className: "robsim-point-cut",
      textContent: "\u00d7", ariaLabel: text("point.cut", { number }),
      title: text("point.cut", { number }),
      onclick: () => context.send({ type: "cut", point: number }) });
    const cell = (child) => make("td", {}, child);
    const row = make("tr", {}, cell(name), cell(x), cell(y), mm, px, cell(cut));
    return { row, x, y, mm, px, name };
  };
  const head = ["point", "x", "y", "mm", "px", ""].map((name) =>
    make("th", { scope: "col", textContent: name && text(`floor_column.${name}`) }));
  const table = make("table", { className: "robsim-points" },
    make("thead", {}, make("tr", {}, ...head)), body);
  context.on("state", (state) => {
    const fits = fitsOf(state);
    for (const [number, { row }] of rows)
      if (!state.points.some((one) => one.number == number)) {
        row.remove();
        rows.delete(number);
      }
    for (const { number, place } of state.points) {
      if (!rows.has(number)) rows.set(number, makeRow(number));
      const made = rows.get(number);
      if (!made.row.isConnected || made.row.parentNode != body) body.append(made.row);
      AXES.forEach((axis, i) => {
        const field = made[axis];
        if (document.activeElement != field && !isWrong(field)) field.value = asWords(place[i]);
      });
      const fit = fits.get(number);
      made.mm.textContent = fit ? fit.mm.toFixed(1) : "";
      made.px.textContent = fit ? fit.px.toFixed(2) : "";
      made.row.className = `robsim-fit-${standing(state, number) || "fine"}`;
      made.row.ariaSelected = String(number == state.chosen);
      if (number == state.chosen && !body.matches(":focus-within"))
        made.row.scrollIntoView({ block: "nearest" });
    }
    table.hidden = !state.points.length;
  });
  return {
    element: make("div", { className: "robsim-points-box" }, table),
    /** Begin to type the place of a point. */
    type: (number, first) => {
      const input = rows.get(number)?.x;
      if (!input) return;
      input.focus();
      input.value = first;
    },
  };
}

/** What is done with all points: undo, redo, clear, corners of a grid. */
export function makePointBar(context) {
  const act = (name) =>
    makeTextButton(name, "", () => context.send({ type: name }), `floor_${name}`);
  const [undo, redo, clear] = ["undo", "redo", "clear"].map(act);
  const step = make("input", { className: "robsim-text-field robsim-short", name: "fill_step",
    inputMode: "decimal", value: "300", ariaLabel: text("fill_step") });
  const fill = makeTextButton("fill", "", () => {
    const value = readNumber(step);
    if (value) context.send({ type: "fill", step: value });
  });
  step.onkeydown = (event) => {
    event.stopPropagation();
    if (event.key == "Enter") fill.click();
  };
  context.on("state", (state) => {
    undo.disabled = !state.can_undo;
    redo.disabled = !state.can_redo;
    clear.disabled = !state.points.length;
    fill.disabled = !state.fit || state.by != "points";
  });
  const words = (id) => make("span", { className: "robsim-quiet", textContent: text(id) });
  return make("div", { className: "robsim-tool-row" }, undo, redo, clear,
    make("span", { className: "robsim-tool-row robsim-together" }, fill, step, words("fill_unit")));
}

/** The sheets that were found: where the cross of each lies, if it was measured. */
export function makeSheetTable(context) {
  const body = make("tbody");
  const find = makeTextButton("find_sheets", "robsim-primary", () =>
    context.send({ type: "sheets" }));
  const mark = make("input", { className: "robsim-text-field robsim-short", name: "mark",
    inputMode: "decimal", ariaLabel: text("sheet_mark") });
  mark.onchange = () => {
    const value = readNumber(mark);
    if (value != null) context.send({ type: "set", name: "mark", value });
  };
  mark.onkeydown = (event) => event.stopPropagation();
  const head = ["sheet", "x", "y", "mm", "px"].map((name) =>
    make("th", { scope: "col", textContent: text(`floor_column.${name}`) }));
  const table = make("table", { className: "robsim-points" },
    make("thead", {}, make("tr", {}, ...head)), body);
  const rowOf = ({ number, place }, points) => {
    const fields = AXES.map((axis, i) => make("input", { className: "robsim-text-field",
      name: `sheet_${axis}_${number}`, inputMode: "decimal", value: asWords(place[i]),
      placeholder: text("sheet_anywhere"), ariaLabel: text(`sheet.${axis}`, { number }) }));
    for (const field of fields) {
      field.onkeydown = (event) => event.stopPropagation();
      field.onchange = () => {
        if (readNumber(field) === undefined) return;
        const known = context.state.sheets.found.find((one) => one.number == number);
        const [x, y] = fields.map((one, i) => readNumber(one, known?.place[i] ?? null));
        context.send({ type: "sheet", number, x, y });
      };
    }
    const mine = points.filter(({ name }) => name == `sheet ${number}`);
    const rms = (key) => (mine.length
      ? Math.sqrt(mine.reduce((sum, one) => sum + one[key] ** 2, 0) / mine.length) : null);
    const cell = (...children) => make("td", {}, ...children);
    return make("tr", {}, cell(String(number)), ...fields.map((field) => cell(field)),
      cell(rms("mm")?.toFixed(1) ?? ""), cell(rms("px")?.toFixed(2) ?? ""));
  };
  context.on("state", ({ sheets, fit, by, pending }) => {
    if (document.activeElement != mark) mark.value = asWords(sheets.mark);
    find.disabled = pending;
    if (body.matches(":focus-within")) return; // nothing is taken from under the hands
    const points = (by == "sheets" && fit?.points) || [];
    body.replaceChildren(...sheets.found.map((sheet) => rowOf(sheet, points)));
    table.hidden = !sheets.found.length;
  });
  const words = (id) => make("span", { className: "robsim-quiet", textContent: text(id) });
  const row = make("div", { className: "robsim-tool-row" }, find, words("sheet_mark"), mark,
    words("unit_mm"));
  const hint = make("p", { className: "robsim-quiet robsim-tool-hint",
    textContent: text("sheet_hint") });
  return make("div", { className: "robsim-tool-fields" }, row, hint, table);
}
