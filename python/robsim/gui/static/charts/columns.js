// Charts of single columns of the trace, which the user adds.
import { make, text } from "../base/dom.js";
import { Chart } from "./chart.js";
import { DEGREES, Series } from "./series.js";

const REMOVE_WIDTH = 26; // px of the button on the right of the title

/** Return the series of one number of a group; angles in degrees. */
export function fieldSeries(context, group, i, isAngle = false) {
  if (!isAngle) return new Series(context.store, [group], ([rows], k) => rows.get(k, i));
  return new Series(context.store, [group], ([rows], k) => rows.get(k, i) * DEGREES, 360);
}

/** Return the chart of a single column of a group. */
function makeColumnChart(context, { group, field, unit, i }, remove) {
  const isAngle = unit == "rad";
  const series = fieldSeries(context, group, i, isAngle);
  const layers = [{ name: field, series, ink: "other-1", kind: group == "u" ? "stairs" : "line" }];
  const shown = isAngle ? "\u00b0" : unit;
  const chart = new Chart({ title: field, unit: shown, layers, isAngle, reserved: REMOVE_WIDTH });
  chart.element.classList.add("robsim-chart-added");
  chart.element.append(make("button.robsim-button.robsim-plain.robsim-icon.robsim-remove", {
    type: "button", name: `remove_${field}`, onclick: remove,
    ariaLabel: text("chart.remove_column", { name: field }),
  }, "\u00d7"));
  return chart;
}

/** Return the description of a column; null if the trace cannot have it. */
function columnOf(context, field) {
  for (const { name, fields, units } of context.setup.columns) {
    const i = fields.indexOf(field);
    if (i >= 0) return { group: name, field, unit: units[i], i };
  }
  return null;
}

/** Make the menu of all columns; `add(field)` is called with the one that is chosen. */
function makeColumnMenu(add) {
  const menu = make("select.robsim-select", {
    name: "add_column", ariaLabel: text("chart.add_column"),
    onchange: () => {
      add(menu.value);
      menu.value = "";
    },
  });
  const option = (field) => make("option", { value: field, textContent: field });
  const fill = (groups) => {
    const lists = groups.map(({ name, fields }) =>
      make("optgroup", { label: name }, ...fields.map(option)));
    menu.replaceChildren(make("option", { value: "", textContent: text("chart.add_column") }),
      ...lists);
  };
  return { menu, fill };
}

/** Make the menu of all columns, and the charts of those that were chosen, in `element`. */
export function makeColumnCharts(context, board, element) {
  const shown = new Map(); // name of a column -> chart
  const others = (field) => context.local.columns.filter((other) => other != field);
  const choose = (columns) => context.choose("columns", columns);
  const { menu, fill } = makeColumnMenu((field) => choose([...others(field), field]));

  const add = (field) => {
    const column = columnOf(context, field);
    if (!column) return;
    context.want([column.group]);
    const chart = makeColumnChart(context, column, () => choose(others(field)));
    shown.set(field, chart);
    element.append(chart.element);
    board.add(chart);
  };
  const renew = () => {
    const wanted = context.local.columns;
    for (const [field, chart] of shown) {
      if (wanted.includes(field)) continue;
      board.remove(chart);
      shown.delete(field);
    }
    wanted.filter((field) => !shown.has(field)).forEach(add);
  };
  context.on("local", (name) => name == "columns" && renew());
  context.on("setup", () => {
    fill(context.setup.columns);
    renew();
  });
  return menu;
}
