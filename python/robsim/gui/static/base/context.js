// The shared data of a panel's parts: the newest messages, the choices of this view, events.
import { asPicture } from "./buffers.js";

let contexts = 0;
const LOOKS = { theme: "auto", palette: "historical" };
const PICTURES = { picture: "image/jpeg", mask: "image/png" }; // of a frame
const MEMORY_KEY = "robsim";

/**
 * Make it for a panel that keeps these choices beside its looks. Events: each type of message from
 * Python, with (head, buffers), after the context has taken it in; "local" (name) when a choice of
 * this view was made; "theme" when the colours have changed.
 */
export function makeContext(el, send, choices = {}) {
  const listeners = new Map();
  const inks = new Map();
  const ending = new AbortController();
  const { signal } = ending;
  let latest = null; // the head of the last frame that has come
  const context = {
    id: ++contexts,
    el,
    send,
    signal, // ends listeners outside of the view
    setup: null, // the newest messages
    state: { state: "paused", values: {} },
    frame: null, // the head that is shown, with its `pictures`, ImageBitmaps
    pictures: ["picture"],
    local: remembered({ ...LOOKS, ...choices }), // of this view alone, which the browser keeps
    /** Listen to events: `types` is one type or several, such as "setup state". */
    on(types, listener) {
      for (const type of types.split(" "))
        listeners.set(type, [...(listeners.get(type) ?? []), listener]);
    },
    emit(type, ...values) {
      for (const listener of listeners.get(type) ?? []) listener(...values);
    },
    /** Note a message when it comes, which may have to wait for its turn. */
    arrived(head) {
      if (head.type == "frame") latest = head;
    },
    /** Take in a message; a frame is left out if a newer one of its kind has come meanwhile. */
    async receive(head, buffers) {
      if (head.type == "setup") context.setup = head;
      if (head.type == "state") {
        context.state = head;
        el.dataset.state = head.state;
      }
      if (head.type == "frame") {
        if (head != latest && head.past == latest.past) return;
        for (const [i, name] of context.pictures.entries())
          head[name] = buffers[i]?.byteLength ? await asPicture(buffers[i], PICTURES[name]) : null;
        for (const name of context.pictures) context.frame?.[name]?.close();
        context.frame = head;
      }
      context.emit(head.type, head, buffers);
    },
    choose(name, value) {
      context.local[name] = value;
      remember(context.local);
      follow();
      context.emit("local", name);
    },
    /** Return a colour of the theme by its name, or "#..." as it is, for a canvas. */
    ink(name) {
      if (name.startsWith("#")) return name;
      if (!inks.has(name)) inks.set(name, color(el, name));
      return inks.get(name);
    },
    onEnd: (act) => signal.addEventListener("abort", act),
    end() {
      ending.abort();
      context.send = () => {}; // timers may outlive the view
    },
  };
  context.on("setup theme", () => inks.clear());
  const follow = watchTheme(context, () => context.emit("theme"));
  return context;
}

/** Return the choices of last time over these, as far as they are of the same kind. */
function remembered(choices) {
  const known = { ...choices };
  for (const [name, value] of Object.entries(keptChoices()))
    if (typeof value == typeof choices[name]) known[name] = value;
  return known;
}

/** Keep them, beside those that other panels keep. */
function remember(choices) {
  try {
    localStorage.setItem(MEMORY_KEY, JSON.stringify({ ...keptChoices(), ...choices }));
  } catch {
    // As below.
  }
}

function keptChoices() {
  try {
    const kept = JSON.parse(localStorage.getItem(MEMORY_KEY) ?? "{}");
    return typeof kept == "object" ? (kept ?? {}) : {};
  } catch {
    // A browser may forbid it, as in a notebook of a stranger; then everything begins as it stands
    // in the code.
    return {};
  }
}

/** Return the value of a custom property, which is named without "--robsim-". */
function color(el, name) {
  const value = getComputedStyle(el).getPropertyValue(`--robsim-${name}`).trim();
  const [, light, dark] = /^light-dark\((.*), (.*)\)$/.exec(value) ?? [];
  return (el.dataset.theme == "dark" ? dark : light) ?? value;
}

/** Whether the host is dark: JupyterLab, VS Code and Colab each report this differently. */
function isHostDark(media) {
  const { body, documentElement: root } = document;
  if (body.dataset.jpThemeLight) return body.dataset.jpThemeLight == "false";
  if (body.dataset.vscodeThemeKind) return !body.dataset.vscodeThemeKind.includes("light");
  if (root.hasAttribute("theme")) return root.getAttribute("theme") == "dark";
  return media.matches;
}

/**
 * Keep the theme and the palette of `el` as the host and `local` have them: `theme` "auto", "light"
 * or "dark", and `palette`; call `changed` after a change. Return what looks again.
 */
function watchTheme({ el, local, signal, onEnd }, changed) {
  const media = matchMedia("(prefers-color-scheme: dark)");
  const follow = () => {
    const dark = local.theme == "auto" ? isHostDark(media) : local.theme == "dark";
    const [theme, palette] = [dark ? "dark" : "light", local.palette];
    if (el.dataset.theme == theme && el.dataset.palette == palette) return;
    Object.assign(el.dataset, { theme, palette });
    changed();
  };
  const observer = new MutationObserver(follow);
  media.addEventListener("change", follow, { signal });
  observer.observe(document.body, { attributes: true });
  observer.observe(document.documentElement, { attributes: true });
  follow();
  onEnd(() => observer.disconnect());
  return follow;
}
