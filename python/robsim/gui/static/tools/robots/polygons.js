// The polygons of a robot on its picture: corners that are dragged, put on edges, removed.
import { distance } from "../../base/geometry.js";
import { arrowStep } from "../../base/gestures.js";
import { drawArrow, drawDot, drawLine } from "../../camera/strokes.js";

const CORNER = 4.5; // px on the screen
const CHOSEN_INK = "#2fd16b";
const HEADING = 46; // px on the screen, of its arrow

/** Make the hand that edits polygons; Python receives each change at once. */
export function makePolygons(context, picture) {
  let chosen = -1; // the corner that the keys move
  const state = () => context.state;
  const corners = () => state().parts[state().part];
  const placed = () => corners().map((point, i) => picture.placeOf(i, point));
  const headingEnd = () => {
    const { centre, alignment } = state();
    const angle = (-alignment * Math.PI) / 180; // it faces right after a clockwise rotation by that
    const long = picture.pixels(HEADING);
    return [centre[0] + long * Math.cos(angle), centre[1] + long * Math.sin(angle)];
  };
  const moveCorner = (corner, at, goesOn) =>
    context.send({ type: "move", corner, at, goes_on: goesOn });
  const cut = () => {
    if (chosen < 0) return false;
    context.send({ type: "cut", corner: chosen });
    chosen = -1;
    return true;
  };
  context.on("state", () => {
    if (chosen > corners().length) chosen = -1; // the last one may be on its way to Python
  });
  return {
    isOn: () => state().mode == "draw",
    click: (at) => {
      chosen = picture.nearest(at, corners());
      if (chosen < 0) {
        chosen = edgeNear(corners(), at);
        context.send({ type: "insert", corner: chosen, at });
      }
      picture.later();
    },
    doubleClick: (at) => {
      chosen = picture.nearest(at, corners());
      return cut();
    },
    grab: (at) => {
      const corner = picture.nearest(at, corners());
      if (corner >= 0) {
        chosen = corner;
        return { key: corner, at: corners()[corner],
          move: (to, goesOn) => moveCorner(corner, to, goesOn) };
      }
      if (picture.nearest(at, [headingEnd()]) < 0) return null;
      const face = (to, goesOn) => context.send({ type: "face", at: to, goes_on: goesOn });
      return { key: "heading", at: headingEnd(), move: face };
    },
    key: (event) => {
      if (event.key == "Delete" || event.key == "Backspace") return cut();
      const [pressed, corner] = [arrowStep(event), corners()[chosen]];
      if (!pressed || !corner) return false;
      const step = picture.lens.turnedBack(pressed);
      moveCorner(chosen, [corner[0] + step[0], corner[1] + step[1]], false);
      return true;
    },
    draw: (scene) => {
      if (state().mode != "draw") return;
      for (const [part, points] of Object.entries(state().parts)) {
        const isIt = part == state().part;
        drawPolygon(scene, isIt ? placed() : points, state().inks[part], isIt ? chosen : null);
      }
      const [from, to] = [state().centre, picture.placeOf("heading", headingEnd())];
      drawArrow(scene, scene.pixel(from), scene.pixel(to), "#fff");
    },
  };
}

/** Return before which corner a new one lies on the nearest edge; behind the last of a line. */
function edgeNear(points, at) {
  if (points.length < 3) return points.length;
  const away = points.map((point, i) => {
    const next = points[(i + 1) % points.length];
    return distance(point, at) + distance(next, at) - distance(point, next);
  });
  return away.indexOf(Math.min(...away)) + 1;
}

/** Draw one, and its corners if one of them is `chosen`, or -1. */
function drawPolygon(scene, points, ink, chosen) {
  const shown = points.map(scene.pixel);
  drawLine(scene, shown, ink, { isClosed: true });
  if (chosen == null) return;
  shown.forEach((point, i) => {
    const isIt = i == chosen;
    drawDot(scene, point, isIt ? CHOSEN_INK : ink, (isIt ? 1.5 : 1) * CORNER);
  });
}
