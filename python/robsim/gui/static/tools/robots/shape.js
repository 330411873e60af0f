// @ts-check
// Which robot it is: its list, its heading, its size, its name.
import { makeTextButton } from "../../base/buttons.js";
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";

const TURNS = [-10, -1, 1, 10]; // degrees

export function makeRobotShape(context, ruler) {
  const list = make("select", { className: "robsim-select", name: "robot",
    ariaLabel: text("robots") });
  list.onchange = () => context.send({ type: "load", name: list.value });
  const act = (name, kind = "") => makeTextButton(name, kind, () => context.send({ type: name }));
  const [reset, capture, whole, resume, noCamera] = [act("as_before"),
    act("capture", "robsim-primary"), act("capture_whole"), act("resume"), act("no_camera")];
  reset.onclick = () => context.send({ type: "reset" });
  const turns = TURNS.map((degrees) => {
    const button = makeTextButton("turn", "", () => context.send({ type: "turn", degrees }));
    button.textContent = `${degrees > 0 ? "+" : "\u2212"}${Math.abs(degrees)}\u00b0`;
    return button;
  });
  const square = make("output", { className: "robsim-number", name: "square" });
  const heading = make("output", { className: "robsim-number" });
  const size = numberField("robot_size", (value) =>
    context.send({ type: "resize", size: value }));
  const name = make("input", { className: "robsim-text-field", name: "robot_name", maxLength: 40,
    ariaLabel: text("robot_name"), placeholder: text("robot_name") });
  name.onkeydown = (event) => event.stopPropagation();
  const isThere = () => context.state.robots.includes(name.value.trim());
  const save = makeTextButton("save_robot", "robsim-primary", () =>
    context.send({ type: "save", name: name.value.trim(), overwrite: isThere() }));
  const showSave = () => (save.textContent = text(isThere() ? "replace_robot" : "save_robot"));
  name.oninput = showSave;

  context.on("state", (state) => {
    const isListed = state.robots.includes(state.name);
    const names = isListed ? state.robots : [state.name, ...state.robots];
    if ([...list.options].map(({ value }) => value).join() != names.join())
      list.replaceChildren(...names.map((value) => make("option", { value, textContent: value })));
    list.value = state.name;
    capture.hidden = whole.hidden = noCamera.hidden = state.mode != "capture";
    noCamera.textContent = text(context.setup?.is_live ? "no_camera" : "back_to_drawing");
    const [u, v, side] = (state.mode == "capture" && state.square) || [];
    square.textContent = side ? text("square", { u: Math.round(u), v: Math.round(v),
      side: Math.round(side) }) : "";
    resume.hidden = state.mode != "draw" || !state.can_capture;
    heading.textContent = `${state.alignment.toFixed(1).replace("-", "\u2212")}\u00b0`;
    if (document.activeElement != size) size.value = String(Number(state.size.toFixed(2)));
    showSave();
    save.disabled = state.mode != "draw" || state.problems.length > 0;
  });
  const row = (...parts) => make("div", { className: "robsim-tool-row" }, ...parts);
  const words = (id) => make("span", { className: "robsim-quiet", textContent: text(id) });
  return {
    element: make("div", { className: "robsim-tool-part" },
      row(list, reset, capture, whole, resume, noCamera, square),
      row(words("robot_heading"), ...turns, heading),
      row(words("robot_size"), size, words("robot_size_unit")),
      ruler.element,
      row(name, save)),
  };
}

function numberField(name, tell) {
  const field = make("input", { type: "number", className: "robsim-text-field", name, min: "1",
    step: "any", ariaLabel: text(name) });
  field.onchange = () => Number.isFinite(field.valueAsNumber) && tell(field.valueAsNumber);
  field.onkeydown = (event) => event.stopPropagation();
  return field;
}
