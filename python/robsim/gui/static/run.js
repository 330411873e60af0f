// The shared data of the parts of a run's panel, in addition to the data of all panels.
import { asFloats } from "./base/buffers.js";
import { makeContext } from "./base/context.js";
import { StepAxis } from "./charts/axis.js";

const CHOICES = {
  tab: "traces", overlays: {},
  window: 600, unseen: [], objects: false, columns: [], // of the charts
};

const UNSEEN = 500; // ms after a reset without a picture

// ms between two "shown" by frames without rows: what changes faster cannot be read, and each change
// lays the page out
const CALM = { playing: 100, running: 300 };

/**
 * More events. "reset": the steps begin again. "looking": another step is looked at. "shown":
 * numbers, time line and charts go to another step, all at once. "marked": another step is marked
 * in the charts. "keys" shows the list of keys. "axis" and "cursor" are of the charts. A "frame"
 * that is late is left out.
 */
export function makeRunContext(el, send) {
  const wanted = new Set(); // groups of columns
  const wanting = []; // groups for the next request
  let known = 0; // resets
  const context = makeContext(el, send, CHOICES);
  Object.assign(context, {
    state: { state: "paused", k: -1, steps: 0, values: {} },
    store: new Store(), // rows of the trace
    ghosts: [], // other runs, {name, ink, rows: pose and error}
    newest: -1, // the newest step
    looking: null, // the past step that is shown; null = the newest
    shown: -1, // the step that is shown
    last: -1, // the last step that can be: while it runs the one that is shown
    marked: null, // the step that is shown if it is not the newest one
    look(k) {
      context.looking = k;
      el.dataset.looking = k == null ? "newest" : "past";
      send({ type: "look", k });
      context.emit("looking");
    },
    /** Return the time of a step (s). */
    timeOf: (k) =>
      (context.frame?.k == k ? context.frame.t : context.store.get("t")?.get(k, 0))
        ?? k * (context.setup?.dt ?? 0),
    /** Request further groups of columns. */
    want(names) {
      const lacking = names.filter((name) => !wanted.has(name));
      if (!lacking.length) return;
      if (!wanting.length)
        queueMicrotask(() => send({ type: "columns", names: wanting.splice(0) }));
      lacking.forEach((name) => wanted.add(name));
      wanting.push(...lacking);
    },
  });
  let told = -Infinity; // when
  const tell = () => {
    const { looking, frame, newest, state, marked } = context;
    told = performance.now();
    const isEmpty = newest < 0 && frame?.k != 0; // step 0 is shown before it is done
    context.shown = looking ?? (isEmpty ? -1 : (frame?.k ?? newest));
    context.marked = looking ?? (frame?.past ? frame.k : null); // of a trace that is played back
    const isGrowing = state.state == "running" && context.marked == null;
    context.last = isGrowing ? context.shown : Math.max(newest, context.shown);
    context.emit("shown");
    if (context.marked != marked) context.emit("marked");
  };
  /** Take a picture of the old run away if none of the new one comes, as with a delay. */
  const forget = (old) => setTimeout(() => {
    if (context.newest >= 0 || context.frame != old || !old) return;
    context.frame = null;
    context.emit("local");
    tell();
  }, UNSEEN);
  context.on("state", ({ k, resets }) => {
    context.newest = k;
    if (resets != known) {
      known = resets;
      context.emit("reset");
      forget(context.frame);
      if (context.looking != null) context.look(null);
    }
    tell();
  });
  context.on("setup looking", tell);
  context.on("ghosts", ({ names }, buffers) => {
    context.ghosts = names.map((name, i) => {
      const rows = new Rows(6);
      rows.put(0, asFloats(buffers[i]));
      return { name, ink: `ghost-${i + 1}`, rows };
    });
  });
  context.on("rows", () => (context.marked != null || context.state.state != "running") && tell());
  context.on("frame", ({ rows, past }) => {
    const calm = past ? CALM.playing : CALM.running;
    const isDue = rows.length || context.state.state != "running";
    if (isDue || performance.now() >= told + calm) tell();
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

  /** The number of steps with data. */
  get count() {
    return Math.max(0, ...[...this.columns.values()].map((rows) => rows.count));
  }
}
