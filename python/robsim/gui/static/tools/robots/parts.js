// @ts-check
// What is drawn of a robot: the outline, then both markers; what is wrong with it.
import { makeRadios } from "../../base/buttons.js";
import { say } from "../../base/dom.js";
import { text } from "../../base/texts.js";
import { makeAct, makeHint, makeList, makePart, makeRow } from "../pieces.js";

/** What a part is called: a marker by its role, as soon as it has one, and its colour. */
function nameOfPart(part, { roles }) {
  if (part == "outline") return text("part.outline");
  return text(`part.${roles[part] ?? "marker"}`, { color: part });
}

export function makeRobotParts({ context, history }) {
  const choose = (name) => context.send({ type: "part", name });
  const parts = makeRadios("robsim-segments", text("parts"), choose);
  const [guess, clear] = ["guess", "clear"].map((name) => makeAct(context, name));
  const problems = makeList();
  const hint = makeHint("hint.draw");
  context.on("state", (state) => {
    const disabled = state.mode != "draw";
    parts.show(Object.keys(state.parts).map((value) =>
      ({ value, textContent: nameOfPart(value, state), disabled })), state.part);
    say(hint, text(`hint.${state.mode}`));
    problems.show(disabled ? [] : state.problems);
    guess.disabled = clear.disabled = disabled;
  });
  const next = () => {
    const names = Object.keys(context.state.parts);
    choose(names[(names.indexOf(context.state.part) + 1) % names.length]);
    return true;
  };
  return {
    element: makePart(makeRow(parts.element, guess, clear, ...history), hint),
    problems: problems.element,
    hand: { key: ({ key }) => key == "Enter" && context.state.mode == "draw" && next() },
  };
}
