// @ts-check
// A path that is being drawn: corners that are clicked, lines that are drawn with the button down.
import { distance, simplified } from "../base/geometry.js";
import { drawDot, drawLine } from "./strokes.js";

const MOST_PATH_POINTS = 200;
const DRAW_TOLERANCE = 2; // px on the screen that a drawn line may be simplified by

/** Points are on the work area; `size` = what a pixel of the screen is there. */
export function makeDraft() {
  const draft = { points: [] };
  let stroke = null; // the point with which the line under way begins

  draft.clear = () => [draft.points, stroke] = [[], null];
  draft.add = (point) => {
    if (draft.points.length < MOST_PATH_POINTS) draft.points.push(point);
  };
  draft.begin = (point) => {
    stroke = draft.points.length;
    draft.points.push(point);
  };
  draft.extend = (point, size) => {
    if (distance(draft.points.at(-1), point) > size) draft.points.push(point);
  };
  /** End the line under way; return whether it is all that there is. */
  draft.end = (size) => {
    const [before, drawn] = [draft.points.slice(0, stroke), draft.points.slice(stroke)];
    const room = MOST_PATH_POINTS - before.length;
    const simple = simplified(drawn, DRAW_TOLERANCE * size, Math.max(room, 2));
    draft.points = [...before, ...simple.slice(0, room)];
    stroke = null;
    return !before.length;
  };
  draft.giveUp = () => {
    if (stroke != null) draft.points.length = stroke;
    stroke = null;
  };
  /** Drop corners that were set twice, as by a double click. */
  draft.settle = () => {
    draft.points = draft.points.filter((point, i, all) => !i || distance(point, all[i - 1]) > 1);
  };
  draft.draw = (scene, end) => {
    if (!draft.points.length) return;
    const isOpen = stroke == null;
    const color = scene.colors["other-2"];
    const line = isOpen && end ? [...draft.points, end] : draft.points;
    drawLine(scene, line.map(scene.place), color, { width: 2 });
    if (isOpen) for (const point of draft.points) drawDot(scene, scene.place(point), color, 3);
  };
  return draft;
}
