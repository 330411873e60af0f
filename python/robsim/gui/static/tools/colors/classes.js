// The colour classes: which one is trained, a new one, how each region that it has fits it.
import { makeRadios, makeTextButton } from "../../base/buttons.js";
import { make, text } from "../../base/dom.js";
import { makeAct, makePart, makeRow, makeTextField } from "../pieces.js";

const WELL = 0.5; // of a region that is in the class

export function makeClasses({ context, history }) {
  const choose = (value) => value && context.send({ type: "choose", name: value });
  const list = makeRadios("robsim-classes", text("classes"), choose);
  const name = makeTextField("new_class", () => {},
    { maxLength: 40, placeholder: text("new_class"),
      onkeydown: ({ key }) => key == "Enter" && add() });
  const add = () => {
    choose(name.value.trim());
    name.value = "";
  };
  const remove = makeAct(context, "remove_class", "", () => ({ type: "remove" }));
  const drift = make("div.robsim-drift");
  context.on("state", ({ classes, chosen }) => {
    const current = classes.find((one) => one.name == chosen);
    const shown = current ? classes : [...classes, { name: chosen, css: "transparent" }];
    list.show(shown.map(optionOf), chosen);
    remove.disabled = !current;
    drift.replaceChildren(...driftRows(current?.drift ?? []));
  });
  const row = makeRow(name, makeTextButton("add_class", "", add), remove, ...history);
  return makePart(list.element, row, drift);
}

/** A class; an untrained class has no colour. */
const optionOf = ({ name, css }) => ({ value: name, textContent: name, className: "robsim-class",
  style: `--robsim-class: ${css}`, title: text("choose_class.title", { name }) });

/** The colour of each region of a class with several regions: this reveals changing light. */
function driftRows(drift) {
  if (drift.length < 2) return [];
  return drift.map(({ picture, medians, share }) => {
    const words = text("drift", {
      picture, y: medians[0], u: medians[1], v: medians[2], share: Math.round(100 * share),
    });
    return make(share < WELL ? "div.robsim-warning-text" : "div.robsim-quiet", words);
  });
}
