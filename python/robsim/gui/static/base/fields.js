// Controls as Python describes them: a choice, a range, a switch.
import { makeRadios } from "./buttons.js";
import { make, painter, text } from "./dom.js";

const MOST_SEGMENTS = 3; // more of them become a list that opens
const MAKERS = { segments: makeSegments, choice: makeSelect, range: makeRange, switch: makeSwitch };
export const ANSWER_TIME = 1000; // ms in which Python's answer to a value is to come

/**
 * Make the field of a control: `show` a value that Python tells, `allow` it to be set unless a
 * reason is given; `refuse` is called with why not.
 */
export function makeField(control, send, refuse = () => {}) {
  const { name, kind, choices, tip, label = "" } = control;
  const isShort = kind == "choice" && choices.length <= MOST_SEGMENTS;
  const made = MAKERS[isShort ? "segments" : kind](control, (value) => held.set(value), refuse);
  const words = label || text(`control.${name}`, {}, name);
  const parts = [make("span", { textContent: words }), made.element, made.output];
  const title = text(`control.${name}.title`, {}, tip ?? "");
  // A label passes a click on to its control, which is right for one control, not for a group.
  const element = make(`${isShort ? "div" : "label"}.robsim-field.robsim-row`, { title },
    ...parts.filter(Boolean));
  made.element.setAttribute("aria-label", text(`control.${name}.whole`, {}, words));
  const held = heldValue(made.show, send);
  if (kind == "range") made.element.addEventListener("pointerdown", held.hold);
  const allow = (reason) => {
    made.element.disabled = Boolean(reason);
    element.classList.toggle("robsim-off", Boolean(reason));
    element.title = reason || title;
  };
  return { name, element, show: held.tell, allow };
}

const choiceText = (name, value) =>
  text(`control.${name}.${value}`, {}, text(`choice.${value}`, {}, value));

function makeSegments({ name, choices }, set, refuse) {
  const choose = (wanted) => {
    const { value, disabled } = choices.find((choice) => String(choice.value) == wanted);
    if (disabled) refuse(disabled);
    else set(value);
  };
  const { element, show } = makeRadios("robsim-segments", "", choose);
  const options = choices.map(({ value, disabled }) => ({
    value, textContent: choiceText(name, value), ariaDisabled: String(disabled != null),
    title: disabled ?? text(`control.${name}.${value}.title`, {}, ""),
    ...(disabled && { ariaDescription: disabled }),
  }));
  return { element, show: (value) => show(options, value) };
}

function makeSelect({ name, choices }, set) {
  const options = choices.map(({ value, disabled }) => {
    const textContent = choiceText(name, value) + (disabled ? ` (${disabled})` : "");
    const about = { value, disabled: disabled != null, title: disabled ?? "" };
    return make("option", about, textContent);
  });
  const onchange = ({ target }) => set(target.value);
  const element = make("select.robsim-select", { name, onchange }, ...options);
  return { element, show: (value) => (element.value = value) };
}

/** A slider; its places may be other numbers than the values: `valueAt`, `placeOf`. */
function makeRange(control, set) {
  const { name, low, high, step, unit, valueAt = Number, placeOf = Number, wordsOf } = control;
  const element = makeSlider(name, { min: low, max: high, step });
  const output = make("output");
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  element.oninput = () => set(valueAt(element.value));
  const show = (value) => {
    output.textContent = wordsOf?.(value)
      ?? [value.toFixed(digits), unit].filter(Boolean).join("\u202f");
    showSlider(element, placeOf(value), output.textContent);
  };
  return { element, output, show };
}

function makeSwitch({ name }, set) {
  const onchange = ({ target }) => set(target.checked);
  const element = make("input.robsim-switch", { type: "checkbox", role: "switch", name, onchange });
  return { element, show: (value) => (element.checked = value) };
}

/** A slider from `min` to `max`. */
export function makeSlider(name, { min, max, step }) {
  const slider = make("input.robsim-slider", { type: "range", name });
  return Object.assign(slider, { min: String(min), max: String(max), step: String(step) });
}

/** Show a value, which `words` say for screen readers. */
export function showSlider(slider, value, words) {
  slider.value = String(value);
  slider.setAttribute("aria-valuetext", words);
}

/**
 * Keep a value: show the last value set here, not an older one in transit from Python (`tell`).
 * It is sent at most once per animation frame, by `send(value, goesOn)`. `goesOn` means the same
 * drag as before. A drag lasts from `hold` to the end of the press. Values may be
 * arrays.
 */
export function heldValue(show, send) {
  let [mine, told, isHeld, waitsUntil] = [undefined, undefined, false, 0];
  let timer = 0;
  let goesOn = false;
  const sendMine = painter(() => {
    send(mine, goesOn);
    goesOn = isHeld;
  });
  const isAnswered = () => JSON.stringify(told) == JSON.stringify(mine);
  const settle = () => {
    clearTimeout(timer);
    if (isHeld) return;
    const rest = waitsUntil - performance.now();
    if (rest > 0 && !isAnswered()) timer = setTimeout(settle, rest);
    else if (told !== undefined) show((mine = told));
  };
  const hold = () => {
    [isHeld, goesOn] = [true, false];
    addEventListener("pointerup", release, { once: true });
    addEventListener("pointercancel", release, { once: true });
  };
  const release = () => {
    if (!isHeld) return;
    isHeld = false;
    setTimeout(settle); // after the last change, which comes behind it
    requestAnimationFrame(() => (goesOn = false)); // after that is sent
  };
  return {
    hold,
    set(value) {
      mine = value;
      waitsUntil = performance.now() + ANSWER_TIME;
      show(value);
      sendMine();
      settle();
    },
    tell(value) {
      told = value;
      if (isAnswered()) waitsUntil = 0;
      settle();
    },
  };
}
