// @ts-check
// The colour classes: which one is trained, a new one, how each region that it has fits it.
import { makeTextButton } from "../../base/buttons.js";
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";

const WELL = 0.5; // of a region that is in the class

export function makeClasses(context) {
  const list = make("div",
    { className: "robsim-classes", role: "radiogroup", ariaLabel: text("classes") });
  const name = make("input", { className: "robsim-text-field", name: "new_class", maxLength: 40,
    placeholder: text("new_class"), ariaLabel: text("new_class") });
  const choose = (value) => value && context.send({ type: "choose", name: value });
  const add = () => {
    choose(name.value.trim());
    name.value = "";
  };
  name.onkeydown = (event) => {
    event.stopPropagation();
    if (event.key == "Enter") add();
  };
  const remove = makeTextButton("remove_class", "", () => context.send({ type: "remove" }));
  const bar = make("div", { className: "robsim-tool-row" }, name,
    makeTextButton("add_class", "", add), remove);
  const drift = make("div", { className: "robsim-drift" });

  const show = () => {
    const { classes, chosen } = context.state;
    const names = classes.map((one) => one.name);
    const shown = names.includes(chosen) ? classes : [...classes, { name: chosen, css: "" }];
    const hasFocus = list.matches(":focus-within");
    list.replaceChildren(...shown.map((one) => classButton(one, one.name == chosen, choose)));
    if (hasFocus) list.querySelector("[aria-checked=true]").focus();
    const current = classes.find((one) => one.name == chosen);
    remove.disabled = !current;
    drift.replaceChildren(...driftRows(current?.drift ?? []));
  };
  context.on("state", show);
  return { element: make("div", { className: "robsim-tool-part" }, list, bar, drift) };
}

/** A class; one that is not trained yet has no colour. */
function classButton({ name, css }, isChosen, choose) {
  const mark = make("span", { className: "robsim-class-mark" });
  mark.style.background = css;
  const button = make("button", { type: "button", className: "robsim-class", role: "radio",
    title: text("choose_class.title", { name }) }, mark, name);
  button.setAttribute("aria-checked", String(isChosen));
  button.onclick = () => choose(name);
  return button;
}

/** What each region looks like, where the class has several: light that changes shows. */
function driftRows(drift) {
  if (drift.length < 2) return [];
  return drift.map(({ picture, medians, share }) => {
    const words = text("drift", {
      picture, y: medians[0], u: medians[1], v: medians[2], share: Math.round(100 * share),
    });
    const className = share < WELL ? "robsim-warning-text" : "robsim-quiet";
    return make("div", { className, textContent: words });
  });
}
