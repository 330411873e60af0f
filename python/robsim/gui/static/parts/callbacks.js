// The callbacks in the order of the calls: owners, run times and errors;
// Animate.
import { makeTextButton } from "../base/buttons.js";
import { make, sayOrHide, text } from "../base/dom.js";
import { makeSource } from "./source.js";

const GROUPS = ["once", "step"];
const SLOT_OF_STAGE = { world: "evaluate_model" }; // other stages have the names of their slots

export function makeCallbacks(context) {
  const animate = makeAnimate(context);
  const groups = GROUPS.map(makeGroup);
  const source = makeSource(context);
  const sections = groups.map((group) => group.element);
  const element = make("div.robsim-callbacks");
  element.append(animate.element, ...sections, makePrinted(context), source.element);
  let rows = new Map(); // slot -> row
  let stage = null;

  const mark = () => {
    const running = SLOT_OF_STAGE[stage] ?? stage;
    for (const [slot, row] of rows) row.setRunning(slot == running);
    animate.show(rows.has(running) ? null : stage);
  };
  const fill = ({ slots }) => {
    if (slots.map(({ slot }) => slot).join() != [...rows.keys()].join()) {
      rows = new Map(slots.map(({ slot }) => [slot, makeSlotRow(context, source, slot)]));
      for (const { when, fill: put } of groups) {
        put(slots.filter((slot) => slot.when == when).map(({ slot }) => rows.get(slot).element));
      }
    }
    const slowest = Math.max(...slots.map(({ ms }) => ms ?? 0));
    for (const slot of slots) rows.get(slot.slot).show(slot, slowest);
    mark();
  };
  context.on("callbacks", fill);
  context.on("stages", (told) => {
    stage = told.stage;
    mark();
  });
  context.on("state", ({ state, animate: isOn }) => {
    if (!isOn && state == "running") stage = null;
    mark();
  });
  return { element };
}

/** The switch, and the stage that runs if none of the rows is its own. */
function makeAnimate(context) {
  const input = make("input.robsim-switch", { type: "checkbox", role: "switch", name: "animate" });
  input.onchange = () => context.send({ type: "animate", on: input.checked });
  const words = make("span", make("b", text("animate")), ` ${text("animate.title")}`);
  const chip = make("span.robsim-chip.robsim-active", { hidden: true });
  const label = make("label", input, words);
  const element = make("div.robsim-animate.robsim-row", label, chip);
  context.on("state", ({ animate: isOn }) => (input.checked = isOn));
  return { element, show: (stage) => sayOrHide(chip, stage ? text(`slot.${stage}`) : "") };
}

/** The last lines that callbacks have printed; it stays at its end unless one scrolls up. */
function makePrinted(context) {
  const list = make("ol.robsim-surface.robsim-code.robsim-printed", { tabIndex: 0,
    ariaLabel: text("printed") });
  const element = make("section", { hidden: true }, make("h3", text("printed")), list);
  let follows = true;
  const toEnd = () => follows && (list.scrollTop = list.scrollHeight);
  list.onscroll = () => { // hidden, it has no height
    if (list.clientHeight) follows = list.scrollTop + list.clientHeight > list.scrollHeight - 4;
  };
  new ResizeObserver(toEnd).observe(list);
  context.on("printed", ({ lines }) => {
    element.hidden = !lines.length;
    list.replaceChildren(...lines.map(([slot, words]) =>
      make("li", make("span.robsim-quiet", text(`slot.${slot}`)), make("span", words))));
    toEnd();
  });
  return element;
}

function makeGroup(when) {
  const title = text(`when.${when}`);
  const list = make("ol.robsim-surface", { ariaLabel: title });
  const element = make("section", { hidden: true }, make("h3", { textContent: title }), list);
  const fill = (rows) => {
    list.replaceChildren(...rows);
    element.hidden = !rows.length;
  };
  return { when, element, fill };
}

function makeSlotRow(context, source, slot) {
  const title = text(`slot.${slot}`);
  const chip = make("span.robsim-chip");
  const what = makeSlotPlace();
  const time = makeSlotTime();
  const buttons = makeSlotButtons(context, source, slot, title);
  const error = makeSlotError();
  const name = make("span.robsim-slot-name", { textContent: title });
  const parts = [what, time, buttons, error];
  const element = make("li.robsim-slot", name, chip, ...parts.map((part) => part.element));
  const show = (facts, slowest) => {
    chip.textContent = text(`owner.${facts.owner}`);
    chip.dataset.owner = element.dataset.owner = facts.owner;
    for (const part of parts) part.show(facts, slowest);
  };
  const setRunning = (isRunning) => {
    element.classList.toggle("robsim-running", isRunning);
    element.ariaCurrent = isRunning ? "step" : null;
  };
  return { element, show, setRunning };
}

function makeSlotPlace() {
  const called = make("span.robsim-code.robsim-clipped");
  const place = make("span.robsim-code.robsim-clipped.robsim-quiet");
  const element = make("span.robsim-slot-what.robsim-column", called, place);
  const show = ({ name, file, line }) => {
    called.textContent = name ?? "";
    place.textContent = file ? file.split(/[\\/]/).at(-1) + (line ? `:${line}` : "") : "";
    place.title = file ?? "";
  };
  return { element, show };
}

/** The time of a call, and how much that is of the slowest one's. */
function makeSlotTime() {
  const words = make("span.robsim-number.robsim-quiet");
  const bar = make("div.robsim-slot-time", { role: "presentation" });
  const element = make("span.robsim-slot-took", words, bar);
  const show = ({ ms, calls }, slowest) => {
    element.hidden = ms == null;
    if (ms == null) return;
    words.textContent = text("slot.ms", { ms: ms.toFixed(ms < 10 ? 2 : 0) });
    element.title = text("slot.calls", { calls });
    bar.style.setProperty("--robsim-part", `${slowest > 0 ? (100 * ms) / slowest : 0}%`);
  };
  return { element, show };
}

function makeSlotButtons(context, source, slot, title) {
  const named = (button, name) => {
    button.ariaLabel = `${text(name)}: ${title}`;
    return button;
  };
  const button = (name, press) =>
    named(makeTextButton(`${name}_${slot}`, "robsim-plain", press, name), name);
  const edit = button("edit", () => context.send({ type: "edit", slot }));
  const read = button("source", () => source.ask(slot, read));
  const mine = button("make_mine", () => {
    source.askedBy(read);
    context.send({ type: "make_mine", slot });
  });
  const link = make("a.robsim-button.robsim-plain", { target: "_blank", rel: "noopener" });
  link.textContent = text("edit");
  const element = make("span.robsim-slot-buttons", mine, named(link, "edit"), edit, read);
  const show = ({ owner, link: address, can_edit: canEdit, can_make: canMake }) => {
    mine.hidden = !canMake;
    link.hidden = !address;
    link.href = address ?? "";
    edit.hidden = !canEdit || !link.hidden;
    read.hidden = owner == "off" && !canMake;
  };
  return { element, show };
}

/** The last error in one line, which opens. */
function makeSlotError() {
  const summary = make("summary.robsim-clipped");
  const whole = make("pre.robsim-code");
  const element = make("details.robsim-slot-error", { hidden: true }, summary, whole);
  const show = ({ error }) => {
    element.hidden = !error;
    if (!error) return;
    const { k, line, text: words } = error;
    const when = line ? "slot.failed_at" : "slot.failed";
    const where = text(k == null ? "slot.failed_once" : when, { k, line });
    summary.textContent = `${where} ${words.trim().split("\n").at(-1)}`;
    whole.textContent = words;
  };
  return { element, show };
}
