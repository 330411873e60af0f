// @ts-check
// The classes' finds in the picture: the pixels of each class, and the boxes of the blobs.

export function drawFound(scene) {
  const { pen, frame, lens, context } = scene;
  pen.imageSmoothingEnabled = false;
  if (frame.mask) drawMask(pen, frame, lens);
  if (context.state.tests) drawBoxes(scene);
}

/** Draw the mask, which has each pixel of the picture, or each second one, and so on. */
function drawMask(pen, { mask, size }, { left, top, scale }) {
  const side = Math.round(Math.max(...size) / Math.max(mask.width, mask.height)) * scale;
  pen.drawImage(mask, left, top, mask.width * side, mask.height * side);
}

function drawBoxes({ pen, frame, pixel, unit, context }) {
  const css = new Map(context.state.classes.map((one) => [one.name, one.css]));
  pen.lineWidth = unit;
  for (const [name, left, top, right, bottom] of frame.boxes) {
    const [x, y] = pixel([left - 0.5, top - 0.5]);
    const [x2, y2] = pixel([right + 0.5, bottom + 0.5]);
    pen.strokeStyle = css.get(name) ?? "magenta";
    pen.strokeRect(x, y, x2 - x, y2 - y);
  }
}
