// @ts-check
// The panel that defines a robot: what is captured, what is drawn on it.
import { make } from "../base/dom.js";
import { makePicture } from "../camera/picture.js";
import { makeFilm } from "./film.js";
import { makePolygons } from "./robots/polygons.js";
import { makeRobotParts } from "./robots/parts.js";
import { makeRobotShape } from "./robots/shape.js";
import { makeRuler } from "./robots/ruler.js";
import { makeSquare } from "./robots/square.js";
import { renderTool } from "./tool.js";

export function renderRobots(host) {
  return renderTool(host, "robots", (context) => {
    const parts = makeRobotParts(context);
    const ruler = makeRuler(context, () => picture);
    const picture = makeRobotPicture(context, parts.next, ruler);
    const element = make("div", { className: "robsim-camera" }, picture.canvas,
      make("div", { className: "robsim-camera-bar" }, picture.whole), parts.problems);
    const beside = [parts, makeRobotShape(context, ruler)];
    const film = makeFilm(context);
    context.on("state", ({ mode }) => mode == "capture" || (film.element.hidden = true));
    return { view: element, below: film.element, width: picture.width,
      beside: beside.map((part) => part.element) };
  });
}

function makeRobotPicture(context, next, ruler) {
  const of = () => picture;
  const polygons = makePolygons(context, of);
  const square = makeSquare(context, of);
  const history = ({ ctrlKey, metaKey, shiftKey, key }) => {
    if (!(ctrlKey || metaKey) || key.toLowerCase() != "z") return false;
    context.send({ type: shiftKey ? "redo" : "undo" });
    return true;
  };
  const taking = () => [square, ruler].find((one) => one.isOn()) ?? polygons;
  let dragged = polygons; // whose the drag is
  const tool = {
    isActive: () => taking() != polygons || polygons.isActive(),
    takesDrags: () => taking() != polygons || polygons.takesDrags(),
    hover: () => {},
    click: (at) => taking().click?.(at),
    doubleClick: (at) => taking().doubleClick?.(at) ?? false,
    dragStart: (at) => (dragged = taking()).dragStart(at),
    drag: (_, to) => dragged.drag(to),
    dragEnd: () => dragged.dragEnd(),
    giveUp: () => dragged.giveUp(),
    key: (event) => {
      if (event.key == "Enter" && context.state.mode == "draw") return next(), true;
      return taking().key(event);
    },
  };
  const draw = (scene) => [square, polygons, ruler].forEach((one) => one.draw(scene));
  const picture = makePicture(context, { label: "robot_picture", inks: [], draw, tool });
  context.el.addEventListener("keydown", (event) => {
    if (event.target.matches("input, textarea") || !history(event)) return;
    event.preventDefault();
    event.stopPropagation();
  });
  return picture;
}
