// @ts-check
// The colours of a panel for its charts, read once for each theme.
import { color } from "../base/theme.js";

const inkwells = new WeakMap();

/** Return a function from the name of a custom property, without "--robsim-", to its value. */
export function inksOf(context) {
  if (!inkwells.has(context)) {
    const known = new Map();
    context.on("theme", () => known.clear());
    inkwells.set(context, (name) => {
      if (name.startsWith("#")) return name;
      if (!known.has(name)) known.set(name, color(context.el, `--robsim-${name}`));
      return known.get(name);
    });
  }
  return inkwells.get(context);
}
