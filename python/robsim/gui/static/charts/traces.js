// The tab of the traces: true, measured, held and estimated poses, their errors, and any other
// column.
import { make, text } from "../base/dom.js";
import { makeField } from "../base/fields.js";
import { makeBoard } from "./board.js";
import { Chart } from "./chart.js";
import { fieldSeries, makeColumnCharts } from "./columns.js";
import { ghostLayers, makeGhostControls } from "./ghosts.js";
import { Histogram } from "./histogram.js";
import { makeNees } from "./nees.js";
import { DEGREES, Series, wrappedDegrees } from "./series.js";
import { makeLegend, makeStepControls } from "./toolbar.js";

const POSE_GROUPS = ["t", "pose_true", "pose_measured", "pose_held", "pose_estimated",
  "covariance"];
const QUANTITIES = [
  { name: "x", unit: "px", least: 2, scale: 1 },
  { name: "y", unit: "px", least: 2, scale: 1 },
  { name: "heading", unit: "\u00b0", least: 2, scale: DEGREES, isAngle: true },
];
const SOURCES = {
  // The truth is a thin line on broader ones: where they agree all of them are seen.
  true: { name: "true", ink: "true", kind: "line", level: 3 },
  measured: { name: "measured", ink: "measured", kind: "dots", size: 5, level: 1 },
  estimated: { name: "estimated", ink: "estimated", kind: "line", size: 3, level: 2 },
  held: { name: "held", ink: "held", kind: "dots", size: 3, level: 4 },
};

/** Return the layers of x (i = 0), y or the heading. */
function poseLayers({ store }, i) {
  const { scale, isAngle } = QUANTITIES[i];
  const period = isAngle ? 360 : 0;
  const pose = (group) => new Series(store, [group], ([rows], k) => rows.get(k, i) * scale, period);
  const held = ([measured, rows], k) =>
    (Number.isNaN(measured.get(k, 0)) ? rows.get(k, i) * scale : NaN);
  const deviation = ([rows], k) => Math.sqrt(rows.get(k, 4 * i)) * scale;
  const spread = new Series(store, ["covariance"], deviation);
  return [
    { ...SOURCES.true, series: pose("pose_true") },
    { ...SOURCES.measured, series: pose("pose_measured") },
    { ...SOURCES.estimated, series: pose("pose_estimated"), spread, bandInk: "estimated-band" },
    { ...SOURCES.held, series: new Series(store, ["pose_measured", "pose_held"], held, period) },
  ];
}

/** Return the layers of the errors of x (i = 0), y or the heading. */
function errorLayers({ store }, i) {
  const { scale, isAngle } = QUANTITIES[i];
  const error = ([rows, truth], k) => {
    const difference = (rows.get(k, i) - truth.get(k, i)) * scale;
    return isAngle ? wrappedDegrees(difference) : difference;
  };
  const against = (group) => new Series(store, [group, "pose_true"], error);
  return [
    { ...SOURCES.measured, series: against("pose_measured"), size: 2, isJoined: true },
    { ...SOURCES.estimated, series: against("pose_estimated"), size: 1.5 },
  ];
}

/** Return the layers of the two biggest objects of each colour, in x (i = 0) or y. */
function objectLayers(context, i) {
  const layer = ({ name, css }, rank) => ({
    name: text("chart.object", { color: name, rank }), isAside: true,
    ink: css, kind: "dots", size: 3.5 - rank,
    series: fieldSeries(context, `blobs_${name}`, 2 * (rank - 1) + i),
  });
  return context.setup.colors.flatMap((color) => [layer(color, 1), layer(color, 2)]);
}

/** Return a chart of an error, with its histogram, for each quantity. */
function errorCharts(context) {
  return QUANTITIES.map(({ name, unit }, i) => {
    const title = text("chart.error_of", { name: text(`chart.${name}`) });
    const about = { title, unit, least: 0.1, hasZero: true, layers: errorLayers(context, i) };
    return new Chart({ ...about, beside: new Histogram() });
  });
}

