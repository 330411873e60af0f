// @ts-check
// What a live camera delivers: in the place of the speed, which it sets.
import { make } from "../base/dom.js";
import { text } from "../base/texts.js";

const LONGEST_GAP = 1; // s, or three frames, after which a camera is taken to hang

export function makeCameraRate(context) {
  const part = (name) => make("span", { className: `robsim-${name}` });
  const parts = ["rate", "dropped", "age"].map(part); // the last one comes and goes
  const [rateOf, droppedOf, ageOf] = parts;
  const output = make("span", { className: "robsim-number robsim-camera-rate" }, ...parts);
  const label = make("span", { textContent: text("camera") });
  const about = { className: "robsim-field robsim-camera-field", title: text("camera.title") };
  const element = make("div", about, label, output);
  context.on("state", ({ camera }) => {
    if (!camera) return;
    const { rate, age, dropped } = camera;
    const hangs = age > Math.max(LONGEST_GAP, 3 * (context.setup?.dt ?? 0));
    rateOf.textContent = text("camera.rate", { rate: rate?.toFixed(1) ?? "\u2013" });
    droppedOf.textContent = text("camera.dropped", { dropped });
    ageOf.textContent = age == null ? "" : hangs
      ? text("camera.age.s", { age: age.toFixed(0) })
      : text("camera.age.ms", { age: (1000 * age).toFixed(0) });
    output.classList.toggle("robsim-hangs", hangs);
  });
  return { name: "camera", element };
}
