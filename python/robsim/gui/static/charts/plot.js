// Lines, dots and bands of one chart. Where many rows fall on a pixel, their extremes are drawn.
import { BLOCK, eachColumn } from "./decimate.js";
import { folded } from "./series.js";

const LINE_WIDTH = 1.5; // px
const STROKE_ROWS = 16; // a long line that goes up and down is slow to stroke as a whole
const JOIN_ALPHA = 0.35;
export const BAND = 2; // standard deviations

/** Where a chart draws: its steps, its range, its pixels. */
export class Plot {
  /**
   * @param {CanvasRenderingContext2D} g
   * @param {{left: number, top: number, width: number, height: number}} box
   * @param {{first: number, last: number}} axis
   * @param {number[]} range
   * @param {number} ratio device pixels to a pixel
   */
  constructor(g, box, axis, range, ratio) {
    Object.assign(this,
      { g, box, first: axis.first, last: axis.last, low: range[0], high: range[1], ratio });
    this.perStep = box.width / (axis.last - axis.first); // px
    this.perUnit = box.height / (range[1] - range[0]);
  }

  x(k) {
    return this.box.left + (k - this.first) * this.perStep;
  }

  y(value) {
    return this.box.top + (this.high - value) * this.perUnit;
  }

  /** The step at an x, and the value at a y. */
  step(x) {
    return this.first + (x - this.box.left) / this.perStep;
  }

  value(y) {
    return this.high - (y - this.box.top) / this.perUnit;
  }

  /** The middle of the device pixel at a coordinate, where a thin line is crisp. */
  crisp(at) {
    return (Math.floor(at * this.ratio) + 0.5) / this.ratio;
  }

  /** Rows to a device pixel. */
  get density() {
    return 1 / (this.perStep * this.ratio);
  }

  /** The rows of a series that are seen, with one more on each side. */
  rows(series) {
    return [Math.max(0, Math.floor(this.first)), Math.min(series.count, Math.ceil(this.last) + 2)];
  }
}

const isDense = (plot) => plot.density > BLOCK / 2;

/** Call `each(left, right, low, high)`, in whole device pixels, for the columns of a series. */
function eachBar(plot, series, each) {
  const rows = Math.max(plot.density, BLOCK);
  // so that a column has the same rows after a pan
  const first = Math.floor(plot.first / rows) * rows;
  const edge = (column) => Math.round(plot.x(first + column * rows) * plot.ratio) / plot.ratio;
  eachColumn(series.extremes, first, plot.last + rows, rows, (column, low, high) =>
    each(edge(column), edge(column + 1), low, high));
}

/** Return the one or two arcPieces of an interval on a circle. */
function arcPieces(low, high, period) {
  if (!period) return [[low, high]];
  const half = period / 2;
  if (high - low >= period) return [[-half, half]];
  const whole = folded(low, high, period);
  if (whole) return [whole];
  const turn = period * Math.floor(low / period + 0.5);
  return [[low - turn, half], [-half, high - turn - period]];
}

/** Draw bars from the lowest to the highest, which touch each other if `isLine`. */
function fillBars(plot, series, ink, thickness, isLine) {
  const { g } = plot;
  let before = null;
  g.fillStyle = ink;
  g.beginPath();
  eachBar(plot, series, (left, right, low, high) => {
    const isNext = isLine && before?.right == left;
    const from = isNext ? Math.min(low, before.high) : low;
    const to = isNext ? Math.max(high, before.low) : high;
    for (const [start, end] of arcPieces(from, to, series.period)) {
      const top = plot.y(end) - thickness / 2;
      g.rect(left, top, right - left, plot.y(start) - top + thickness / 2);
    }
    before = { right, low, high };
  });
  g.fill();
}

export function paintLine(plot, series, ink, { isStairs = false, width = LINE_WIDTH } = {}) {
  if (isDense(plot)) return fillBars(plot, series, ink, width, true);
  const { g } = plot;
  g.strokeStyle = ink;
  g.lineWidth = width;
  g.lineJoin = "round";
  const [first, last] = plot.rows(series);
  const rows = g.globalAlpha == 1 ? STROKE_ROWS : last; // drawing twice would be darker
  for (let begin = first; begin < last; begin += rows) {
    g.beginPath();
    const range = [Math.max(begin - 1, first), Math.min(begin + rows + 1, last)]; // so they join
    traceLine(plot, series, isStairs, range);
    g.stroke();
  }
}

function traceLine(plot, series, isStairs, [begin, end]) {
  const { g } = plot;
  const half = series.period / 2;
  let before = NaN;
  for (let k = begin; k < end; k++) {
    const value = series.value(k);
    const x = plot.x(k);
    if (before !== before) g.moveTo(x, plot.y(value));
    else if (half && Math.abs(value - before) > half) {
      const turn = value > before ? -series.period : series.period;
      g.lineTo(x, plot.y(value + turn));
      g.moveTo(plot.x(k - 1), plot.y(before - turn));
      g.lineTo(x, plot.y(value));
    } else if (value === value) {
      if (isStairs) g.lineTo(x, plot.y(before));
      g.lineTo(x, plot.y(value));
    }
    before = value;
  }
}

