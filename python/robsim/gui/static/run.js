// What the parts of the panel of a run share, beside what all panels have.
import { asFloats } from "./base/buffers.js";
import { makeContext } from "./base/context.js";
import { StepAxis } from "./charts/axis.js";

const CHOICES = {
  tab: "traces", overlays: {},
  window: 600, unseen: [], objects: false, columns: [], // of the charts
};

/**
 * More events: "reset" when the steps begin anew; "looking" when another step is looked at; "keys"
 * to show the list of keys; "axis" and "cursor" of the charts. A "frame" that is late is left out.
 */
export function makeRunContext(el, send) {
  const wanted = new Set(); // groups of columns
  const wanting = []; // those that are asked for next
  let known = 0; // resets
  const context = makeContext(el, send, CHOICES);
  Object.assign(context, {
    state: { state: "paused", k: -1, steps: 0, values: {} },
    store: new Store(), // rows of the trace
    newest: -1, // the newest step
    looking: null, // the past step that is shown; null = the newest
    look(k) {
      context.looking = k;
      el.dataset.looking = k == null ? "newest" : "past";
      send({ type: "look", k });
      context.emit("looking");
    },
    /** Ask for groups of columns that are not asked for yet. */
    want(names) {
      const lacking = names.filter((name) => !wanted.has(name));
      if (!lacking.length) return;
      if (!wanting.length)
        queueMicrotask(() => send({ type: "columns", names: wanting.splice(0) }));
      lacking.forEach((name) => wanted.add(name));
      wanting.push(...lacking);
    },
  });
  context.on("state", ({ k, resets }) => {
    context.newest = k;
    if (resets == known) return;
    known = resets;
    context.emit("reset");
    if (context.looking != null) context.look(null);
  });
  context.axis = new StepAxis(context); // which steps all charts show
  return context;
}

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

class Store {
  columns = new Map();

  /** Take in the entries of a message, and the buffers of these. */
  take(entries, buffers) {
    entries.forEach(({ column, first, width }, i) => {
      let rows = this.columns.get(column);
      if (rows?.width != width) this.columns.set(column, (rows = new Rows(width)));
      rows.put(first, asFloats(buffers[i]));
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
