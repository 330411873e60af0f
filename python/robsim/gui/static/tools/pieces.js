// The pieces of all tools' sides: rows, words, buttons, fields, tables, lists of problems.
import { makeTextButton } from "../base/buttons.js";
import { make, sayOrHide, text } from "../base/dom.js";
import { ANSWER_TIME } from "../base/fields.js";

const box = (what) => (...children) => make(what, ...children);
export const makePart = box("div.robsim-tool-part.robsim-surface.robsim-column");
export const makeRow = box("div.robsim-tool-row.robsim-row");
export const makeFields = box("div.robsim-tool-fields");

export const makeWords = (name) =>
  make("span.robsim-quiet", text(name));

export const makeHint = (name) =>
  make("p.robsim-quiet.robsim-tool-hint", text(name));

/** Make a button that sends `message()`, if there is one; the default type is the `name`. */
export const makeAct = (context, name, kind = "", message = () => ({ type: name }), words = name) =>
  makeTextButton(name, kind, () => {
    const told = message();
    if (told) context.send(told);
  }, words);

/** A field; `take(words)` is called after a change. */
export const makeTextField = (name, take, about = {}) =>
  make("input.robsim-text-field", { name, ariaLabel: text(name),
    onchange: ({ target }) => take(target.value.trim()), ...about });

/** A field with arrows for a number, which `take` gets. */
export function makeNumberField(name, take, about = {}) {
  const onchange = ({ target: { valueAsNumber: value } }) => Number.isFinite(value) && take(value);
  return makeTextField(name, take, { type: "number", step: "any", onchange, ...about });
}

/** Make a field for a typed number, null = empty; an invalid number is marked and ignored. */
export function makeDecimalField(name, take, about = {}) {
  const onchange = ({ target }) => {
    const value = readNumber(target);
    if (value !== undefined) take(value);
  };
  const typed = { inputMode: "decimal", autocomplete: "off", onchange };
  return makeTextField(name, take, { ...typed, ...about });
}

/** The number in a field; null if empty. Invalid text is marked and gives `instead`. */
export function readNumber(field, instead = undefined) {
  const words = field.value.trim();
  const found = Number(words.replace(",", ".").replace("\u2212", "-"));
  const isNumber = Number.isFinite(found);
  field.ariaInvalid = String(!isNumber);
  field.title = isNumber ? "" : text("no_number");
  if (!isNumber) return instead;
  return words ? found : null;
}

/** Show a value in a field, unless something is typed there, or is no number yet. */
export function showIn(field, value) {
  if (document.activeElement != field && field.ariaInvalid != "true") field.value = value;
}

export const asWords = (value) => (value == null ? "" : String(Number(value.toFixed(3))));

/** Make the fields of `tell(x, y)`; `known()` is the previous place, `label` the texts' prefix. */
export function makePlaceFields({ number, prefix, label, known, tell }, about = {}) {
  let [sent, until] = [null, 0]; // the last place from here counts until Python can have answered
  const tellAxis = (i) => {
    const place = [...((performance.now() < until && sent) || known() || [null, null])];
    place[i] = readNumber(fields[i], place[i]);
    [sent, until] = [place, performance.now() + ANSWER_TIME];
    tell(...place);
  };
  const fields = ["x", "y"].map((axis, i) => makeDecimalField(`${prefix}${axis}_${number}`,
    () => tellAxis(i), { ariaLabel: text(`${label}.${axis}`, { number }), ...about }));
  return fields;
}

export const makeCell = (...children) => make("td", ...children);

export function makeTable(columns) {
  const body = make("tbody");
  const head = columns.map((name) =>
    make("th", { scope: "col", textContent: name && text(`floor_column.${name}`) }));
  const table = make("table.robsim-table.robsim-points", make("thead", make("tr", ...head)), body);
  return { table, body };
}

/** A small button of a row, which takes it away. */
export const makeCut = (label, onclick) => make("button", { type: "button", onclick,
  className: "robsim-point-cut", textContent: "\u00d7", ariaLabel: label, title: label });

/** Make a list of sentences, such as problems; an empty list is hidden. */
export function makeList(about = { className: "robsim-problems", role: "status" }) {
  const element = make("ul", { ...about, hidden: true });
  const show = (words) => {
    const shown = [...element.children].map(({ textContent }) => textContent);
    element.hidden = !words.length;
    if (shown.join("\n") == words.join("\n")) return;
    element.replaceChildren(...words.map((textContent) => make("li", { textContent })));
  };
  return { element, show };
}

const LOOKS = { good: "robsim-good", poor: "robsim-warning", bad: "robsim-bad" };

/** How good something is, in a word or a few. */
export function makeVerdict() {
  const element = make("span.robsim-chip", { role: "status" });
  const show = (kind, words) => {
    element.className = `robsim-chip ${LOOKS[kind] ?? ""}`;
    sayOrHide(element, words);
  };
  return { element, show };
}
