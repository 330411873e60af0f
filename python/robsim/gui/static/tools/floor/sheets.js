// @ts-check
// The sheets that were found: where the cross of each lies, if it was measured.
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";
import { asWords, makeAct, makeCell, makeDecimalField, makeFields, makeHint, makePlaceFields,
  makeRow, makeTable, makeWords, showIn } from "../pieces.js";

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
    return make("tr", {}, ...cells.map((cell) => makeCell(cell)));
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
