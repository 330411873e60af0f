// Start, Pause, Step and their like; Stop for what moves outside of the computer.
import { makeButton, showButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";

const isOver = ({ state }) => ["ended", "closed"].includes(state);
// While it runs, `steps` are those with which it started: Python pauses before these.
const hasRun = ({ state, steps }) => state != "closed" && (steps > 0 || state == "running");
const NEEDS = {
  step: (state) => !isOver(state),
  step_stage: (state) => !isOver(state),
  reset: (state) => hasRun(state) || state.state == "failed",
  finish: hasRun,
};

const MOVES_ON = ["start", "step", "step_stage", "reset"];

export function makeTransport(context) {
  const press = (button) => {
    if (MOVES_ON.includes(button) && context.looking != null) context.look(null);
    context.send({ type: "press", button });
  };
  const start = makeButton("start", "robsim-primary robsim-start", () => press(start.name));
  const others = Object.keys(NEEDS).map((name) => makeButton(name, "", () => press(name)));
  const animate = makeButton("slowly", "", () => {
    if (!context.state.animate) context.choose("tab", "callbacks"); // where it is seen
    context.send({ type: "animate", on: !context.state.animate });
  });
  const stop = makeButton("stop", "robsim-danger robsim-stop", () => press("stop"));
  stop.hidden = true;
  const about = { role: "toolbar", ariaLabel: text("transport") };
  const element = make("div.robsim-transport", about, start, ...others.slice(0, 2), animate, ...others.slice(2), stop);

  const show = () => {
    const { state } = context;
    showButton(start, state.state == "running" ? "pause" : "start");
    // A trace is played back again.
    start.disabled = isOver(state) && !(context.setup?.source == "trace" && state.state == "ended");
    for (const button of others) button.disabled = !NEEDS[button.name](state);
    animate.setAttribute("aria-pressed", String(Boolean(state.animate)));
    animate.hidden = context.setup?.source == "trace" || context.setup?.live;
    stop.hidden = !context.setup?.motors;
    element.dataset.motors = String(!stop.hidden);
  };
  context.on("setup state", show);
  show();
  return { element, press, toggle: () => start.disabled || press(start.name) };
}
