// @ts-check
// What the parts of the panel of a run share, beside what all panels have.
import { makeContext } from "./base/context.js";
import { Store } from "./charts/store.js";

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
  const context = makeContext(el, send, CHOICES);
  return Object.assign(context, {
    state: { state: "paused", k: -1, steps: 0, resets: 0, values: {} },
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
}
