// The overlays on the camera's picture: each overlay has a name, and can be switched.
import { ellipse, fromRobot } from "../base/geometry.js";
import { drawArrow, drawBox, drawDot, drawLine, haloOf } from "./strokes.js";

const TRACED_STEPS = 150; // steps with visible objects
const ELLIPSE_SIGMAS = 2;
const DASH = [5, 4]; // px on the screen
const LONGEST_TRAIL = 2000; // steps; more would cover the floor

/**
 * The overlays from the lowest to the highest. Each has `shown` at first, the theme's `color`, a
 * drawing function, the required `columns` of the trace, and `is`: whether a run has such data.
 *
 * A scene has `pen` (of the canvas), `lens`, `unit` (device pixels a px), `place` (work area to
 * canvas), `pixel` (camera to canvas), `frame`, `context`, `ink(name)` (of the theme),
 * `classColors`.
 */
export const makeOverlays = () => [
  { name: "path_driven", shown: true, color: "measured", columns: pathColumns, draw: makeTrail() },
  { name: "ghosts", shown: true, color: "ghost-1", draw: drawGhosts },
  { name: "pointed", shown: true, color: "quiet", draw: drawPointed },
  { name: "object_trace", shown: true, columns: blobColumns, draw: drawObjectTrace },
  { name: "planned", shown: true, color: "other-5", is: hasGoals, draw: drawPlanned },
  { name: "boxes", shown: true, draw: drawBoxes },
  { name: "particles", shown: true, color: "estimated", draw: drawParticles },
  { name: "covariance", shown: true, color: "estimated", draw: drawCovariance },
  { name: "held_pose", shown: true, color: "held", draw: drawHeld },
  { name: "outline", shown: true, color: "measured", draw: drawOutline },
  { name: "heading_line", shown: true, color: "measured", draw: drawHeading },
  { name: "truth", shown: false, color: "true", is: hasTruth, draw: drawTruth },
  { name: "glass", shown: false, draw: () => {} }, // it lies beside the robot
];

const pathColumns = () => ["pose_measured"];
const hasGoals = ({ source, has_goals: isAsked }) => source != "trace" || isAsked;
const hasTruth = ({ has_truth: isKnown }) => isKnown ?? true;

export const isShown = (context, { name, shown }) => context.local.overlays[name] ?? shown;

/**
 * Draw a goal [x, y] of the work area, a ring around a dot; with a heading, [x, y, heading], an
 * arrow shows it, as long as the line of the robot's own.
 */
function drawGoal(scene, goal, color) {
  const [x, y] = scene.place(goal);
  const radius = 8 * scene.unit;
  const ring = Array.from({ length: 32 }, (_, i) =>
    fromRobot([x, y, (i * Math.PI) / 16], [radius, 0]));
  drawLine(scene, ring, color, { width: 2, isClosed: true });
  drawDot(scene, [x, y], color);
  if (goal.length < 3) return;
  const tip = scene.place(fromRobot(goal, [1.35 * robotReach(scene), 0]));
  const begin = fromRobot([x, y, Math.atan2(tip[1] - y, tip[0] - x)], [radius, 0]);
  drawArrow(scene, begin, tip, color, { width: 2.5 });
}

function outlineAt(scene, pose, ink, options) {
  if (!pose) return;
  const points = scene.context.setup.robot.outline.map((point) =>
    scene.place(fromRobot(pose, point)));
  drawLine(scene, points, scene.ink(ink), { isClosed: true, ...options });
}

const UNKNOWN_REACH = 40; // px, of a robot without a known outline

function robotReach({ context }) {
  const { outline } = context.setup.robot;
  return outline.length ? Math.max(...outline.map(([forward]) => forward)) : UNKNOWN_REACH;
}

function drawOutline(scene) {
  outlineAt(scene, scene.frame.measured, "measured", { width: 2 });
}

