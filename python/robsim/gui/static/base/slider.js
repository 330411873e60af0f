// @ts-check
import { make } from "./dom.js";

/** A slider from `min` to `max`. */
export function makeSlider(name, { min, max, step }) {
  const slider = make("input", { type: "range", className: "robsim-slider", name });
  return Object.assign(slider, { min: String(min), max: String(max), step: String(step) });
}

/** Show a value, which `words` say for screen readers. */
export function showSlider(slider, value, words) {
  const [min, max] = [Number(slider.min), Number(slider.max)];
  slider.value = String(value);
  const part = max > min ? (100 * (value - min)) / (max - min) : 0;
  slider.style.setProperty("--robsim-part", `${part}%`);
  slider.setAttribute("aria-valuetext", words);
}
