// @ts-check
// The yellow square of what is captured: it is dragged, and its corners make it larger.
import { ARROWS } from "../../base/arrows.js";
import { distance } from "../../base/geometry.js";

const REACH_OF_CORNER = 16; // px on the screen
const SMALLEST = 8; // px of the picture

export function makeSquare(context, picture) {
  let from = null; // where a drag began, and what the square was
  let local = null;
  const square = () => local ?? context.state.square;
  const isOn = () => context.state.mode == "capture" && Boolean(square());
  const tell = ([u, v, side]) => {
    local = [u, v, side];
    context.send({ type: "square", at: [u, v], side });
    picture().later();
  };
  const corners = ([u, v, side]) => [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) =>
    [u + (x * side) / 2, v + (y * side) / 2]);
  context.on("state", () => {
    if (!from) local = null;
    picture().later();
  });
  return {
    isOn,
    dragStart: (at) => {
      if (!isOn()) return false;
      const lens = picture().lens;
      const [u, v, side] = square();
      const away = corners(square()).map((one) => distance(lens.toCanvas(one), at));
      const isCorner = Math.min(...away) < REACH_OF_CORNER * devicePixelRatio;
      const [pu, pv] = lens.toPixel(at);
      if (!isCorner && Math.max(Math.abs(pu - u), Math.abs(pv - v)) > side / 2) return false;
      from = { at: [pu, pv], square: [u, v, side], isCorner };
      return true;
    },
    drag: (to) => {
      const [pu, pv] = picture().lens.toPixel(to);
      const [u, v, side] = from.square;
      if (from.isCorner) {
        const half = Math.max(Math.abs(pu - u), Math.abs(pv - v));
        tell([u, v, Math.max(2 * half, SMALLEST)]);
      } else tell([u + pu - from.at[0], v + pv - from.at[1], side]);
    },
    dragEnd: () => (from = null),
    giveUp: () => (from = null),
    key: ({ key, shiftKey }) => {
      if (!isOn() || !(key in ARROWS || key == "PageUp" || key == "PageDown")) return false;
      const step = shiftKey ? 10 : 1;
      const [u, v, side] = square();
      const [du, dv] = ARROWS[key] ?? [0, 0];
      const grows = { PageUp: 4, PageDown: -4 }[key] ?? 0;
      tell([u + step * du, v + step * dv, Math.max(side + step * grows, SMALLEST)]);
      return true;
    },
    draw: ({ pen, pixel, unit }) => {
      if (!isOn()) return;
      const [[left, top], , [right, bottom]] = corners(square()).map(pixel);
      for (const [width, color] of [[4, "#0009"], [2, "#ffd500"]]) {
        pen.lineWidth = width * unit;
        pen.strokeStyle = color;
        pen.strokeRect(left, top, right - left, bottom - top);
      }
    },
  };
}
