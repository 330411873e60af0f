// @ts-check
// Some charts that are painted together, at most once for each animation frame, and only if they
// are seen. While a run goes on they take turns with new rows, so that the camera's picture never
// waits for all.
import { painter } from "../base/dom.js";
import { axisOf } from "./axis.js";
import { layerName, layerText } from "./frame.js";
import { listenToGestures } from "./gestures.js";
import { inksOf } from "./inks.js";
import { makeTip, stepText } from "./tip.js";

const AT_ONCE = 2; // charts in an animation frame, of those that grow
const REST = 50; // ms without new rows, after which the next ones are painted all the same

/** Make the charts of a tab; `seen` is called when the tab is shown. */
export function makeBoard(context, element, seen) {
  const charts = new Map(); // what is measured -> chart
  const [axis, ink] = [axisOf(context), inksOf(context)];
  const tip = makeTip(context);
  const growing = new Set(); // charts that have got rows which they do not show yet
  let rest = 0;
  let isStale = true; // or the cursor alone has moved
  let pointed = null; // the chart under the pointer

  const paintChart = (chart, isWhole) => {
    if (!chart.isSeen || !chart.size[0]) return;
    if (isWhole || !chart.plot) chart.paint(board);
    chart.paintOver(board);
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

  const board = {
    context, axis, ink, later,
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
      if (chart && axis.cursor !== null) describe(chart, axis, context);
    },
  };

  context.on("rows", grow);
  context.on("axis", (isGrowth) => (isGrowth ? grow() : later()));
  context.on("theme", later);
  context.on("local", (name) => name == "unseen" && later());
  context.on("cursor looking", paintLater);
  context.onEnd(() => {
    paintLater.cancel();
    paintSome.cancel();
    clearTimeout(rest);
    sizes.disconnect();
    sight.disconnect();
  });
  return board;
}

/** Say to a screen reader what the cursor of a chart is on. */
function describe(chart, axis, context) {
  const set = (name, value) => chart.over.setAttribute(name, value);
  const readings = chart.layers
    .filter(({ series }) => Number.isFinite(series.value(axis.cursor)))
    .map((layer) => `${layerName(layer)} ${layerText(layer, axis.cursor)}`);
  set("aria-valuemin", 0);
  set("aria-valuemax", axis.count - 1);
  set("aria-valuenow", axis.cursor);
  set("aria-valuetext", [stepText(context, axis.cursor), ...readings].join(", "));
}
