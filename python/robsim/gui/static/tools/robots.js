// The panel that defines a robot: its captured picture, and the drawing on it.
import { makeRadios } from "../base/buttons.js";
import { make, say, text } from "../base/dom.js";
import { makeAct, makeHint, makeList, makeNumberField, makePart, makeRow, makeTextField,
  makeWords, showIn } from "./pieces.js";
import { makePolygons } from "./robots/polygons.js";
import { makeRuler } from "./robots/ruler.js";
import { makeSquare } from "./robots/square.js";
import { renderTool } from "./tool.js";

const TURNS = [-10, -1, 1, 10]; // degrees

export const renderRobots = (host) => renderTool(host, "robots", (tool) => {
  const { context, picture, film } = tool;
  const parts = makeRobotParts(tool);
  const ruler = makeRuler(context, picture);
  context.on("state", ({ mode }) => mode == "capture" || (film.hidden = true));
  return {
    hands: [makeSquare(context, picture), makePolygons(context, picture), ruler, parts.hand],
    below: film,
    beside: [parts.element, makeRobotShape(context, ruler.element)],
  };
});

/** The name of a part: for a marker its role, if known, and its colour. */
function nameOfPart(part, { roles }) {
  if (part == "outline") return text("part.outline");
  return text(`part.${roles[part] ?? "marker"}`, { color: part });
}

/** The parts of a robot that are drawn, the outline, then both markers; their problems. */
function makeRobotParts({ context, history }) {
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
    element: makePart(makeRow(parts.element, guess, clear, ...history), hint,
      problems.element),
    hand: { key: ({ key }) => key == "Enter" && context.state.mode == "draw" && next() },
  };
}

/** Which robot it is: its list, its heading, its size, its name. */
function makeRobotShape(context, ruler) {
  const list = make("select.robsim-select", { name: "robot",
    ariaLabel: text("robots"), onchange: () => context.send({ type: "load", name: list.value }) });
  const reset = makeAct(context, "as_before", "", () => ({ type: "reset" }));
  const capture = makeAct(context, "capture", "robsim-primary");
  const [whole, resume, noCamera] = ["capture_whole", "resume", "no_camera"].map((name) =>
    makeAct(context, name));
  const turns = TURNS.map((degrees) => {
    const button = makeAct(context, "turn", "", () => ({ type: "turn", degrees }));
    button.textContent = `${degrees > 0 ? "+" : "\u2212"}${Math.abs(degrees)}\u00b0`;
    return button;
  });
  const [square, heading] = ["square", ""].map((name) => make("output.robsim-number", { name }));
  const size = makeNumberField("robot_size", (value) =>
    context.send({ type: "resize", size: value }), { min: "1" });
  const name = makeTextField("robot_name", () => {}, { maxLength: 40,
    placeholder: text("robot_name"), oninput: () => showSave() });
  const isThere = () => context.state.robots.includes(name.value.trim());
  const save = makeAct(context, "save_robot", "robsim-primary", () =>
    ({ type: "save", name: name.value.trim(), overwrite: isThere() }));
  const showSave = () => (save.textContent = text(isThere() ? "replace_robot" : "save_robot"));

  context.on("state", (state) => {
    const isListed = state.robots.includes(state.name);
    const names = isListed ? state.robots : [state.name, ...state.robots];
    if ([...list.options].map(({ value }) => value).join() != names.join())
      list.replaceChildren(...names.map((value) => make("option", { value, textContent: value })));
    list.value = state.name;
    capture.hidden = whole.hidden = noCamera.hidden = state.mode != "capture";
    noCamera.textContent = text(context.setup?.is_live ? "no_camera" : "back_to_drawing");
    const [u, v, side] = ((state.mode == "capture" && state.square) || []).map(Math.round);
    square.textContent = side ? text("square", { u, v, side }) : "";
    resume.hidden = state.mode != "draw" || !state.can_capture;
    heading.textContent = `${state.alignment.toFixed(1).replace("-", "\u2212")}\u00b0`;
    showIn(size, String(Number(state.size.toFixed(2))));
    showSave();
    save.disabled = state.mode != "draw" || state.problems.length > 0;
  });
  return makePart(
    makeRow(list, reset, capture, whole, resume, noCamera, square),
    makeRow(makeWords("robot_heading"), ...turns, heading),
    makeRow(makeWords("robot_size"), size, makeWords("robot_size_unit")),
    ruler,
    makeRow(name, save));
}
