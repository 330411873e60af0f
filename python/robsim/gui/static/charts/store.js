// @ts-check
// The rows of the trace that have come, by group of columns.
import { asFloats } from "../base/buffers.js";

/** Rows of float32 that grow: `get(row, field)`. `epoch` changes when a row that was there does. */
export class Rows {
  constructor(width) {
    this.width = width;
    this.count = 0;
    this.epoch = 0;
    this.data = new Float32Array(64 * width);
  }

  put(first, block) {
    const need = first * this.width + block.length;
    if (need > this.data.length) {
      const larger = new Float32Array(Math.max(2 * this.data.length, need));
      larger.set(this.data);
      this.data = larger;
    }
    if (first < this.count) this.epoch += 1;
    this.data.set(block, first * this.width);
    this.count = this.width ? need / this.width : 0;
  }

  get(row, field) {
    return this.data[row * this.width + field];
  }
}

export class Store {
  columns = new Map();

  /** Take in the entries of a message, and its buffers from `at` on. */
  take(entries, buffers, at) {
    entries.forEach(({ column, first, width }, i) => {
      let rows = this.columns.get(column);
      if (rows?.width != width) this.columns.set(column, (rows = new Rows(width)));
      rows.put(first, asFloats(buffers[at + i]));
    });
  }

  get(column) {
    return this.columns.get(column);
  }

  /** The number of steps of which there is something. */
  get count() {
    return Math.max(0, ...[...this.columns.values()].map((rows) => rows.count));
  }
}
