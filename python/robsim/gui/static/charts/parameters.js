// The tab of the parameters: the history of each of the 15, with the truth and two standard errors.
import { make, text } from "../base/dom.js";
import { makeSwatch } from "../base/icons.js";
import { makeBoard } from "./board.js";
import { Chart } from "./chart.js";
import { fieldSeries } from "./columns.js";
import { makeStepControls } from "./toolbar.js";

const PARAMETER_GROUPS = ["parameters", "standard_errors_unscaled"];
const FINEST_RANGE = 0.05; // of the true value
const LEAST_RANGE = 1e-4; // where that is 0, or not known

export function makeParameterCharts(context) {
  const verdict = make("span", { role: "status" });
  const tools = make("div.robsim-chart-tools.robsim-row");
  const grid = make("div.robsim-chart-grid.robsim-parameter-grid");
  const element = make("div.robsim-parameters.robsim-column", tools, grid);
  const board = makeBoard(context, element, () => context.want(PARAMETER_GROUPS));
  tools.append(...makeStepControls(context), makeParameterKey(context),
    make("div.robsim-verdict-line", verdict));
  let charts = [];
  let newest = null; // message

  context.on("setup", ({ columns }) => {
    charts.forEach(board.remove);
    const names = columns.find(({ name }) => name == PARAMETER_GROUPS[0])?.fields ?? [];
    charts = names.map((name, i) => parameterChart(context, name, i, () => newest));
    grid.append(...charts.map((chart) => chart.element));
    charts.forEach(board.add);
  });
  context.on("parameters", (message) => {
    newest = message;
    const { weak } = message.excitation;
    charts.forEach((chart) =>
      (chart.remark = weak.includes(chart.title) ? text("chart.weak") : ""));
    Object.assign(verdict, aboutVerdict(message.excitation));
    board.later();
  });
  return { element };
}

const MEANINGS = { true: "robsim-good", false: "robsim-warning" };

/** Return the attributes of a verdict on the excitation: good, or not, or not known yet (null). */
export const aboutVerdict = ({ text: textContent, good }) =>
  ({ textContent, className: `robsim-chip robsim-verdict ${MEANINGS[good] ?? ""}` });

/** Make the chart of a parameter; `newest` returns the newest message about all of them. */
function parameterChart(context, name, i, newest) {
  const spread = fieldSeries(context, PARAMETER_GROUPS[1], i);
  // The columns lack the standard deviation of the residuals: the message has it in.
  const sigma = () => (newest()?.errors?.[i] ?? NaN) / spread.value(spread.count - 1);
  const layer = {
    name: "parameter", ink: "estimated", kind: "line",
    series: fieldSeries(context, PARAMETER_GROUPS[0], i),
    spread, sigma, bandInk: "estimated-band",
  };
  const truth = context.setup.theta_true?.[i] ?? null;
  const least = FINEST_RANGE * Math.abs(truth ?? 0) || LEAST_RANGE;
  return new Chart({
    title: name, layers: [layer], isRobust: true, truth, least,
    namesSteps: isLowest, readsNewest: true,
  });
}

/** Whether a chart stands in the lowest row of its grid. */
function isLowest({ element }) {
  const bottomOf = (one) => one.getBoundingClientRect().bottom;
  return bottomOf(element.parentNode) - bottomOf(element) < 2;
}

/** Make the key of crosses, line and band. */
function makeParameterKey(context) {
  const entry = (kind, ink, name) =>
    make("span", makeSwatch(kind, `var(--robsim-${ink})`), text(`chart.${name}`));
  const truth = entry("cross", "true", "true");
  context.on("setup", ({ theta_true: values }) => (truth.hidden = values == null));
  return make("div.robsim-legend.robsim-quiet", truth, entry("line", "estimated", "parameter_key"));
}
