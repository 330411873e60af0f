// @ts-check
// The tabs of the right side: one of their sheets is shown.
import { markChosen, moveByArrows } from "../base/buttons.js";
import { make } from "../base/dom.js";
import { text } from "../base/texts.js";

/** `sheets`: {name of the tab: its part}. */
export function makeTabs(context, sheets) {
  const names = Object.keys(sheets);
  const choose = (name) => context.choose("tab", name);
  const idOf = (name, what) => `robsim-${context.id}-${name}-${what}`;
  const tabs = names.map((name) => {
    const button = make("button",
      { type: "button", role: "tab", value: name, textContent: text(name) });
    button.id = idOf(name, "tab");
    button.setAttribute("aria-controls", idOf(name, "sheet"));
    button.addEventListener("click", () => choose(name));
    const sheet = sheets[name].element;
    Object.assign(sheet, { id: idOf(name, "sheet"), tabIndex: 0 });
    sheet.setAttribute("role", "tabpanel");
    sheet.setAttribute("aria-labelledby", button.id);
    return button;
  });
  const about = { className: "robsim-tabs robsim-cut", role: "tablist", ariaLabel: text("tabs") };
  const list = make("div", about, ...tabs);
  const elements = names.map((name) => sheets[name].element);
  moveByArrows(list, (button) => choose(button.value));

  const show = () => {
    const chosen = names.includes(context.local.tab) ? context.local.tab : names[0];
    markChosen(list, "aria-selected", (button) => button.value == chosen);
    names.forEach((name, i) => (elements[i].hidden = name != chosen));
  };
  context.on("local", (name) => name == "tab" && show());
  const callbacks = tabs[names.indexOf("callbacks")];
  context.on("state", ({ error }) => (callbacks.dataset.mark = error ? "bad" : ""));
  context.on("result", ({ again }) => again || choose("result")); // not one from before
  show();
  return { list, sheets: make("div", { className: "robsim-sheets" }, ...elements) };
}
