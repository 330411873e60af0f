// Extremes of a sequence that grows, by blocks of rows: a million rows are drawn as a few thousand,
// and no outlier is lost.

export const BLOCK = 8; // rows, of the finest blocks
const BLOCK_RATIO = 4; // from level to level

export class Extremes {
  constructor() {
    this.clear();
  }

  clear() {
    this.count = 0;
    this.levels = [new Float64Array(64)]; // low, high of each block; none: low > high
  }

  /** Add rows up to `count`; `value(row)` is called once for each, NaN = none. */
  extend(count, value) {
    const begin = this.count;
    for (let row = begin; row < count; row++) {
      const at = 2 * Math.floor(row / BLOCK);
      if (row % BLOCK == 0) this.open(0, at);
      const level = this.levels[0];
      const number = value(row);
      if (number < level[at]) level[at] = number;
      if (number > level[at + 1]) level[at + 1] = number;
    }
    this.count = count;
    if (begin < count) this.coarsen(begin);
  }

  open(level, at) {
    const blocks = this.levels[level];
    if (at >= blocks.length) {
      this.levels[level] = new Float64Array(2 * blocks.length);
      this.levels[level].set(blocks);
    }
    this.levels[level][at] = Infinity;
    this.levels[level][at + 1] = -Infinity;
  }

  /** Renew the coarser levels for the rows from `begin` on. */
  coarsen(begin) {
    let size = BLOCK;
    for (let level = 1; size < this.count; level++) {
      const children = Math.ceil(this.count / size);
      size *= BLOCK_RATIO;
      this.levels[level] ??= new Float64Array(64);
      for (let block = Math.floor(begin / size); block * size < this.count; block++) {
        this.open(level, 2 * block);
        const last = Math.min(children, (block + 1) * BLOCK_RATIO);
        for (let child = block * BLOCK_RATIO; child < last; child++)
          this.merge(level, block, child);
      }
    }
  }

  merge(level, block, child) {
    const [from, to] = [this.levels[level - 1], this.levels[level]];
    to[2 * block] = Math.min(to[2 * block], from[2 * child]);
    to[2 * block + 1] = Math.max(to[2 * block + 1], from[2 * child + 1]);
  }

  /** Call `each(block's first row, low, high)` for blocks of up to `most` rows (8 at least). */
  visit(first, last, most, each) {
    let level = 0;
    let size = BLOCK;
    while (size * BLOCK_RATIO <= most && level + 1 < this.levels.length) {
      level += 1;
      size *= BLOCK_RATIO;
    }
    const blocks = this.levels[level];
    const end = Math.min(Math.ceil(last / size), Math.ceil(this.count / size));
    for (let block = Math.max(0, Math.floor(first / size)); block < end; block++) {
      const [low, high] = [blocks[2 * block], blocks[2 * block + 1]];
      if (low <= high) each(block * size, low, high);
    }
  }

  /** Return the extremes of rows, and of a few neighbours. */
  range(first, last) {
    let [low, high] = [Infinity, -Infinity];
    this.visit(first, last, (last - first) / 32, (_, blockLow, blockHigh) => {
      low = Math.min(low, blockLow);
      high = Math.max(high, blockHigh);
    });
    return [low, high];
  }
}

/** Call `each(column, low, high)` for columns that are `rows` wide, from `first` on. */
export function eachColumn(extremes, first, last, rows, each) {
  let column = NaN;
  let [low, high] = [Infinity, -Infinity];
  extremes.visit(first, last, rows, (row, blockLow, blockHigh) => {
    const next = Math.floor((row - first) / rows);
    if (next != column) {
      if (low <= high) each(column, low, high);
      [column, low, high] = [next, Infinity, -Infinity];
    }
    low = Math.min(low, blockLow);
    high = Math.max(high, blockHigh);
  });
  if (low <= high) each(column, low, high);
}
