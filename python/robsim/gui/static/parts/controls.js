// @ts-check
// The settings, as cards. What they are comes from Python, and so do their values.
import { make } from "../base/dom.js";
import { makeField } from "../base/fields.js";
import { text } from "../base/texts.js";
import { makeCameraRate } from "./camera_rate.js";
import { SPEED } from "./speed.js";

/**
 * The cards and the controls on them, in their order; what stands in none of them comes on the
 * last.
 */
const CARDS = {
  stages: ["tracking", "parameters", "state"],
  drive: ["control", "speed", "camera"],
  world: ["noise", "noise_level", "disturbance", "disturbance_level", "dropout"],
  more: [],
};

const KINDS = { noise_level: "noise", disturbance_level: "disturbance" }; // of the levels

export function makeControls(context) {
  const element = make("div", { className: "robsim-controls robsim-column" });
  const rate = makeCameraRate(context);
  const fields = new Map();

  const send = (name) => (value) => context.send({ type: "set", name, value });
  const refuse = (reason) => context.emit("note", { level: "info", text: reason });
  const makeOne = (control) =>
    makeField(control.name == "speed" ? SPEED : control, send(control.name), refuse);

  /** Take a control; one that is as before stays what it is, for it may be in use. */
  const take = (control) => {
    const { value, ...rest } = control;
    const kind = JSON.stringify(rest);
    const old = fields.get(control.name);
    if (old?.kind == kind) return old.show(value);
    const field = { ...makeOne(control), kind };
    field.show(value);
    old?.end();
    old?.element.replaceWith(field.element);
    fields.set(control.name, field);
  };

  /** A level is for what is there. */
  const allowLevels = (values) => {
    for (const [level, kind] of Object.entries(KINDS))
      if (kind in values)
        fields.get(level)?.allow(values[kind] == "none" ? text(`control.${level}.off`) : "");
  };

  context.on("setup", ({ controls, live }) => {
    const before = fields.size;
    controls.forEach(take);
    allowLevels(Object.fromEntries(controls.map(({ name, value }) => [name, value])));
    // the others are changed in their places
    if (fields.size == before && element.children.length) return;
    const all = [...fields.values(), ...(live ? [rate] : [])];
    const onCard = (card) => all.filter(({ name }) => cardOf(name) == card);
    element.replaceChildren(...Object.keys(CARDS).map((card) => makeCard(card, onCard(card))));
  });
  context.on("state", ({ values }) => {
    for (const [name, field] of fields) if (name in values) field.show(values[name]);
    allowLevels(values);
  });
  context.onEnd(() => fields.forEach((field) => field.end()));
  return { element };
}

const cardOf = (name) => Object.keys(CARDS).find((card) => CARDS[card].includes(name)) ?? "more";

function makeCard(card, fields) {
  const place = ({ name }) => CARDS[card].indexOf(name);
  const elements = fields.toSorted((a, b) => place(a) - place(b)).map((field) => field.element);
  const className = `robsim-surface robsim-card robsim-card-${card}`;
  const about = { className, ariaLabel: text(`card.${card}`), hidden: !elements.length };
  return make("section", about, ...elements);
}
