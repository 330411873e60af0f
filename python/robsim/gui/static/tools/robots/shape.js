// @ts-check
// Which robot it is: its list, its heading, its size, its name.
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";
import { makeAct, makeNumberField, makePart, makeRow, makeTextField, makeWords,
  showIn } from "../pieces.js";

const TURNS = [-10, -1, 1, 10]; // degrees

export function makeRobotShape(context, ruler) {
  const list = make("select", { className: "robsim-select", name: "robot",
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
  const [square, heading] = ["square", ""].map((name) =>
    make("output", { className: "robsim-number", name }));
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
