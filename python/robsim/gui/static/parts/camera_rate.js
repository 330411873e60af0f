// @ts-check
// What a live camera delivers: in the place of the speed, which it sets.
import { make } from "../base/dom.js";
import { text } from "../base/texts.js";

const LONGEST_GAP = 1; // s, or three frames, after which a camera is taken to hang

export function makeCameraRate(context) {
  const output = make("span", { className: "robsim-number" });
  const label = make("span", { textContent: text("camera") });
  const about = { className: "robsim-field", title: text("camera.title") };
  const element = make("div", about, label, output);
  context.on("state", ({ camera }) => {
    if (!camera) return;
    const { rate, age, dropped } = camera;
    const hangs = age > Math.max(LONGEST_GAP, 3 * (context.setup?.dt ?? 0));
    const parts = [
      rate != null && text("camera.rate", { rate: rate.toFixed(1) }),
      age != null && (hangs
        ? text("camera.age.s", { age: age.toFixed(0) })
        : text("camera.age.ms", { age: (1000 * age).toFixed(0) })),
      text("camera.dropped", { dropped }),
    ];
    output.textContent = parts.filter(Boolean).join(", ");
    output.classList.toggle("robsim-hangs", hangs);
  });
  return { name: "camera", element };
}
