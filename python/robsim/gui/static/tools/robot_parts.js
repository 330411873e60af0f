// @ts-check
// What is drawn of a robot: outline, then red, then blue marker; what is wrong with it.
import { makeTextButton, markChosen, moveByArrows } from "../base/buttons.js";
import { make } from "../base/dom.js";
import { text } from "../base/texts.js";

const ROBOT_PARTS = ["outline", "red", "blue"];

export function makeRobotParts(context) {
  const choose = (name) => context.send({ type: "part", name });
  const buttons = ROBOT_PARTS.map((value) => make("button", {
    type: "button", role: "radio", value, textContent: text(`part.${value}`),
    onclick: () => choose(value),
  }));
  const parts = make("div", { className: "robsim-segments", role: "radiogroup",
    ariaLabel: text("parts") }, ...buttons);
  moveByArrows(parts, (button) => choose(button.value));
  const act = (name) => makeTextButton(name, "", () => context.send({ type: name }));
  const [guess, clear, undo, redo] = ["guess", "clear", "undo", "redo"].map(act);
  const problems = make("ul", { className: "robsim-problems", role: "status" });
  const hint = make("p", { className: "robsim-quiet robsim-tool-hint" });
  context.on("state", (state) => {
    markChosen(parts, "aria-checked", (button) => button.value == state.part);
    undo.disabled = !state.can_undo;
    redo.disabled = !state.can_redo;
    hint.textContent = text(`hint.${state.mode}`);
    const words = state.problems.map((textContent) => make("li", { textContent }));
    problems.replaceChildren(...words);
    problems.hidden = !words.length || state.mode != "draw";
    for (const button of [...buttons, guess, clear]) button.disabled = state.mode != "draw";
  });
  const next = () => choose(ROBOT_PARTS[(ROBOT_PARTS.indexOf(context.state.part) + 1) % 3]);
  const row = make("div", { className: "robsim-tool-row" }, parts, guess, clear, undo, redo);
  return { element: make("div", { className: "robsim-tool-part" }, row, hint), problems, next };
}
