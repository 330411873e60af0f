// All options of the simulated world: search, changes, files. Python describes each.
import { makeButton, makeTextButton } from "../base/buttons.js";
import { make, pickFile, say, sayOrHide, text } from "../base/dom.js";
import { makeField } from "../base/fields.js";

const MOST_BYTES = 700_000; // of a file, which goes in one message
const DIGITS = 7;
const DEGREES = 180 / Math.PI;

export function makeScenario(context) {
  const rows = new Map(); // name -> row
  const groups = new Map(); // name -> details
  const head = makeHead(context, () => filter());
  const empty = make("p.robsim-empty", text("options.none"));
  const list = make("div.robsim-options.robsim-column", empty);
  const element = make("div.robsim-scenario", head.element, makeWaiting(context), list);

  const filter = () => {
    for (const row of rows.values()) row.element.hidden = !head.accepts(row.option());
    for (const group of groups.values()) {
      group.hidden = !group.querySelector(".robsim-option:not([hidden])");
      group.open ||= head.isNarrow();
    }
    empty.hidden = [...groups.values()].some((group) => !group.hidden);
  };
  const add = ({ name, group }) => {
    if (!groups.has(group)) {
      const summary = make("summary", text(`group.${group}`));
      groups.set(group, make("details.robsim-surface", { open: true }, summary));
      list.append(groups.get(group));
    }
    rows.set(name, makeRow(context, name));
    groups.get(group).append(rows.get(name).element);
  };
  context.on("options", ({ options }) => {
    for (const option of options) {
      if (!rows.has(option.name)) add(option);
      rows.get(option.name).show(option);
    }
    filter();
  });
  context.on("note", ({ option, text: why }) => rows.get(option)?.refuse(why));
  context.on("scenario_file", ({ text: content }) => {
    const href = URL.createObjectURL(new Blob([content], { type: "application/toml" }));
    make("a", { href, download: "scenario.toml" }).click();
    setTimeout(() => URL.revokeObjectURL(href), 1000);
  });
  return { element };
}

const wordsOf = (name) => name.replaceAll("_", " ").replace(/^./, (first) => first.toUpperCase());

/** The search, and the file. */
function makeHead(context, filter) {
  const label = text("options.search");
  const search = make("input.robsim-text-field", { type: "search", placeholder: label,
    name: "search_options", ariaLabel: label, oninput: filter });
  const only = makeTextButton("changed_options", "", () => {
    only.ariaPressed = String(only.ariaPressed != "true");
    filter();
  });
  only.ariaPressed = "false";
  const load = makeTextButton("load_scenario", "", () => pick(context, ".toml", async (file) =>
    context.send({ type: "load_scenario", text: await file.text() })));
  const save = makeTextButton("save_scenario", "", () => context.send({ type: "save_scenario" }));
  const isOnly = () => only.ariaPressed == "true";
  const accepts = ({ name, doc, changed }) => {
    const said = `${wordsOf(name)} ${name} ${doc}`.toLowerCase();
    return (changed || !isOnly()) && search.value.toLowerCase().split(/\s+/)
      .every((word) => said.includes(word));
  };
  context.on("options", ({ options }) =>
    say(only, text("changed_options.count", { n: options.filter((one) => one.changed).length })));
  const element = make("div.robsim-options-head.robsim-row", search, only, load, save);
  return { element, accepts, isNarrow: () => isOnly() || search.value.trim() != "" };
}

/** The changes that wait for a new run, which begins with a click on the words of the loss. */
function makeWaiting(context) {
  const begin = () => context.send({ type: "press", button: "reset" });
  const words = make("span");
  const element = make("div.robsim-waiting.robsim-row", { role: "status", hidden: true }, words,
    makeTextButton("new_run", "robsim-primary", begin),
    makeTextButton("keep_options", "", () => context.send({ type: "keep_options" })));
  let n = 0;
  const show = () => {
    const last = context.state.steps - 1;
    element.hidden = !n;
    say(words, text("options.wait", { n }) + (last < 0 ? "" : text("options.lost", { last })));
  };
  context.on("state", show);
  context.on("options", ({ options }) => {
    n = options.filter(({ waits }) => waits).length;
    show();
  });
  return element;
}

function makeRow(context, name) {
  const words = wordsOf(name);
  const id = `robsim-${context.id}-${name}-error`;
  const error = make("p.robsim-option-error", { role: "alert", hidden: true, id });
  const element = make("div.robsim-option", { role: "group", ariaLabel: words });
  let [shown, option] = ["", {}];
  const controls = () => [...element.querySelectorAll("input, select, button")];
  const refuse = (why) => {
    sayOrHide(error, why);
    for (const control of controls()) {
      control.ariaInvalid = String(Boolean(why));
      control.setAttribute("aria-describedby", id);
    }
  };
  const send = (value) => {
    refuse("");
    context.send({ type: "set_option", name, value });
  };
  const show = (told) => {
    if (shown == JSON.stringify(told)) return;
    [shown, option] = [JSON.stringify(told), told];
    const at = controls().indexOf(document.activeElement);
    element.classList.toggle("robsim-changed", told.changed);
    element.replaceChildren(...makeEditor(context, told, words, send),
      makeMarks(told, words, send), makeDoc(told), error);
    refuse("");
    if (at < 0) return;
    controls()[at]?.focus();
    if (!element.contains(document.activeElement)) controls()[0].focus();
  };
  element.onkeydown = ({ key }) => {
    if (key != "Escape" || error.hidden) return;
    shown = "";
    show(option);
  };
  return { element, show, refuse, option: () => option };
}

