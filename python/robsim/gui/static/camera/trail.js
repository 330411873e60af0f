// @ts-check
// The path driven, on a canvas of its own, to which each frame adds its piece.
import { haloOf } from "./strokes.js";

const LONGEST_TRAIL = 2000; // steps; more would cover the floor

/** Return a function that draws the measured positions up to the frame's step. */
export function makeTrail() {
  const layer = document.createElement("canvas");
  const pen = layer.getContext("2d");
  let first = 0; // row that is drawn
  let drawn = 0; // rows up to which it is
  let known = null; // rows of which it is
  let key = "";

  const prepare = (scene, rows, upto) => {
    const { canvas } = scene.pen;
    const { scale, left, top } = scene.lens;
    const { map, intrinsics } = scene.frame;
    const view = [canvas.width, canvas.height, scale, left, top, ...map, intrinsics];
    const now = [...view, scene.colors.measured, rows.epoch].join();
    const isShort = upto - first <= 1.25 * LONGEST_TRAIL;
    if (now == key && rows == known && drawn <= upto && isShort) return;
    known = rows;
    [layer.width, layer.height] = [canvas.width, canvas.height]; // clears it
    [key, first] = [now, Math.max(0, upto - LONGEST_TRAIL)];
    drawn = first;
  };
  const add = ({ place, unit, colors }, rows, upto) => {
    pen.beginPath();
    let isUp = true;
    for (let row = Math.max(first, drawn - 1); row < upto; row++) {
      const [x, y] = place([rows.get(row, 0), rows.get(row, 1)]);
      if (isUp) pen.moveTo(x, y);
      else pen.lineTo(x, y);
      isUp = !(x === x); // not seen: a gap
    }
    pen.lineJoin = "round";
    pen.strokeStyle = haloOf(pen, colors.measured);
    pen.lineWidth = 2.5 * unit;
    pen.stroke();
    pen.strokeStyle = colors.measured;
    pen.lineWidth = 1.25 * unit;
    pen.stroke();
  };
  return (scene) => {
    const rows = scene.context.store.get("pose_measured");
    if (!rows) return;
    const upto = Math.min(rows.count, scene.frame.k + 1);
    prepare(scene, rows, upto);
    if (upto > drawn) add(scene, rows, upto);
    drawn = upto;
    scene.pen.globalAlpha = 0.8;
    scene.pen.drawImage(layer, 0, 0);
    scene.pen.globalAlpha = 1;
  };
}
