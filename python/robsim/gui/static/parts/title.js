// The top line: what runs, its state, step and time; theme and colours of this view.
import { makeButton, makeLooks } from "../base/buttons.js";
import { isPage, make, painter, text } from "../base/dom.js";
import { icon } from "../base/icons.js";

const MOODS = { running: "good", failed: "bad", stopped: "bad", ended: "warning" };

export function makeTitle(context) {
  const name = make("span.robsim-title-name");
  const state = make("span.robsim-chip.robsim-title-state", { role: "status" });
  const step = make("output.robsim-number.robsim-title-step");
  const time = make("output.robsim-number.robsim-title-time");
  const keys = makeButton("keys", "robsim-plain robsim-icon", () => context.emit("keys"));
  const home = makeButton("home", "robsim-plain robsim-icon", () => context.send({ type: "home" }));
  home.hidden = true;
  const element = make("header.robsim-title",
    home, icon("robot"), name, state, step, time, makeLooks(context, keys));

  const count = painter(() => {
    const { shown } = context;
    step.textContent = text("step.number", { k: shown < 0 ? "–" : shown });
    time.textContent = text("time", { t: shown < 0 ? "–" : context.timeOf(shown).toFixed(1) });
  });
  context.on("setup", ({ title, has_home: hasHome }) => {
    home.hidden = !hasHome;
    name.textContent = name.title = title;
    if (isPage()) document.title = `${title} – robsim`;
  });
  context.on("state", ({ state: now, stopped }) => {
    const shown = stopped && now == "paused" ? "stopped" : now;
    if (state.dataset.state != shown) state.textContent = text(`state.${shown}`);
    state.dataset.state = shown;
    state.className = `robsim-chip robsim-title-state robsim-${MOODS[shown] ?? "quiet"}`;
  });
  context.on("shown", count);
  return { element };
}
