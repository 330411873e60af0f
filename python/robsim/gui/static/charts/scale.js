// Ticks of axes, and numbers as texts.
import { BAND } from "./plot.js";

const MANTISSAS = [1, 2, 5, 10];
const ANGLES = [15, 30, 45, 90, 180]; // degrees, above 10
const WILD_PART = 0.04; // of the steps on each side, for a robust range

/** Return the distance of ticks so that there are about `count`, at least `least`. */
export function tickGap(length, count, { least = 0, isAngle = false } = {}) {
  const wanted = Math.max(length / Math.max(count, 1), least, Number.MIN_VALUE);
  if (isAngle && wanted > 10) return ANGLES.find((angle) => angle >= wanted * 0.8) ?? 180;
  const unit = 10 ** powerOf(wanted);
  return unit * MANTISSAS.find((mantissa) => mantissa * unit >= wanted * 0.999);
}

/** Return the multiples of `gap` from `low` to `high`. */
export function ticksOf(low, high, gap) {
  const ticks = [];
  for (let i = Math.ceil(low / gap - 1e-6); i * gap <= high + gap * 1e-6; i++) ticks.push(i * gap);
  return ticks;
}

/**
 * Return the range with some air, ended at round numbers, so that it does not change with each row.
 */
export function airyRange(low, high, least, options = {}) {
  if (low > high) return null;
  const air = Math.max(0.06 * (high - low), (least - (high - low)) / 2, 1e-6 * Math.abs(high));
  const gap = tickGap(high - low + 2 * air, 8, options);
  return [Math.floor((low - air) / gap) * gap, Math.ceil((high + air) / gap) * gap];
}

const powerOf = (size) => Math.floor(Math.log10(size) + 1e-6);

const signed = (text) => text.replace("-", "\u2212").replace(/^\u2212(0\.?0*)$/, "$1");

/** Return a tick's number as a text. */
export function tickText(value, gap) {
  if (Math.abs(value) < gap * 1e-6) return "0";
  const size = Math.abs(value);
  if (gap >= 1000 && size >= 1e4) return signed(`${+(value / 1000).toFixed(3)}k`);
  if (size >= 1e6 || size < 1e-3)
    return exponential(value, 1 + Math.max(0, powerOf(size) - powerOf(gap)));
  return signed(value.toFixed(Math.max(0, Math.ceil(-Math.log10(gap) - 1e-6))));
}

/** Return a number as a text with some significant digits. */
export function numberText(value, digits = 4) {
  if (!Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  if (size && (size < 1e-3 || size >= 1e6)) return exponential(value, digits);
  const before = size < 1 ? 1 : powerOf(size) + 1;
  return signed(value.toFixed(Math.max(0, digits - before)));
}

/** Return a number as a text, to two digits of a size, four decimals at most. */
export const decimalText = (value, size) =>
  signed(value.toFixed(Math.min(Math.max(1 - powerOf(size), 0), 4)));

/** Return a number to the accuracy of a standard error, such as "1.938 ± 0.012". */
export function uncertainText(value, error) {
  if (!Number.isFinite(error) || !Number.isFinite(value)) return numberText(value);
  const lead = error > 0 ? powerOf(error) : 0;
  const size = value ? powerOf(Math.abs(value)) : lead;
  const digits = Math.min(Math.max(size - lead + 2, 1), 5);
  if (lead < -5 || lead > 4 || size > 5)
    return `${numberText(value, digits)} \u00b1 ${exponential(error, 1)}`;
  const decimals = Math.max(0, 1 - lead);
  return `${signed(value.toFixed(decimals))} \u00b1 ${error.toFixed(decimals)}`;
}

function exponential(value, digits) {
  const [mantissa, exponent] = value.toExponential(Math.max(0, digits - 1)).split("e");
  return signed(`${mantissa}e`) + signed(String(Number(exponent)));
}

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
