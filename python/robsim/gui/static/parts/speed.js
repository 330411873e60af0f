// @ts-check
// How fast it runs: from a fifth of real time to as fast as it goes, in steps that look alike.
import { make } from "../base/dom.js";
import { heldValue } from "../base/held_value.js";
import { makeSlider, showSlider } from "../base/slider.js";
import { text } from "../base/texts.js";

const FASTEST = 0; // what stands for "as fast as it goes"
const SPEEDS = [0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, FASTEST];

/** As `makeField`, for the speed. */
export function makeSpeed(send) {
  const last = SPEEDS.length - 1;
  const slider = makeSlider("speed", { min: 0, max: last, step: 1 });
  slider.ariaLabel = text("control.speed");
  const output = make("output");
  const name = make("span", { textContent: text("control.speed") });
  const about = { className: "robsim-field", title: text("control.speed.title") };
  const element = make("label", about, name, slider, output);

  const show = (speed) => {
    output.textContent = speed == FASTEST ? text("speed.fastest") : text("speed.times", { speed });
    showSlider(slider, nearest(speed), output.textContent);
  };
  const value = heldValue(slider, show, send);
  slider.addEventListener("input", () => value.set(SPEEDS[Number(slider.value)]));
  return { name: "speed", element, show: value.tell, end: value.end };
}

function nearest(speed) {
  if (speed == FASTEST) return SPEEDS.length - 1;
  const distance = (other) => Math.abs(Math.log(other / speed));
  const slow = SPEEDS.slice(0, -1);
  return slow.reduce((best, other, i) => (distance(other) < distance(slow[best]) ? i : best), 0);
}