/** When a change takes effect, and the way back. */
function makeMarks({ live, waits, changed, default: value }, words, send) {
  const [kind, word] = waits ? [".robsim-warning", "option.waits"] : ["", "option.next"];
  const chip = make(`span.robsim-chip${kind}`, { hidden: live, title: text("option.next.title") },
    text(word));
  const reset = makeButton("reset_option", "robsim-plain robsim-icon", () => send(value));
  reset.ariaLabel = `${text("reset_option")}: ${words}`;
  reset.style.visibility = changed ? "" : "hidden";
  return make("span.robsim-option-state.robsim-row", chip, reset);
}

function makeDoc({ doc, limits, unit }) {
  const parts = doc.split(/`+/).map((part, i) => (i % 2 ? make("code.robsim-code", part) : part));
  return make("p.robsim-option-doc", ...parts, limits && ` ${limits} ${unit}`);
}

/** Return the name, the form of the value, if there are several, and the value. */
function makeEditor(context, { name, forms, form, fixed, doc, units }, words, send) {
  const dataOf = (wanted) => forms.find((one) => one.name == wanted)?.data;
  const choices = forms.map((one) => ({ value: one.name, disabled: null }));
  if (fixed) choices.push({ value: form, disabled: text("option.fixed") });
  const parts = [make("span.robsim-option-name", words)];
  if (choices.length > 1) {
    const control = { name, kind: "choice", choices, label: words, tip: doc };
    const field = makeField(control, (value) => send(dataOf(value)));
    field.show(form);
    parts[0] = field.element;
  }
  const data = dataOf(form);
  const values = [];
  if (data != null && data !== form) values.push(makeValue(data, units, "", words, send));
  if (name == "background") values.push(makePicture(context, send));
  return [...parts, ...values.map((value) => make("div.robsim-option-value", value))];
}

function makePicture(context, send) {
  const reader = new FileReader();
  reader.onload = () => send({ pixels: reader.result.split(",")[1] });
  return makeTextButton("choose_background", "", () =>
    pick(context, "image/*", (file) => reader.readAsDataURL(file)));
}

/** Make fields for data of any shape; `put` gets all of it with a change. */
function makeValue(data, units, key, label, put) {
  const unit = units[key] ?? "";
  if (typeof data == "boolean") {
    const onchange = ({ target }) => put(target.checked);
    const about = { type: "checkbox", role: "switch", checked: data, ariaLabel: label, onchange };
    return make("input.robsim-switch", about);
  }
  if (typeof data != "object") return makeNumber(data, unit, label, put);
  if (!Array.isArray(data))
    return make("div.robsim-option-keys", ...Object.keys(data).flatMap((name) => {
      if (name == "kind") return [];
      const change = (value) => put({ ...data, [name]: value });
      const field = makeValue(data[name], units, key || name, `${label}, ${name}`, change);
      return [make("span.robsim-quiet", name.replaceAll("_", " ")), field];
    }));
  const isTable = Array.isArray(data[0]);
  const own = unit.split(", ").length == 3 && !isTable ? unit.split(", ") : []; // of a pose
  const fields = data.map((one, i) =>
    makeValue(one, { "": own[i] }, "", `${label} ${i + 1}`, (value) => put(data.with(i, value))));
  const below = make("span.robsim-quiet", isTable ? unit : unit.split(", ").at(-1));
  return make(`span.robsim-option-${isTable ? "table" : "items"}`, ...fields,
    ...(own.length ? [] : [below]));
}

/** Make a field for a number or a text; Python judges it. */
function makeNumber(value, unit, label, put) {
  const factor = unit == "rad" ? DEGREES : 1;
  const isText = typeof value == "string";
  const shown = isText ? value : String(Number((factor * value).toPrecision(DIGITS)));
  const onchange = ({ target }) => {
    const typed = target.value.trim();
    const number = Number(typed.replace(",", ".").replace("\u2212", "-"));
    put(isText || !typed || !Number.isFinite(number) ? typed : number / factor);
  };
  const field = make("input.robsim-text-field", { value: shown, ariaLabel: label, onchange,
    inputMode: "decimal", autocomplete: "off", size: Math.max(5, shown.length) });
  const word = make("span.robsim-quiet", { hidden: !unit }, factor == 1 ? unit : "°");
  return make("span.robsim-row", field, word);
}

/** Let a file be chosen that is small enough. */
function pick(context, accept, take) {
  pickFile(accept, (file) => {
    if (file.size <= MOST_BYTES) take(file);
    else context.emit("note", { level: "error", text: text("file_too_large", file) });
  });
}
