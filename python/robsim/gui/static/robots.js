// @ts-check
// The panel that defines a robot: what is captured, what is drawn on it.
import { make } from "./base/dom.js";
import { makePicture } from "./camera/picture.js";
import { makePolygons } from "./tools/polygons.js";
import { makeRobotParts } from "./tools/robot_parts.js";
import { makeRobotShape } from "./tools/robot_shape.js";
import { makeSquare } from "./tools/square.js";
import { renderTool } from "./tools/tool.js";

export function renderRobots(host) {
  return renderTool(host, "robots", (context) => {
    const parts = makeRobotParts(context);
    const picture = makeRobotPicture(context, parts.next);
    const element = make("div", { className: "robsim-camera" }, picture.canvas,
      make("div", { className: "robsim-camera-bar" }, picture.whole));
    const beside = [parts, makeRobotShape(context)];
    return { view: element, below: "", width: picture.width,
      beside: beside.map((part) => part.element) };
  });
}

function makeRobotPicture(context, next) {
  const of = () => picture;
  const polygons = makePolygons(context, of);
  const square = makeSquare(context, of);
  const history = ({ ctrlKey, metaKey, shiftKey, key }) => {
    if (!(ctrlKey || metaKey) || key.toLowerCase() != "z") return false;
    context.send({ type: shiftKey ? "redo" : "undo" });
    return true;
  };
  let isSquare = false; // the drag is the square's
  const tool = {
    ...polygons,
    isActive: () => square.isOn() || polygons.isActive(),
    takesDrags: () => square.isOn() || polygons.takesDrags(),
    dragStart: (at) => (isSquare = square.dragStart(at)) || polygons.dragStart(at),
    drag: (from, to) => (isSquare ? square.drag(to) : polygons.drag(from, to)),
    dragEnd: () => (isSquare ? square.dragEnd() : polygons.dragEnd()),
    giveUp: () => (isSquare ? square.dragEnd() : polygons.giveUp()),
    key: (event) => {
      if (event.key == "Enter" && context.state.mode == "draw") return next(), true;
      return square.key(event) || polygons.key(event);
    },
  };
  const draw = (scene) => {
    square.draw(scene);
    polygons.draw(scene);
  };
  const picture = makePicture(context, { label: "robot_picture", inks: [], draw, tool });
  context.el.addEventListener("keydown", (event) => {
    if (event.target.matches("input, textarea") || !history(event)) return;
    event.preventDefault();
    event.stopPropagation();
  });
  return picture;
}