/** Return charts of the robot's inputs, for runs without truth. */
function inputCharts(context) {
  const gap = ([rows], k) => (k ? (rows.get(k, 0) - rows.get(k - 1, 0)) * 1000 : NaN);
  const input = (i) => ({ ink: "other-1", kind: "stairs", series: fieldSeries(context, "u", i) });
  const interval = { ink: "other-2", kind: "line", series: new Series(context.store, ["t"], gap) };
  const charts = [
    { title: "u1", unit: "V", least: 0.2, layers: [{ name: "u1", ...input(0) }] },
    { title: "u2", unit: "V", least: 0.2, layers: [{ name: "u2", ...input(1) }] },
    { title: text("chart.interval"), unit: "ms", least: 2,
      layers: [{ name: "interval", ...interval }] },
  ];
  return charts.map((about) => new Chart(about));
}

/** Return a chart of each quantity; the errors can be read off there too. */
function poseCharts(context, errors) {
  return QUANTITIES.map(({ name, unit, least, isAngle }, i) => {
    const about = { title: text(`chart.${name}`), unit, least, isAngle };
    const found = errors[i]?.layers ?? [];
    const reads = found.map(({ name: source, series }) => ({ name: `error_${source}`, series }));
    return new Chart({ ...about, layers: poseLayers(context, i), reads });
  });
}

export function makeTraces(context) {
  const grid = make("div.robsim-chart-grid");
  const tools = make("div.robsim-chart-tools.robsim-row");
  const element = make("div.robsim-traces.robsim-column", tools, grid);
  let isSeen = false;
  const ask = () => isSeen && context.setup && context.want(traceGroups(context));
  const board = makeBoard(context, element, () => {
    isSeen = true;
    ask();
  });
  const charts = makeTraceCharts(context, board, grid);
  const menu = makeColumnCharts(context, board, grid);
  const legend = makeLegend(context, Object.values(SOURCES),
    (name) => name != "true" || context.setup.has_truth);
  tools.append(...makeStepControls(context), legend, makeObjectSwitch(context), menu,
    ...makeGhostControls(context), makeNees(context));

  context.on("setup", () => {
    charts.build();
    ask();
  });
  context.on("local", (name) => {
    if (name != "objects" || !context.setup) return;
    charts.arrange();
    ask();
  });
  context.on("ghosts", charts.arrange);
  context.on("statistics", (message) => charts.tell(message));
  return { element };
}

/** Return the groups of columns that the charts need. */
function traceGroups({ setup, local }) {
  const objects = local.objects ? setup.colors.map(({ name }) => `blobs_${name}`) : [];
  return [...POSE_GROUPS, ...(setup.has_truth ? [] : ["u"]), ...objects];
}

/**
 * Make the charts of x, y and heading in a grid, and what stands beside each: its error or an
 * input.
 */
function makeTraceCharts(context, board, grid) {
  let [poses, beside] = [[], []];
  const arrange = () => {
    const own = ({ layers }) => layers.filter(({ name }) => name in SOURCES);
    poses.forEach((chart, i) => {
      const objects = context.local.objects && i < 2 ? objectLayers(context, i) : [];
      chart.layers = [...ghostLayers(context, i, QUANTITIES[i]), ...objects, ...own(chart)];
    });
    if (context.setup?.has_truth)
      beside.forEach((chart, i) => {
        chart.layers = [...ghostLayers(context, i, QUANTITIES[i], true), ...own(chart)];
      });
    board.later();
  };
  const build = () => {
    [...poses, ...beside].forEach(board.remove);
    const hasTruth = context.setup.has_truth;
    beside = hasTruth ? errorCharts(context) : inputCharts(context);
    poses = poseCharts(context, hasTruth ? beside : []);
    for (const charts of [poses, beside]) // the lowest row names the steps
      charts.forEach((chart, i) => (chart.namesSteps = () => i == charts.length - 1));
    grid.prepend(...poses.flatMap((chart, i) => [chart.element, beside[i].element]));
    [...poses, ...beside].forEach((chart, i) => {
      chart.element.style.setProperty("--robsim-place", String(i)); // one below the other
      board.add(chart);
    });
    arrange();
  };
  const tell = ({ first, last, errors }) => {
    QUANTITIES.forEach(({ name }, i) => {
      const own = errors.filter((error) => error.name == name);
      Object.assign(beside[i]?.beside ?? {}, { first, last, errors: own });
    });
    board.later();
  };
  return { build, arrange, tell };
}

/** Make the switch of the objects' traces. */
function makeObjectSwitch(context) {
  const field = makeField({ name: "objects", kind: "switch" }, (on) =>
    context.choose("objects", on));
  field.show(context.local.objects);
  return field.element;
}
