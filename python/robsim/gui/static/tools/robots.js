// @ts-check
// The panel that defines a robot: what is captured, what is drawn on it.
import { makeRobotParts } from "./robots/parts.js";
import { makePolygons } from "./robots/polygons.js";
import { makeRuler } from "./robots/ruler.js";
import { makeRobotShape } from "./robots/shape.js";
import { makeSquare } from "./robots/square.js";
import { renderTool } from "./tool.js";

export const renderRobots = (host) => renderTool(host, "robots", (tool) => {
  const { context, picture, film } = tool;
  const parts = makeRobotParts(tool);
  const ruler = makeRuler(context, picture);
  context.on("state", ({ mode }) => mode == "capture" || (film.hidden = true));
  return {
    hands: [makeSquare(context, picture), makePolygons(context, picture), ruler, parts.hand],
    over: [parts.problems],
    below: film,
    beside: [parts.element, makeRobotShape(context, ruler.element)],
  };
});
