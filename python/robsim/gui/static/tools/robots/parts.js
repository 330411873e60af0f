// @ts-check
// What is drawn of a robot: the outline, then both markers; what is wrong with it.
import { makeTextButton, markChosen, moveByArrows } from "../../base/buttons.js";
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";

/** What a part is called: a marker by its role, as soon as it has one, and its colour. */
function nameOfPart(part, { roles }) {
  if (part == "outline") return text("part.outline");
  return text(`part.${roles[part] ?? "marker"}`, { color: part });
}

export function makeRobotParts(context) {
  const choose = (name) => context.send({ type: "part", name });
  const buttonOf = (value) => make("button", {
    type: "button", role: "radio", value, onclick: () => choose(value) });
  const parts = make("div", { className: "robsim-segments", role: "radiogroup",
    ariaLabel: text("parts") });
  const show = (state) => {
    const names = Object.keys(state.parts);
    const shown = [...parts.children].map((button) => button.value);
    if (names.join("\n") != shown.join("\n")) parts.replaceChildren(...names.map(buttonOf));
    for (const button of parts.children) {
      button.textContent = nameOfPart(button.value, state);
      button.disabled = state.mode != "draw";
    }
  };
  moveByArrows(parts, (button) => choose(button.value));
  const act = (name) => makeTextButton(name, "", () => context.send({ type: name }));
  const [guess, clear, undo, redo] = ["guess", "clear", "undo", "redo"].map(act);
  const problems = make("ul", { className: "robsim-problems", role: "status" });
  const hint = make("p", { className: "robsim-quiet robsim-tool-hint" });
  context.on("state", (state) => {
    show(state);
    markChosen(parts, "aria-checked", (button) => button.value == state.part);
    undo.disabled = !state.can_undo;
    redo.disabled = !state.can_redo;
    hint.textContent = text(`hint.${state.mode}`);
    const words = state.problems.map((textContent) => make("li", { textContent }));
    problems.replaceChildren(...words);
    problems.hidden = !words.length || state.mode != "draw";
    for (const button of [guess, clear]) button.disabled = state.mode != "draw";
  });
  const next = () => {
    const names = Object.keys(context.state.parts);
    choose(names[(names.indexOf(context.state.part) + 1) % names.length]);
  };
  const row = make("div", { className: "robsim-tool-row" }, parts, guess, clear, undo, redo);
  return { element: make("div", { className: "robsim-tool-part" }, row, hint), problems, next };
}
