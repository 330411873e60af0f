// The toolbar above the charts of a tab: the range of steps, and the colour legend.
import { makeTextButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";
import { makeSwatch } from "../base/icons.js";

const WINDOWS = [200, 600, 2000, 0]; // steps; 0 = all

/** Make the button that follows the newest step, and the choice of how many are shown. */
export function makeStepControls(context) {
  const { axis } = context;
  const follow = makeTextButton("follow", "", () => {
    if (axis.follows) axis.hold();
    else if (context.looking == null) axis.follow();
    else context.look(null);
  }, "chart.follow");
  const choices = WINDOWS.map((n) => {
    const textContent = n ? text("chart.last_steps", { n }) : text("chart.all_steps");
    return make("option", { value: String(n), textContent });
  });
  const select = make("select.robsim-select", {
    name: "window", ariaLabel: text("chart.window"),
    onchange: () => context.choose("window", Number(select.value)),
  }, ...choices);
  const renew = (isGrowth) => {
    if (isGrowth) return;
    follow.setAttribute("aria-pressed", String(axis.follows));
    select.value = String(axis.window);
  };
  context.on("axis", renew);
  renew();
  return [follow, select];
}

/**
 * Make buttons that explain the colours, and remove or restore a layer; `isThere`
 * returns whether a run has the layer of a name.
 */
export function makeLegend(context, layers, isThere) {
  const isShown = (name) => !context.local.unseen.includes(name);
  const toggle = (name) => {
    const others = context.local.unseen.filter((other) => other != name);
    context.choose("unseen", isShown(name) ? [...others, name] : others);
  };
  const buttons = layers.map(({ name, ink, kind }) =>
    make("button.robsim-button.robsim-plain", {
      type: "button", name: `show_${name}`,
      title: text(`chart.${name}.title`), onclick: () => toggle(name),
    }, makeSwatch(kind, `var(--robsim-${ink})`), text(`chart.${name}`)));
  const renew = () =>
    layers.forEach(({ name }, i) => buttons[i].setAttribute("aria-pressed", String(isShown(name))));
  context.on("local", (name) => name == "unseen" && renew());
  context.on("setup", () => layers.forEach(({ name }, i) => (buttons[i].hidden = !isThere(name))));
  renew();
  return make("div.robsim-legend", { role: "group", ariaLabel: text("chart.legend") }, ...buttons);
}
