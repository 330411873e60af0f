// @ts-check
// What the parts of the panel share: the newest messages, the choices of this view, events.
import { Store } from "../charts/store.js";
import { remember, remembered } from "./memory.js";
import { watchTheme } from "./theme.js";

let contexts = 0;
const CHOICES = {
  tab: "traces", theme: "auto", palette: "historical", overlays: {},
  window: 600, unseen: [], objects: false, columns: [], // of the charts
};

/**
 * Events: each type of message from Python, with (head, buffers), after the context has taken it
 * in; "local" (name) when a choice of this view was made; "theme" when the colours have changed;
 * "reset" when the steps begin anew; "looking" when another step is looked at; "keys" to show the
 * list of keys; "axis" and "cursor" of the charts. A "frame" that is late is left out.
 */
export function makeContext(el, send) {
  const listeners = new Map();
  const endings = [];
  const wanted = new Set(); // groups of columns
  const wanting = []; // those that are asked for next
  const context = {
    id: ++contexts,
    el,
    send,
    setup: null, // the newest messages
    state: { state: "paused", k: -1, steps: 0, resets: 0, values: {} },
    frame: null, // the head that is shown, with `picture`, an ImageBitmap
    store: new Store(), // rows of the trace
    newest: -1, // the newest step
    looking: null, // the past step that is shown; null = the newest
    local: remembered(CHOICES), // choices of this view alone, which the browser keeps
    on(type, listener) {
      if (!listeners.has(type)) listeners.set(type, []);
      listeners.get(type).push(listener);
    },
    emit(type, ...values) {
      for (const listener of listeners.get(type) ?? []) listener(...values);
    },
    choose(name, value) {
      context.local[name] = value;
      remember(context.local);
      theme.follow();
      context.emit("local", name);
    },
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
    onEnd: (ending) => endings.push(ending),
    end: () => endings.forEach((ending) => ending()),
  };
  const theme = watchTheme(el, context.local, () => context.emit("theme"));
  context.onEnd(theme.end);
  return context;
}
