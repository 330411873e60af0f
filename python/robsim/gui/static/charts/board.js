// Some charts that are painted together, at most once for each animation frame, and only if they
// are seen. During a run they take turns with new rows, so that the camera's picture never
// waits for all.
import { make, painter, set, text } from "../base/dom.js";
import { makeSwatch } from "../base/icons.js";
import { layerName, layerText } from "./frame.js";
import { listenToGestures } from "./gestures.js";

const AT_ONCE = 2; // growing charts in an animation frame.
const REST = 50; // ms without new rows, after which the next charts are painted.
const TIP_GAP = 12; // px from the cursor

/** Make the charts of a tab; `seen` is called when the tab is shown. */
export function makeBoard(context, element, seen) {
  const charts = new Map(); // measured canvas -> chart
  const { axis } = context;
  const tip = makeTip(context);
  const growing = new Set(); // charts that have got rows which they do not show yet
  let rest = 0;
  let isStale = true; // or the cursor alone has moved
  let pointed = null; // the chart under the pointer

  const paintChart = (chart, isWhole) => {
    if (!chart.isSeen || !chart.size[0]) return;
    if (isWhole || !chart.plot) chart.paint(context);
    chart.paintOver(context);
  };
  const paint = () => {
    for (const chart of charts.values()) paintChart(chart, isStale);
    if (isStale) growing.clear();
    isStale = false;
    tip.show(pointed?.isSeen ? pointed : null, axis.cursor);
  };
  const paintLater = painter(paint);
  const paintSome = painter(() => {
    clearTimeout(rest);
    const turn = [...growing].filter(({ isSeen }) => isSeen).slice(0, AT_ONCE);
    for (const chart of turn) {
      growing.delete(chart);
      paintChart(chart, true);
    }
    if (turn.length == AT_ONCE) rest = setTimeout(paintSome, REST);
  });
  const grow = () => {
    if (context.state.state != "running") return later();
    for (const chart of charts.values()) growing.add(chart);
    paintSome();
  };
  const later = () => {
    isStale = true;
    paintLater();
  };

  const sizes = new ResizeObserver((entries) => {
    for (const { target, contentRect } of entries) {
      const chart = charts.get(target);
      if (chart) chart.size = [contentRect.width, contentRect.height];
    }
    isStale = true;
    paint(); // at once: a canvas of the old size would be stretched for a moment
  });
  const sight = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (target == element && isIntersecting) seen();
      if (charts.has(target)) charts.get(target).isSeen = isIntersecting;
    }
    later();
  });
  sight.observe(element);
  const hint = make("p.robsim-chart-hint", text("chart.hint"));
  element.append(hint);
  context.on("shown", () => (hint.hidden = context.state.steps > 0 || context.store.count > 0));

  const board = {
    context, later,
    add(chart) {
      charts.set(chart.main, chart);
      sizes.observe(chart.main);
      sight.observe(chart.main);
      listenToGestures(chart, board);
    },
    remove(chart) {
      charts.delete(chart.main);
      growing.delete(chart);
      sizes.unobserve(chart.main);
      sight.unobserve(chart.main);
      chart.element.remove();
      if (pointed == chart) pointed = null;
    },
    /** Put the cursor on a step of a chart, or away. */
    point(k, chart, isKept = false) {
      pointed = chart;
      axis.point(k, isKept);
      if (chart && axis.cursor !== null) describe(chart, context);
    },
  };

  context.on("rows", grow);
  context.on("axis", (isGrowth) => (isGrowth ? grow() : later()));
  context.on("theme", later);
  context.on("local", (name) => name == "unseen" && later());
  context.on("cursor marked", paintLater);
  return board;
}

/** Announce the cursor position of a chart to a screen reader. */
function describe(chart, context) {
  const { axis } = context;
  const readings = chart.layers
    .filter(({ series }) => Number.isFinite(series.value(axis.cursor)))
    .map((layer) => `${layerName(layer)} ${layerText(layer, axis.cursor)}`);
  set(chart.over, { ariaValueMin: "0", ariaValueMax: axis.count - 1, ariaValueNow: axis.cursor,
    ariaValueText: [stepText(context, axis.cursor), ...readings].join(", ") });
}

/** Return a step and its time as a text. */
function stepText(context, k) {
  return text("chart.step_and_time", { k, t: context.timeOf(k).toFixed(2) });
}

/** The values of a chart at the step under the cursor, next to it. */
function makeTip(context) {
  const element = make("div.robsim-tip.robsim-surface.robsim-afloat", { hidden: true });
  const row = (layer, unit, k) => {
    const color = layer.ink ? context.ink(layer.ink) : "transparent";
    const swatch = makeSwatch(layer.kind ?? "none", color);
    const value = make("b", `${layerText(layer, k)} ${unit}`);
    return make("div", swatch, make("span", { textContent: layerName(layer) }), value);
  };
  const fill = (chart, k) => {
    const known = [...chart.shown, ...chart.reads].filter(({ series }) =>
      Number.isFinite(series.value(k)));
    const isMissed = known.some(({ name }) => name == "held");
    element.replaceChildren(
      make("strong", { textContent: stepText(context, k) }),
      ...known.map((layer) => row(layer, layer.unit ?? chart.unit, k)),
      ...(isMissed ? [make("em", text("chart.missed"))] : []),
    );
  };
  const place = (chart, k) => {
    const { box, plot } = chart;
    const [x, width, room] = [plot.x(k), element.offsetWidth, chart.size[0]];
    const isRight = x + width + TIP_GAP <= room || x < width + TIP_GAP;
    const left = isRight ? x + TIP_GAP : x - width - TIP_GAP;
    element.style.left = `${Math.max(0, Math.min(left, room - width))}px`;
    element.style.top = `${box.top + 6}px`;
  };
  return {
    /** Show a chart's readings of a step; null = no step. */
    show(chart, k) {
      element.hidden = !chart || k === null;
      if (element.hidden) return;
      if (element.parentNode != chart.main) chart.main.append(element);
      fill(chart, k);
      place(chart, k);
    },
  };
}
