// @ts-check
// What the parts of a panel share: the newest messages, the choices of this view, events.
import { remember, remembered } from "./memory.js";
import { watchTheme } from "./theme.js";

let contexts = 0;
const LOOKS = { theme: "auto", palette: "historical" };

/**
 * Make it for a panel that keeps these choices beside its looks. Events: each type of message from
 * Python, with (head, buffers), after the context has taken it in; "local" (name) when a choice of
 * this view was made; "theme" when the colours have changed.
 */
export function makeContext(el, send, choices = {}) {
  const listeners = new Map();
  const endings = [];
  const context = {
    id: ++contexts,
    el,
    send,
    setup: null, // the newest messages
    state: { state: "paused", values: {} },
    frame: null, // the head that is shown, with `picture`, an ImageBitmap
    local: remembered({ ...LOOKS, ...choices }), // of this view alone, which the browser keeps
    /** Listen to events: `types` is one type or several, such as "setup state". */
    on(types, listener) {
      for (const type of types.split(" "))
        listeners.set(type, [...(listeners.get(type) ?? []), listener]);
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
    onEnd: (...more) => endings.push(...more),
    end: () => endings.forEach((ending) => ending()),
  };
  const theme = watchTheme(el, context.local, () => context.emit("theme"));
  context.onEnd(theme.end);
  return context;
}
