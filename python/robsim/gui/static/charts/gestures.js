// Mouse, fingers, wheel and keys on a chart.
import { listenToKeys, watchGestures } from "../base/gestures.js";

const DOT_REACH = 8; // px to a dot that is meant
const KEY_ZOOM = 0.7;
const KEY_JUMP = 10; // steps, with Shift

/** Let a chart of a board be moved by the user. */
export function listenToGestures(chart, board) {
  const { over } = chart;
  const painted = (act) => (...what) => chart.plot && act(chart, board, ...what);
  watchGestures(over, {
    hover: painted(pointAt), click: painted(pickStep), doubleClick: painted(resetChart),
    drag: painted(dragChart), zoom: painted(zoomChart),
    slide: painted((_, { context }, by) => context.axis.pan(by / chart.plot.perStep)),
    takesWheel: () => true,
  });
  listenToKeys(over, (event) => pressKey(chart, board, event));
  over.addEventListener("blur", () => board.point(null, null));
}

const isOnValues = (chart, [x]) => x < chart.box.left;

function pointAt(chart, board, at) {
  if (!at) return board.point(null, null);
  const isInside = !isOnValues(chart, at) && at[0] <= chart.box.left + chart.box.width;
  chart.over.style.cursor = isInside ? "crosshair" : "ns-resize";
  board.point(isInside ? chart.plot.step(at[0]) : null, chart);
}

function dragChart(chart, board, before, now) {
  if (isOnValues(chart, before)) {
    const { plot } = chart;
    const shift = plot.value(before[1]) - plot.value(now[1]);
    chart.range = [plot.low + shift, plot.high + shift];
    board.later();
  } else board.context.axis.pan((before[0] - now[0]) / chart.plot.perStep);
}

/** Show the frame of the step under the pointer, or of a black dot near it. */
function pickStep(chart, board, at) {
  if (isOnValues(chart, at)) return;
  const k = Math.round(nearestHeld(chart, at) ?? chart.plot.step(at[0]));
  if (k >= 0 && k < board.context.axis.count) board.context.look(k);
}

function nearestHeld({ shown, plot }, [x, y]) {
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
  if (board.context.looking === null) board.context.axis.follow();
  else board.context.look(null);
}

function zoomChart(chart, board, at, factor) {
  const { plot } = chart;
  if (!isOnValues(chart, at)) return board.context.axis.zoom(plot.step(at[0]), 1 / factor);
  const about = plot.value(at[1]);
  chart.range = [plot.low, plot.high].map((end) => about + (end - about) / factor);
  board.later();
}

function pressKey(chart, board, event) {
  const { context } = board;
  const { axis } = context;
  if (!chart.plot) return false;
  const here = axis.cursor ?? context.marked ?? Math.min(axis.count - 1, Math.floor(axis.last));
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
