// @ts-check
// Which picture is shown: live or frozen, or one of a recording.
import { makeTextButton } from "../base/buttons.js";
import { make, say } from "../base/dom.js";
import { makeSlider, showSlider } from "../base/slider.js";
import { text } from "../base/texts.js";

export function makeFilm(context) {
  const freeze = makeTextButton("freeze", "", () =>
    context.send({ type: "freeze", on: !context.state.frozen }));
  const slider = makeSlider("picture", { min: 0, max: 1, step: 1 });
  slider.setAttribute("aria-label", text("film"));
  slider.oninput = () => context.send({ type: "look", k: Number(slider.value) });
  const name = make("output", { className: "robsim-number robsim-quiet" });
  const ended = make("span", { className: "robsim-chip robsim-warning", hidden: true });
  const parts = [freeze, slider, name, ended];
  const element = make("div", { className: "robsim-tool-row robsim-row robsim-film" }, ...parts);
  const show = () => {
    const { setup, state } = context;
    if (!setup) return;
    freeze.hidden = !setup.is_live;
    freeze.setAttribute("aria-pressed", String(Boolean(state.frozen)));
    slider.hidden = !(setup.count > 1);
    slider.max = String(Math.max((setup.count ?? 1) - 1, 1));
    if (state.k != null && document.activeElement != slider)
      showSlider(slider, state.k, state.name);
    element.hidden = freeze.hidden && slider.hidden;
  };
  context.on("state", ({ over }) => {
    ended.hidden = !over;
    say(ended, over);
  });
  context.on("setup state", show);
  context.on("frame", (head) => (name.textContent = head.name));
  return element;
}
