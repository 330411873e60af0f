// @ts-check
// A sample of how a layer is drawn.
import { make } from "../base/dom.js";

/** `kind` "line", "stairs", "dots" or "cross". */
export function makeSwatch(kind, color) {
  const swatch = make("i", { className: `robsim-swatch robsim-swatch-${kind}` });
  swatch.style.color = color;
  return swatch;
}
