// The surroundings of a chart's data: grid, ticks, title, readings.
import { text } from "../base/dom.js";
import { numberText, tickGap, ticksOf, tickText, uncertainText } from "./scale.js";

const TICK_ROOM = { x: 80, y: 34 }; // px for a tick
const LEAST_STEPS = 2.5; // ticks, in a narrow chart
const TITLE_LINE = 14; // px, the base line of the title

export function drawFrame(plot, chart, ink, isKnown) {
  const { g, box } = plot;
  g.font = ink("chart-font");
  g.textBaseline = "middle";
  g.lineWidth = 1 / plot.ratio;
  drawSteps(plot, chart.namesSteps(chart), ink);
  if (isKnown) drawValues(plot, chart, ink);
  g.strokeStyle = ink("line");
  g.strokeRect(plot.crisp(box.left), plot.crisp(box.top), box.width, box.height);
  drawTitle(g, chart, ink);
}

function drawSteps(plot, isNamed, ink) {
  const { g, box, first, last } = plot;
  const gap = tickGap(last - first, Math.max(box.width / TICK_ROOM.x, LEAST_STEPS), { least: 1 });
  const bottom = box.top + box.height;
  g.strokeStyle = ink("grid");
  g.fillStyle = ink("quiet");
  g.textAlign = "center";
  g.beginPath();
  for (const k of ticksOf(Math.max(first, 0), last, gap)) {
    const x = plot.crisp(plot.x(k));
    g.moveTo(x, box.top);
    g.lineTo(x, bottom);
    if (isNamed) g.fillText(tickText(k, gap), Math.min(x, box.left + box.width - 8), bottom + 11);
  }
  g.stroke();
  if (!isNamed) return;
  g.textAlign = "left";
  g.fillText(text("chart.step_name"), 8, bottom + 11);
}

function drawValues(plot, { isAngle, hasZero }, ink) {
  const { g, box, low, high } = plot;
  const gap = tickGap(high - low, Math.max(2, box.height / TICK_ROOM.y), { isAngle });
  g.textAlign = "right";
  for (const value of ticksOf(low, high, gap)) {
    const y = plot.crisp(plot.y(value));
    g.strokeStyle = ink(hasZero && Math.abs(value) < gap * 1e-6 ? "faint" : "grid");
    g.stroke(new Path2D(`M${box.left} ${y}h${box.width}`));
    const inside = Math.min(Math.max(y, box.top + 5), box.top + box.height - 4);
    g.fillText(tickText(value, gap), box.left - 6, inside, box.left - 9);
  }
}

function drawTitle(g, { title, unit, remark, box }, ink) {
  g.textAlign = "left";
  g.textBaseline = "alphabetic";
  g.fillStyle = ink("text");
  g.font = `600 ${ink("chart-font")}`;
  g.fillText(title, 8, TITLE_LINE);
  const right = 8 + g.measureText(title).width;
  g.font = ink("chart-font");
  g.fillStyle = ink("quiet");
  g.fillText(unit, right + 5, TITLE_LINE);
  g.fillStyle = ink("warning");
  g.textAlign = "right";
  g.fillText(remark, box.left + box.width - 5, box.top + 13); // at first the values are often wild
}

/** Return the name of a layer; a column or an object has its own. */
export const layerName = ({ name }) => text(`chart.${name}`, {}, name);

/** Return a layer's reading of a step. */
export function layerText({ series, spread, sigma }, k) {
  const value = series.value(k);
  return spread ? uncertainText(value, spread.value(k) * (sigma?.() ?? 1)) : numberText(value);
}

/**
 * Write the layers' readings of a step beside the title, from the right, if there is room: at
 * last without the standard error.
 */
export function drawReadings(g, chart, layers, k, ink) {
  const { box } = chart;
  g.font = ink("chart-font");
  const least = chart.isNarrow ? 0 : 8 + g.measureText(`${chart.title} ${chart.unit}`).width + 12;
  let right = box.left + box.width - chart.reserved;
  g.textAlign = "right";
  g.textBaseline = "alphabetic";
  for (const layer of [...layers].reverse()) {
    if (layer.isAside || !Number.isFinite(layer.series.value(k))) continue;
    const fits = (words) => right - g.measureText(words).width >= least;
    const reading = [layerText(layer, k), numberText(layer.series.value(k))].find(fits);
    if (!reading) return;
    g.fillStyle = ink(layer.ink);
    g.fillText(reading, right, chart.isNarrow ? box.top - 6 : TITLE_LINE);
    right -= g.measureText(reading).width + 10;
  }
}