/** Draw the centre of the robot, and a line from there to where it looks. */
function headingAt(scene, pose, ink, options) {
  if (!pose) return;
  const reach = 1.35 * robotReach(scene);
  const ends = [[0, 0], [reach, 0]].map((point) => scene.place(fromRobot(pose, point)));
  drawLine(scene, ends, scene.ink(ink), options);
  drawDot(scene, ends[0], scene.ink(ink), 3);
}

function drawHeading(scene) {
  headingAt(scene, scene.frame.measured, "measured", { width: 2.5 });
}

function drawHeld(scene) {
  const { held, measured } = scene.frame;
  if (!measured) outlineAt(scene, held, "held", { dash: DASH, width: 2 });
}

function drawTruth(scene) {
  outlineAt(scene, scene.frame.truth, "true", { dash: DASH }); // lower lines show
  headingAt(scene, scene.frame.truth, "true", { dash: DASH });
}

/** Where other runs were at this step, or at their last one: outline, heading, the way there. */
function drawGhosts(scene) {
  const { pen, frame, context, ink } = scene;
  for (const { ink: name, rows } of context.ghosts) {
    const k = Math.min(frame.k, rows.count - 1);
    const pose = (at) => [0, 1, 2].map((field) => rows.get(at, field));
    if (k < 0 || Number.isNaN(pose(k)[0])) continue;
    pen.globalAlpha = 0.35;
    const outline = context.setup.robot.outline.map((point) =>
      scene.place(fromRobot(pose(k), point)));
    fillArea(pen, outline, ink(name));
    pen.globalAlpha = k < frame.k ? 0.4 : 0.75;
    const first = Math.max(0, k - TRACED_STEPS);
    const way = Array.from({ length: k + 1 - first }, (_, i) => scene.place(pose(first + i)));
    drawLine(scene, way, ink(name), { width: 1 });
    headingAt(scene, pose(k), name, { width: 1.5 });
    outlineAt(scene, pose(k), name);
    pen.globalAlpha = 1;
  }
}

/** Where the robot was at the step under the cursor of a chart. */
function drawPointed(scene) {
  const { axis: { cursor }, store } = scene.context;
  if (cursor === null) return;
  const known = ["pose_true", "pose_held"].map((name) => store.get(name));
  const rows = known.find((one) => cursor < one?.count && !Number.isNaN(one.get(cursor, 0)));
  const pose = rows && [0, 1, 2].map((field) => rows.get(cursor, field));
  outlineAt(scene, pose, "quiet", { dash: DASH });
  headingAt(scene, pose, "quiet", { dash: DASH });
}

function drawBoxes(scene) {
  for (const [name, ...sides] of scene.frame.boxes) {
    const [left, top, right, bottom] = sides.map((side, i) => side + (i < 2 ? -0.5 : 0.5));
    const color = scene.classColors.get(name) ?? name;
    drawBox(scene, scene.pixel([left, top]), scene.pixel([right, bottom]), color);
  }
}

const BLOBS_PREFIX = "blobs_";

const blobColumns = (setup) =>
  (setup.columns ?? []).map(({ name }) => name).filter((name) => name.startsWith(BLOBS_PREFIX));

/** The centroids of the blobs in the last steps: the older, the fainter. */
function drawObjectTrace(scene) {
  const { pen, unit, frame, context, classColors } = scene;
  const side = Math.round(3 * unit); // whole pixels are drawn faster
  for (const [column, rows] of context.store.columns) {
    if (!column.startsWith(BLOBS_PREFIX)) continue;
    const name = column.slice(BLOBS_PREFIX.length);
    pen.fillStyle = classColors.get(name) ?? name;
    const end = Math.min(rows.count, frame.k + 1);
    for (let row = Math.max(0, end - TRACED_STEPS); row < end; row++) {
      pen.globalAlpha = 1 - (0.9 * (end - row)) / TRACED_STEPS;
      for (let field = 0; field < rows.width; field += 2) {
        const [x, y] = scene.place([rows.get(row, field), rows.get(row, field + 1)]);
        pen.fillRect(Math.round(x - side / 2), Math.round(y - side / 2), side, side);
      }
    }
  }
  pen.globalAlpha = 1;
}

