// The floor's grid on the picture: lines each so many mm, numbers, axes; bent as the lens bends it.
import { areaToPixel, pixelToArea } from "../../camera/projection.js";
import { drawLabel, strokePath } from "../../camera/strokes.js";

const PIECES = 48; // of a line
const FLOOR_INK = "#ffd60a";
const HIGH_INK = "#00e5ff";
const AXIS_INKS = ["#ff6b6b", "#5ee08a"];
const AXIS = 0.16; // of the area: how long the arrows are

/** Return what draws the grid of `context.state.grid`; `draw(scene)`. */
export function makeGrid(context) {
  let known = null; // the grid that the lines are of
  let lines = null;
  return {
    draw: (scene) => {
      const { grid } = context.state;
      if (!grid || grid.size.join() != scene.frame.size.join()) return;
      if (grid != known) [known, lines] = [grid, linesOf(grid)];
      if (lines.high) strokeAll(scene, lines.high, HIGH_INK, 0.8);
      strokeAll(scene, lines.floor, FLOOR_INK, 1.2);
      strokeAll(scene, [lines.border], FLOOR_INK, 2.2);
      lines.axes.forEach((axis, i) => drawAxis(scene, axis, AXIS_INKS[i], "xy"[i]));
      const taken = [];
      for (const label of lines.labels)
        if (isNear(label.at, grid.size)) drawLabel(scene, { ...label, ink: FLOOR_INK, taken });
    },
  };
}

/** Return what takes a place on the floor to a pixel of the camera. */
function placeToPixel(grid) {
  const toPixel = areaToPixel(grid);
  return (place) => toPixel(place.map((side) => side / grid.scale));
}

/** Return what takes a pixel of the camera to a place on the floor. */
export function pixelToPlace(grid) {
  const toArea = pixelToArea(grid);
  return (pixel) => toArea(pixel).map((side) => side * grid.scale);
}

function linesOf(grid) {
  const [right, bottom] = grid.area.map((side) => side * grid.scale);
  const toPixel = placeToPixel(grid);
  const between = (from, to) => Array.from({ length: PIECES + 1 }, (_, i) =>
    toPixel([0, 1].map((k) => from[k] + ((to[k] - from[k]) * i) / PIECES)));
  const corners = [[0, 0], [right, 0], [right, bottom], [0, bottom], [0, 0]];
  const stations = (end) =>
    Array.from({ length: Math.floor(end / grid.step + 1e-6) + 1 }, (_, i) => i * grid.step);
  const lattice = (line) => [
    ...stations(right).map((x) => line([x, 0], [x, bottom])),
    ...stations(bottom).map((y) => line([0, y], [right, y])),
  ];
  const high = grid.high && placeToPixel({ ...grid, map: grid.high });
  const long = AXIS * Math.max(right, bottom);
  return {
    floor: lattice(between),
    high: high && lattice((from, to) => [from, to].map(high)),
    border: corners.slice(1).flatMap((to, i) => between(corners[i], to)),
    axes: [between([0, 0], [long, 0]), between([0, 0], [0, long])],
    labels: [
      ...stations(right)
        .map((x) => ({ at: toPixel([x, 0]), words: said(x, grid), beside: [0, -1] })),
      ...stations(bottom).slice(1)
        .map((y) => ({ at: toPixel([0, y]), words: said(y, grid), beside: [-1, 0] })),
    ],
  };
}

const said = (value, { unit }) => (value ? String(Number(value.toPrecision(6))) : `0 ${unit}`);

function strokeAll(scene, lines, ink, width) {
  const { pen, pixel, frame } = scene;
  pen.beginPath();
  for (const line of lines) {
    let isOn = false;
    for (const point of line) {
      const isSeen = isNear(point, frame.size);
      const [x, y] = pixel(point);
      if (isSeen && isOn) pen.lineTo(x, y);
      else if (isSeen) pen.moveTo(x, y);
      isOn = isSeen;
    }
  }
  strokePath(scene, ink, { width });
}

/** Whether a pixel is in or near the picture: far outside, a lens is undefined. */
function isNear([u, v], [width, height]) {
  return u > -width / 2 && u < 1.5 * width && v > -height / 2 && v < 1.5 * height;
}

function drawAxis(scene, line, ink, name) {
  strokeAll(scene, [line], ink, 3);
  const [from, to] = [line.at(-4), line.at(-1)].map(scene.pixel);
  if (![...from, ...to].every(Number.isFinite)) return;
  const { pen, unit } = scene;
  const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
  pen.beginPath();
  for (const [long, turn] of [[9, 0], [7, 2.5], [7, -2.5]])
    pen.lineTo(to[0] + long * unit * Math.cos(angle + turn),
      to[1] + long * unit * Math.sin(angle + turn));
  pen.closePath();
  pen.fillStyle = ink;
  pen.fill();
  const words = { at: line.at(-1), words: name, beside: name == "x" ? [0.5, 1] : [1, 0.5] };
  drawLabel(scene, { ...words, ink, isStrong: true });
}
