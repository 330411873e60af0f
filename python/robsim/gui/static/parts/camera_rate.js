// @ts-check
// What a live camera delivers: in the place of the speed, which it sets.
import { make } from "../base/dom.js";
import { text } from "../base/texts.js";

export function makeCameraRate(context) {
  const output = make("span", { className: "robsim-number" });
  const label = make("span", { textContent: text("camera") });
  const element = make("div", { className: "robsim-field", title: text("camera.title") }, label, output);
  context.on("state", ({ camera }) => {
    if (camera == null) output.textContent = text("camera.none");
    else {
      const { rate, age, dropped } = camera;
      output.textContent = text("camera.rate", {
        rate: rate?.toFixed(1) ?? "–", age: age == null ? "–" : Math.round(1000 * age), dropped,
      });
    }
  });
  return { name: "camera", element };
}
