// The series of a chart: numbers computed from the rows of the trace, step by step.
import { Extremes } from "./decimate.js";

const EXACT_ROWS = 256; // rows, up to which a range is computed from each of them

export const DEGREES = 180 / Math.PI;

/** Return an angle in degrees from -180 to 180. */
export const wrappedDegrees = (angle) => angle - 360 * Math.round(angle / 360);

/**
 * Return the interval moved by whole periods to -period/2 ...; null if it lies across an end of
 * that.
 */
export function folded(low, high, period) {
  const shift = period * Math.floor(low / period + 0.5);
  return high - shift > period / 2 ? null : [low - shift, high - shift];
}

export class Series {
  /**
   * @param store the rows
   * @param {string[]} groups of columns that it needs
   * @param {(rows: any[], k: number) => number} read the number of a step from them; NaN = none
   * @param {number} period 360 for a heading, which is drawn with breaks; 0 = none
   */
  constructor(store, groups, read, period = 0) {
    Object.assign(this, { store, groups, read, period });
    this.extremes = new Extremes(); // for a heading, extremes count its turns
    this.rows = [];
    this.epochs = [];
    this.turned = NaN; // the newest heading, with its turns
  }

  get count() {
    return this.extremes.count;
  }

  /** Take in the new rows, or all of them if old ones have changed. */
  update() {
    const rows = this.groups.map((name) => this.store.get(name));
    const isThere = rows.every(Boolean);
    const isNew = rows.some((group, i) => group != this.rows[i] || group?.epoch != this.epochs[i]);
    if (isNew) {
      this.extremes.clear();
      this.turned = NaN;
      this.rows = rows;
      this.epochs = rows.map((group) => group?.epoch);
    }
    if (isThere)
      this.extremes.extend(Math.min(...rows.map((group) => group.count)), this.unwrapped);
  }

  value(k) {
    return k >= 0 && k < this.extremes.count ? this.read(this.rows, k) : NaN;
  }

  unwrapped = (k) => {
    const value = this.read(this.rows, k);
    if (!this.period || value !== value) return value;
    const turns = this.turned === this.turned ? Math.round((this.turned - value) / this.period) : 0;
    this.turned = value + turns * this.period;
    return this.turned;
  };

  /** Return the extremes of the steps from `first` to `last`; low > high without values. */
  range(first, last) {
    const from = Math.max(0, Math.ceil(first));
    const to = Math.min(this.count, Math.floor(last) + 1);
    if (this.period) {
      const [low, high] = this.extremes.range(from, to);
      if (low > high) return [low, high];
      return folded(low, high, this.period) ?? [-this.period / 2, this.period / 2];
    }
    return to - from > EXACT_ROWS ? this.extremes.range(from, to) : this.exactRange(from, to);
  }

  exactRange(from, to) {
    let [low, high] = [Infinity, -Infinity];
    for (let k = from; k < to; k++) {
      const value = this.read(this.rows, k);
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return [low, high];
  }

  /** Return the range without the lowest and highest part (0.02 = 2 %) of the steps. */
  robustRange(first, last, part) {
    const gap = Math.max(1, (last - first) / EXACT_ROWS);
    const values = [];
    for (let k = Math.max(0, first); k <= last; k += gap) values.push(this.value(Math.round(k)));
    const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
    if (!sorted.length) return [Infinity, -Infinity];
    const cut = Math.floor(part * (sorted.length - 1));
    return [sorted[cut], sorted[sorted.length - 1 - cut]];
  }
}
