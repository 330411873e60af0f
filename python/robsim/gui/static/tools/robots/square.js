// The yellow square of the area to capture: drag it, or drag its corners to resize it.
import { arrowStep } from "../../base/gestures.js";
import { drawBox } from "../../camera/strokes.js";

const REACH_OF_CORNER = 16; // px on the screen
const SMALLEST = 8; // px of the picture
const SQUARE_INK = "#ffd500";

export function makeSquare(context, picture) {
  let local = null; // until Python has it
  const square = () => local ?? context.state.square;
  const tell = ([u, v], side) => {
    local = [u, v, Math.max(side, SMALLEST)];
    context.send({ type: "square", at: [u, v], side: local[2] });
    picture.later();
  };
  const corners = () => {
    const [u, v, side] = square();
    return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) =>
      [u + (x * side) / 2, v + (y * side) / 2]);
  };
  const away = ([u, v], at) => Math.max(Math.abs(at[0] - u), Math.abs(at[1] - v));
  context.on("state", () => {
    if (!picture.isHeld()) local = null;
  });
  return {
    isOn: () => context.state.mode == "capture" && Boolean(square()),
    grab: (at) => {
      const [u, v, side] = square();
      if (picture.nearest(at, corners(), REACH_OF_CORNER) >= 0)
        return { at, move: (to) => tell([u, v], 2 * away([u, v], to)) };
      return away([u, v], at) > side / 2 ? null : { at: [u, v], move: (to) => tell(to, side) };
    },
    key: (event) => {
      const grows = { PageUp: 4, PageDown: -4 }[event.key] ?? 0;
      const step = arrowStep(event) ?? [0, 0];
      const [u, v, side] = square();
      if (!grows && !step.some(Boolean)) return false;
      tell([u + step[0], v + step[1]], side + grows * (event.shiftKey ? 10 : 1));
      return true;
    },
    draw: (scene) => {
      if (context.state.mode != "capture" || !square()) return;
      const [first, , last] = corners().map(scene.pixel);
      drawBox(scene, first, last, SQUARE_INK, { width: 2 });
    },
  };
}