export function paintDots(plot, series, ink, { size, isJoined = false }) {
  if (isDense(plot)) return fillBars(plot, series, ink, size, false);
  const { g } = plot;
  if (isJoined) {
    g.globalAlpha = JOIN_ALPHA;
    paintLine(plot, series, ink, { width: 1 });
    g.globalAlpha = 1;
  }
  const side = Math.min(Math.max(size, plot.perStep * 0.6), size + 2);
  const isRound = side >= 3;
  g.fillStyle = ink;
  g.beginPath();
  const [begin, end] = plot.rows(series);
  for (let k = begin; k < end; k++) {
    const value = series.value(k);
    if (value !== value) continue;
    const [x, y] = [plot.x(k), plot.y(value)];
    if (isRound) {
      g.moveTo(x + side / 2, y);
      g.arc(x, y, side / 2, 0, 2 * Math.PI);
    } else g.rect(x - side / 2, y - side / 2, side, side);
  }
  g.fill();
}

/** Draw the band around a series; its standard deviation is `sigma` times the spread. */
export function paintBand(plot, series, spread, sigma, ink) {
  const factor = BAND * sigma;
  plot.g.fillStyle = ink;
  plot.g.beginPath();
  if (isDense(plot)) traceBandBars(plot, series, spread, factor);
  else traceBand(plot, series, spread, factor);
  plot.g.fill();
}

function traceBandBars(plot, series, spread, factor) {
  const widest = new Map();
  eachBar(plot, spread, (left, _, __, high) => widest.set(left, high * factor));
  eachBar(plot, series, (left, right, low, high) => {
    if (!widest.has(left)) return;
    const band = [low - widest.get(left), high + widest.get(left)];
    for (const [start, end] of arcPieces(...band, series.period))
      plot.g.rect(left, plot.y(end), right - left, plot.y(start) - plot.y(end));
  });
}

function traceBand(plot, series, spread, factor) {
  const [first, end] = plot.rows(series);
  const half = series.period / 2 || Infinity;
  let begin = first; // of the run of steps that hang together
  let [low, high] = [Infinity, -Infinity];
  const finish = (k) => {
    const trace = (turn) => traceRun(plot, series, spread, factor, begin, k, turn);
    if (k > begin) trace(0);
    if (k > begin && high > half) trace(-series.period); // seen on both sides of the break
    if (k > begin && low < -half) trace(series.period);
    [begin, low, high] = [k, Infinity, -Infinity];
  };
  let before = NaN;
  for (let k = first; k < end; k++) {
    const value = series.value(k);
    const width = spread.value(k) * factor;
    const isKnown = width < Infinity && value === value;
    if (!isKnown || Math.abs(value - before) > half) finish(k);
    if (isKnown) {
      low = Math.min(low, value - width);
      high = Math.max(high, value + width);
    } else begin = k + 1;
    before = value;
  }
  finish(end);
}

function traceRun(plot, series, spread, factor, begin, end, turn) {
  const { g } = plot;
  g.moveTo(plot.x(begin), plot.y(series.value(begin) + turn));
  const edge = (k, side) =>
    g.lineTo(plot.x(k), plot.y(series.value(k) + side * factor * spread.value(k) + turn));
  for (let k = begin; k < end; k++) edge(k, 1);
  for (let k = end - 1; k >= begin; k--) edge(k, -1);
  g.closePath();
}

/** Draw crosses at a value along the whole width, the last one at its end. */
export function paintCrosses(plot, value, ink, gap = 56, size = 3.5) {
  const { g, box } = plot;
  const y = plot.y(value);
  g.strokeStyle = ink;
  g.lineWidth = LINE_WIDTH;
  g.beginPath();
  for (let x = box.left + box.width - size - 1; x > box.left + size; x -= gap) {
    g.moveTo(x - size, y - size);
    g.lineTo(x + size, y + size);
    g.moveTo(x - size, y + size);
    g.lineTo(x + size, y - size);
  }
  g.stroke();
}

/** Draw small arrows at the edge where a series goes beyond it. */
export function paintBeyond(plot, series, ink) {
  const { g, box } = plot;
  g.fillStyle = ink;
  g.beginPath();
  const [begin, end] = plot.rows(series);
  const apart = { [-1]: -Infinity, 1: -Infinity }; // the x of the last arrow on each side
  const mark = (x, low, high) => {
    for (const side of [-1, 1]) {
      const isBeyond = side > 0 ? high > plot.high : low < plot.low;
      if (!isBeyond || x - apart[side] < 9 || x < box.left || x > box.left + box.width) continue;
      apart[side] = x;
      traceArrow(g, x, side > 0 ? box.top : box.top + box.height, side);
    }
  };
  if (isDense(plot)) eachBar(plot, series, (left, _, low, high) => mark(left, low, high));
  else for (let k = begin; k < end; k++) mark(plot.x(k), series.value(k), series.value(k));
  g.fill();
}

function traceArrow(g, x, y, side) {
  g.moveTo(x, y + side);
  g.lineTo(x - 3.5, y + 6 * side);
  g.lineTo(x + 3.5, y + 6 * side);
  g.closePath();
}
