// The tools on the run: their buttons, and the place where one is shown instead of the panel.
import { makeButton, makeTextButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";
import { renderColors } from "../tools/colors.js";
import { renderRobots } from "../tools/robots.js";

const TOOLS_OF_RUN = {
  robots: { button: "define_robot", render: renderRobots },
  colors: { button: "train_colors", render: renderColors },
};

export function makeToolPlace(context) {
  const choose = (name) => context.send({ type: "tool", name });
  const opening = Object.entries(TOOLS_OF_RUN).map(([name, { button }]) =>
    [name, makeTextButton(button, "", () => choose(name))]);
  const buttons = make("div.robsim-open-tools", { hidden: true },
    ...opening.map(([, button]) => button));
  const [here, use] = ["use_here", "use_tool"].map((type) =>
    makeTextButton(type, "robsim-primary", () => context.send({ type })));
  const stop = makeButton("stop", "robsim-danger robsim-stop", () =>
    context.send({ type: "press", button: "stop" }));
  const bar = make("div.robsim-tool-bar.robsim-row",
    makeTextButton("discard_tool", "", () => choose(null)),
    use, here, stop);
  const element = make("div.robsim-tool-place.robsim-column", { hidden: true });
  let shown = null; // the tool: its name and its view

  const close = () => {
    if (!shown) return;
    shown.view.end();
    shown.send({ type: "bye" });
    shown = null;
  };
  const open = (name) => {
    const el = make("div.robsim");
    const send = (message, buffers) => context.send({ type: "tell_tool", name, message }, buffers);
    element.replaceChildren(bar, el);
    here.hidden = name != "robots";
    use.textContent = here.hidden ? here.textContent : text("use_as_default");
    use.title = here.hidden ? "" : text("use_tool.title");
    use.classList.toggle("robsim-primary", here.hidden);
    shown = { name, send, view: TOOLS_OF_RUN[name].render({ el, send }) };
    shown.view.begin();
  };
  context.on("setup", ({ tools, motors, source }) => {
    stop.hidden = !motors;
    here.textContent = text(source == "simulation" ? "use_tool" : "use_tool.experiment");
    for (const [name, button] of opening) button.hidden = !tools.includes(name);
    buttons.hidden = !tools.length;
  });
  context.on("state", ({ tool }) => {
    if ((shown?.name ?? null) == tool) return;
    close();
    context.el.dataset.tool = tool ?? "";
    element.hidden = !tool;
    if (tool) open(tool);
    else element.replaceChildren();
  });
  context.onEnd(close);
  return {
    element,
    buttons,
    arrived: (message) => shown?.view.arrived(message),
    receive: (message, buffers) => shown?.view.receive(message, buffers),
  };
}
