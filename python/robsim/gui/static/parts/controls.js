// The settings, as cards. Python sends the controls and their values.
import { make, text } from "../base/dom.js";
import { makeField } from "../base/fields.js";

const KINDS = { noise_level: "noise", disturbance_level: "disturbance" }; // of the levels
const FASTEST = 0; // means "as fast as possible"
const SPEEDS = [0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, FASTEST];
const LONGEST_GAP = 1; // s, or three frames, after which a camera is taken to hang

const CARDS = ["stages", "drive", "world"];

export function makeControls(context) {
  const element = make("div.robsim-controls.robsim-column");
  const rate = makeCameraRate(context);
  const fields = new Map();

  const send = (name) => (value) => context.send({ type: "set", name, value });
  const refuse = (reason) => context.emit("note", { level: "info", text: reason });
  const makeOne = (control) =>
    makeField(control.name == "speed" ? SPEED : control, send(control.name), refuse);

  /** Take a control; keep the element of an unchanged control, which may be in use. */
  const take = (control) => {
    const { value, ...rest } = control;
    const kind = JSON.stringify(rest);
    const old = fields.get(control.name);
    if (old?.kind == kind) return old.show(value);
    const field = { ...makeOne(control), kind, card: control.card };
    field.show(value);
    old?.element.replaceWith(field.element);
    fields.set(control.name, field);
  };

  /** Enable a level only while its disturbance is on. */
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
    element.replaceChildren(...CARDS.map((card) => makeCard(card, all)));
  });
  context.on("state", ({ values }) => {
    for (const [name, field] of fields) if (name in values) field.show(values[name]);
    allowLevels(values);
  });
  return { element };
}

function makeCard(card, all) {
  const elements = all.filter((field) => field.card == card).map(({ element }) => element);
  const about = { ariaLabel: text(`card.${card}`), hidden: !elements.length };
  return make(`section.robsim-surface.robsim-card.robsim-card-${card}`, about, ...elements);
}

/** The control, see `makeField`: its slider has the places of the speeds. */
const SPEED = {
  name: "speed", kind: "range", low: 0, high: SPEEDS.length - 1, step: 1,
  valueAt: (place) => SPEEDS[place],
  placeOf: nearest,
  wordsOf: (speed) => (speed == FASTEST ? text("speed.fastest") : text("speed.times", { speed })),
};

function nearest(speed) {
  if (speed == FASTEST) return SPEEDS.length - 1;
  const distance = (other) => Math.abs(Math.log(other / speed));
  const slow = SPEEDS.slice(0, -1);
  return slow.reduce((best, other, i) => (distance(other) < distance(slow[best]) ? i : best), 0);
}

/** The rate of a live camera instead of the speed, which the camera sets. */
function makeCameraRate(context) {
  const part = (name) => make(`span.robsim-${name}`);
  const parts = ["rate", "dropped", "age"].map(part); // the last one comes and goes
  const [rateOf, droppedOf, ageOf] = parts;
  const output = make("span.robsim-number.robsim-camera-rate", ...parts);
  const label = make("span", text("camera"));
  const element = make("div.robsim-field.robsim-row.robsim-camera-field",
    { title: text("camera.title") }, label, output);
  context.on("state", ({ camera }) => {
    if (!camera) return;
    const { rate, age, dropped } = camera;
    const hangs = age > Math.max(LONGEST_GAP, 3 * (context.setup?.dt ?? 0));
    rateOf.textContent = text("camera.rate", { rate: rate?.toFixed(1) ?? "\u2013" });
    droppedOf.textContent = text("camera.dropped", { dropped });
    ageOf.textContent = age == null ? "" : hangs
      ? text("camera.age.s", { age: age.toFixed(0) })
      : text("camera.age.ms", { age: (1000 * age).toFixed(0) });
    output.classList.toggle("robsim-hangs", hangs);
  });
  return { card: "drive", element };
}
