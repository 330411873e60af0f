// Notes: short texts that come and go; those on errors stay longer.
import { makeButton } from "../base/buttons.js";
import { make } from "../base/dom.js";

const STAY = { info: 6000, warning: 10000, error: 15000 }; // ms
const MOST_NOTES = 3;

export function makeNotes(context) {
  const element = make("div.robsim-toasts", { role: "status", ariaLive: "polite" });
  const shown = new Map(); // by text, so that repeated notes are shown once
  const drop = (words) => {
    clearTimeout(shown.get(words)?.timer);
    shown.get(words)?.toast.remove();
    shown.delete(words);
  };
  const wait = (words, level) => {
    const note = shown.get(words);
    clearTimeout(note.timer);
    note.timer = setTimeout(() => drop(words), STAY[level]);
  };
  const remarked = new Set();
  context.on("setup", ({ remarks = [] }) => {
    for (const words of remarks.filter((one) => !remarked.has(one))) {
      remarked.add(words);
      context.emit("note", { level: "info", text: words });
    }
  });
  context.on("note", ({ level, text: words, option }) => {
    if (option) return; // it stands beside its field
    if (!shown.has(words)) {
      if (level == "error") // one at a time: they cover controls
        for (const [other, note] of shown) if (note.level == "error") drop(other);
      const close = makeButton("close", "robsim-plain robsim-icon", () => drop(words));
      const toast = make(`div.robsim-surface.robsim-afloat.robsim-toast.robsim-toast-${level}`,
        make("span", words), close);
      toast.addEventListener("pointerenter", () => clearTimeout(shown.get(words)?.timer));
      toast.addEventListener("pointerleave", () => shown.has(words) && wait(words, level));
      shown.set(words, { toast, level, timer: 0 });
      element.append(toast);
      if (shown.size > MOST_NOTES) drop(shown.keys().next().value);
    }
    wait(words, level);
  });
  context.onEnd(() => [...shown.keys()].forEach(drop));
  return { element };
}
