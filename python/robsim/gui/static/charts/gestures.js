// @ts-check
// Mouse, fingers, wheel and keys on a chart.
import { listenToKeys } from "../base/keys.js";

const CLICK_SLIP = 4; // px that a pointer may move
const DOT_REACH = 8; // px to a dot that is meant
const WHEEL_ZOOM = 0.002; // natural logarithm of the zoom for a px of the wheel
const WHEEL_UNITS = [1, 16, 400]; // px for deltaMode: pixel, line, page
const KEY_ZOOM = 0.7;
const KEY_JUMP = 10; // steps, with Shift

/** Let a chart of a board be moved by the user. */
export function listenToGestures(chart, board) {
  const { over } = chart;
  const touches = new Map(); // pointer -> where it is
  let moved = 0;

  const at = (event) => {
    const { left, top } = over.getBoundingClientRect();
    return { x: event.clientX - left, y: event.clientY - top };
  };

  over.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    over.setPointerCapture(event.pointerId);
    if (!touches.size) moved = 0;
    touches.set(event.pointerId, at(event));
  });
  over.addEventListener("pointermove", (event) => {
    const [now, before] = [at(event), touches.get(event.pointerId)];
    if (!chart.plot) return;
    if (!before) return pointAt(chart, board, now);
    moved += Math.hypot(now.x - before.x, now.y - before.y);
    if (touches.size == 2) pinchSteps(chart, board, touches, event.pointerId, now);
    else if (moved > CLICK_SLIP) dragChart(chart, board, before, now);
    touches.set(event.pointerId, now);
  });
  const release = (event) => {
    if (!touches.delete(event.pointerId) || event.type == "pointercancel") return;
    if (moved <= CLICK_SLIP && !touches.size) pickStep(chart, board, at(event));
  };
  over.addEventListener("pointerup", release);
  over.addEventListener("pointercancel", release);
  over.addEventListener("pointerleave", (event) => {
    if (event.pointerType == "mouse") board.point(null, null);
  });
  over.addEventListener("dblclick", () => resetChart(chart, board));
  const turned = (event) => turnWheel(chart, board, event, at(event));
  over.addEventListener("wheel", turned, { passive: false });
  listenToKeys(over, (event) => pressKey(chart, board, event));
  over.addEventListener("blur", () => board.point(null, null));
}

const isOnValues = (chart, { x }) => x < chart.box.left;

function pointAt(chart, board, at) {
  const isInside = !isOnValues(chart, at) && at.x <= chart.box.left + chart.box.width;
  chart.over.style.cursor = isInside ? "crosshair" : "ns-resize";
  board.point(isInside ? chart.plot.step(at.x) : null, chart);
}

function dragChart(chart, board, before, now) {
  if (isOnValues(chart, before)) {
    const { plot } = chart;
    const shift = plot.value(before.y) - plot.value(now.y);
    chart.range = [plot.low + shift, plot.high + shift];
    board.later();
  } else board.axis.pan((before.x - now.x) / chart.plot.perStep);
}

/** Keep the steps under two fingers under them. */
function pinchSteps(chart, { axis }, touches, moving, now) {
  const resting = [...touches].find(([id]) => id != moving)[1];
  const before = touches.get(moving);
  const apart = (one) => Math.max(Math.abs(one.x - resting.x), 1);
  const factor = apart(before) / apart(now);
  axis.zoom(chart.plot.step(resting.x), factor);
}

/** Show the frame of the step under the pointer, or of a black dot near it. */
function pickStep(chart, board, at) {
  if (!chart.plot || isOnValues(chart, at)) return;
  const k = Math.round(nearestHeld(chart, at) ?? chart.plot.step(at.x));
  if (k >= 0 && k < board.axis.count) board.context.look(k);
}

function nearestHeld({ shown, plot }, { x, y }) {
  const held = shown.find(({ name }) => name == "held")?.series;
  if (!held) return null;
  let [nearest, least] = [null, DOT_REACH];
  const last = Math.min(Math.floor(plot.step(x + DOT_REACH)), held.count - 1);
  for (let k = Math.max(0, Math.ceil(plot.step(x - DOT_REACH))); k <= last; k++) {
    const distance = Math.hypot(plot.x(k) - x, plot.y(held.value(k)) - y);
    if (distance < least) [nearest, least] = [k, distance];
  }
  return nearest;
}

function resetChart(chart, board) {
  chart.range = null;
  if (board.context.looking !== null) board.context.look(null);
  board.axis.follow();
}

function turnWheel(chart, board, event, at) {
  if (!chart.plot) return;
  event.preventDefault();
  const unit = WHEEL_UNITS[event.deltaMode];
  if (Math.abs(event.deltaX) > Math.abs(event.deltaY))
    return board.axis.pan((event.deltaX * unit) / chart.plot.perStep);
  const strength = event.ctrlKey ? 5 : 1; // a pinch on a touch pad
  const factor = Math.exp(Math.min(Math.max(event.deltaY * unit * WHEEL_ZOOM * strength, -1), 1));
  if (!isOnValues(chart, at)) return board.axis.zoom(chart.plot.step(at.x), factor);
  const { plot } = chart;
  const about = plot.value(at.y);
  chart.range = [about + (plot.low - about) * factor, about + (plot.high - about) * factor];
  board.later();
}

function pressKey(chart, board, event) {
  const { axis, context } = board;
  if (!chart.plot) return false;
  const here = axis.cursor ?? context.looking ?? Math.min(axis.count - 1, Math.floor(axis.last));
  const move = (k) => board.point(k, chart, true);
  const steps = event.shiftKey ? KEY_JUMP : 1;
  const keys = {
    ArrowLeft: () => move(here - steps),
    ArrowRight: () => move(here + steps),
    PageUp: () => axis.pan((axis.first - axis.last) / 2),
    PageDown: () => axis.pan((axis.last - axis.first) / 2),
    Home: () => move(0),
    End: () => move(axis.count - 1),
    "+": () => axis.zoom(here, KEY_ZOOM),
    "=": () => axis.zoom(here, KEY_ZOOM),
    "-": () => axis.zoom(here, 1 / KEY_ZOOM),
    Enter: () => context.look(here),
    Escape: () => {
      event.stopPropagation(); // the robot drives on
      board.point(null, null);
      resetChart(chart, board);
    },
  };
  if (!keys[event.key]) return false;
  keys[event.key]();
}
