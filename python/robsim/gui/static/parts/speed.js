// @ts-check
// How fast it runs: from a fifth of real time to as fast as it goes, in steps that look alike.
import { text } from "../base/texts.js";

const FASTEST = 0; // what stands for "as fast as it goes"
const SPEEDS = [0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, FASTEST];

/** The control, see `makeField`: its slider has the places of the speeds. */
export const SPEED = {
  name: "speed", kind: "range", low: 0, high: SPEEDS.length - 1, step: 1,
  valueAt: (place) => SPEEDS[place],
  placeOf: nearest,
  wordsOf: (speed) => (speed == FASTEST ? text("speed.fastest") : text("speed.times", { speed })),
};

function nearest(speed) {
  if (speed == FASTEST) return SPEEDS.length - 1;
  const distance = (other) => Math.abs(Math.log(other / speed));
  const slow = SPEEDS.slice(0, -1);
  return slow.reduce((best, other, i) => (distance(other) < distance(slow[best]) ? i : best), 0);
}
