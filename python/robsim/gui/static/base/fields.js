// @ts-check
// Controls as Python describes them: a choice, a range, a switch.
import { makeRadios } from "./buttons.js";
import { make } from "./dom.js";
import { heldValue } from "./held_value.js";
import { makeSlider, showSlider } from "./slider.js";
import { text } from "./texts.js";

const MOST_SEGMENTS = 3; // more of them become a list that opens

/**
 * Make the field of a control: `show` a value that Python tells, `allow` it to be set unless a
 * reason is given; `refuse` is called with why not.
 */
export function makeField(control, send, refuse = () => {}) {
  const { name, kind, choices, tip } = control;
  const isShort = kind == "choice" && choices.length <= MOST_SEGMENTS;
  const made = MAKERS[isShort ? "segments" : kind](control, refuse);
  const label = text(`control.${name}`, {}, name);
  const parts = [make("span", { textContent: label }), made.element, made.output];
  const about = { className: "robsim-field", title: text(`control.${name}.title`, {}, tip ?? "") };
  // A label passes a click on to its control, which is right for one control, not for a group.
  const element = make(isShort ? "div" : "label", about, ...parts.filter(Boolean));
  made.element.setAttribute("aria-label", text(`control.${name}.whole`, {}, label));
  const value = heldValue(made.element, made.show, send);
  made.listen(value.set);
  const allow = (reason) => {
    made.element.disabled = Boolean(reason);
    element.classList.toggle("robsim-off", Boolean(reason));
    element.title = reason || about.title;
  };
  return { name, element, show: value.tell, allow, end: value.end };
}

const MAKERS = { segments: makeSegments, choice: makeSelect, range: makeRange, switch: makeSwitch };

const choiceText = (name, value) =>
  text(`control.${name}.${value}`, {}, text(`choice.${value}`, {}, value));

function makeSegments({ name, choices }, refuse) {
  let told = () => {};
  const choose = (wanted) => {
    const { value, disabled } = choices.find((choice) => String(choice.value) == wanted);
    if (disabled) refuse(disabled);
    else told(value);
  };
  const { element, show } = makeRadios("robsim-segments", "", choose);
  const options = choices.map(({ value, disabled }) => ({
    value, textContent: choiceText(name, value), ariaDisabled: String(disabled != null),
    title: disabled ?? text(`control.${name}.${value}.title`, {}, ""),
    ...(disabled && { ariaDescription: disabled }),
  }));
  const listen = (set) => (told = set);
  return { element, listen, show: (value) => show(options, value) };
}

function makeSelect({ name, choices }) {
  const options = choices.map(({ value, disabled }) => {
    const textContent = choiceText(name, value) + (disabled ? ` (${disabled})` : "");
    return make("option",
      { value, disabled: disabled != null, title: disabled ?? "", textContent });
  });
  const element = make("select", { className: "robsim-select", name }, ...options);
  const listen = (set) => element.addEventListener("change", () => set(element.value));
  return { element, listen, show: (value) => (element.value = value) };
}

/** A slider; its places may be other numbers than the values: `valueAt`, `placeOf`. */
function makeRange({ name, low, high, step, unit, valueAt = Number, placeOf = Number, wordsOf }) {
  const element = makeSlider(name, { min: low, max: high, step });
  const output = make("output");
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const listen = (set) => element.addEventListener("input", () => set(valueAt(element.value)));
  const show = (value) => {
    output.textContent = wordsOf?.(value)
      ?? [value.toFixed(digits), unit].filter(Boolean).join("\u202f");
    showSlider(element, placeOf(value), output.textContent);
  };
  return { element, output, listen, show };
}

function makeSwitch({ name }) {
  const element = make("input",
    { type: "checkbox", role: "switch", className: "robsim-switch", name });
  const listen = (set) => element.addEventListener("change", () => set(element.checked));
  return { element, listen, show: (value) => (element.checked = value) };
}
