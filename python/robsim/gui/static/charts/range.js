// @ts-check
// What range of values a chart shows by itself.
import { BAND } from "./plot.js";
import { airyRange } from "./scale.js";

const WILD_PART = 0.04; // of the steps on each side, for a robust range

/** Return [low, high] for some layers over the steps of an axis; null if nothing is known. */
export function autoRange(layers, axis, { least, isRobust, isAngle, truth }) {
  let [low, high] = [Infinity, -Infinity];
  const include = (value) => {
    if (!Number.isFinite(value)) return;
    low = Math.min(low, value);
    high = Math.max(high, value);
  };
  for (const layer of layers) {
    const { series, spread } = layer;
    const { first, last } = axis;
    const range = isRobust ? series.robustRange(first, last, WILD_PART) : series.range(first, last);
    range.forEach(include);
    if (spread && !isRobust && !series.period) newestBand(layer, axis).forEach(include);
    // The band of a heading, or one that is wide at first, must not squash the rest: it is cut.
  }
  if (truth !== null) include(truth);
  const full = layers.find(({ series }) => series.period && high - low >= series.period * 0.999);
  if (full) return [-full.series.period / 2, full.series.period / 2];
  return airyRange(low, high, least, { isAngle });
}

function newestBand({ series, spread, sigma }, axis) {
  const k = Math.min(Math.floor(axis.last), series.count - 1);
  const half = BAND * spread.value(k) * (sigma?.() ?? 1);
  return [series.value(k) - half, series.value(k) + half];
}