function drawPlanned(scene) {
  const { path, goal } = scene.context.state;
  const color = scene.ink("other-5");
  if (path?.length) {
    const points = path.map(scene.place);
    drawLine(scene, points, color, { dash: [7, 5], width: 2 });
    drawDot(scene, points[0], color, 3);
    drawGoal(scene, path.at(-1), color);
  }
  const { asked } = scene.context.setup;
  for (const one of [goal, String(asked) != String(goal) && asked].filter(Boolean))
    drawGoal(scene, one, color);
}

/** The ellipse of the position, and the wedge of the heading, within 2 standard errors. */
function drawCovariance(scene) {
  const { pen, frame, ink } = scene;
  if (!frame.estimate) return;
  const { pose, covariance } = frame.estimate;
  const center = scene.place(pose);
  const reach = [1.6 * robotReach(scene), 0];
  if (covariance) {
    const edge = ellipse(covariance, ELLIPSE_SIGMAS);
    const around = edge.map(([x, y]) => scene.place([pose[0] + x, pose[1] + y]));
    const turn = Math.min(ELLIPSE_SIGMAS * Math.sqrt(Math.max(covariance[8], 0)), Math.PI);
    const arc = Array.from({ length: 13 }, (_, i) =>
      scene.place(fromRobot([pose[0], pose[1], pose[2] + turn * (i / 6 - 1)], reach)));
    fillArea(pen, [center, ...arc], ink("estimated-band"));
    fillArea(pen, around, ink("estimated-band"));
    drawLine(scene, around, ink("estimated"), { isClosed: true });
  }
  drawLine(scene, [center, scene.place(fromRobot(pose, reach))], ink("estimated"));
  drawDot(scene, center, ink("estimated"));
}

function drawParticles({ pen, unit, frame, place, ink }) {
  const side = 1.5 * unit;
  pen.fillStyle = ink("estimated");
  pen.globalAlpha = 0.4;
  for (const point of frame.particles ?? []) {
    const [x, y] = place(point);
    pen.fillRect(x - side / 2, y - side / 2, side, side);
  }
  pen.globalAlpha = 1;
}

function fillArea(pen, points, color) {
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(x, y);
  pen.fillStyle = color;
  pen.fill();
}

/**
 * Return a function that draws the measured positions up to the frame's step. The trail has its own
 * canvas, and each frame adds a piece.
 */
function makeTrail() {
  const layer = document.createElement("canvas");
  const pen = layer.getContext("2d");
  let first = 0; // row that is drawn
  let drawn = 0; // rows up to which it is
  let known = null; // rows of the cached path
  let key = "";

  const prepare = (scene, rows, upto) => {
    const { canvas } = scene.pen;
    const { scale, left, top } = scene.lens;
    const { map, intrinsics } = scene.frame;
    const view = [canvas.width, canvas.height, scale, left, top, ...map, intrinsics];
    const now = [...view, scene.ink("measured"), rows.epoch].join();
    const isShort = upto - first <= 1.25 * LONGEST_TRAIL;
    if (now == key && rows == known && drawn <= upto && isShort) return;
    known = rows;
    [layer.width, layer.height] = [canvas.width, canvas.height]; // clears it
    [key, first] = [now, Math.max(0, upto - LONGEST_TRAIL)];
    drawn = first;
  };
  const add = ({ place, unit, ink }, rows, upto) => {
    pen.beginPath();
    let isUp = true;
    for (let row = Math.max(first, drawn - 1); row < upto; row++) {
      const [x, y] = place([rows.get(row, 0), rows.get(row, 1)]);
      if (isUp) pen.moveTo(x, y);
      else pen.lineTo(x, y);
      isUp = !(x === x); // not seen: a gap
    }
    pen.lineJoin = "round";
    pen.strokeStyle = haloOf(pen, ink("measured"));
    pen.lineWidth = 2.5 * unit;
    pen.stroke();
    pen.strokeStyle = ink("measured");
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
