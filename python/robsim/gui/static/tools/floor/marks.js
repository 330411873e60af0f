// @ts-check
// The points of a floor on its picture: put by a click, dragged, moved by keys, removed; arrows to
// where the map has them.
import { ARROWS } from "../../base/arrows.js";
import { distance } from "../../base/geometry.js";
import { drawLabel } from "./grid.js";

const MARK_REACH = { mouse: 10, touch: 22 }; // px on the screen that a point takes
const SNAP_REACH = 10; // px on the screen, of a click
const LEAST_SNAP = 4; // px of the camera
const LONGEST_ARROW = 46; // px on the screen
const LONGEST_IN_SHEET = 18; // where there are many side by side
const TIMES = [1, 2, 5, 10, 20, 50, 100, 200, 500]; // of what the arrows are magnified by
const MARK_INKS = { fine: "#4fd1ff", worst: "#ffb020", wrong: "#ff5a5f", chosen: "#ffffff" };

/** Return how each point of the floor fits, by its number. */
export function fitsOf({ fit, by }) {
  if (!fit || by != "points") return new Map();
  return new Map(fit.points.map((one) => [Number(one.name), one]));
}

/** Return which points stand out: "wrong" was left out, "worst" fits worst of four or more. */
export function standing({ fit, by }, number) {
  const one = fitsOf({ fit, by }).get(number);
  if (!one) return "";
  if (!one.used) return "wrong";
  return fit.points.length > 4 && Number(fit.worst) == number && fit.verdict != "good"
    ? "worst" : "";
}

/**
 * `picture()` has the lens and asks for paint; `snaps()` is whether corners catch clicks;
 * `hovered(pixel, at)` is told where the pointer is.
 */
export function makeMarks(context, picture, snaps, hovered) {
  let held = null; // {number, off}: what is dragged, and how far it is from the pointer
  let local = null; // {number, at}: where it is until Python has it there
  let isNew = false;

  const state = () => context.state;
  const points = () => (state().by == "points" ? (state().points ?? []) : []);
  const chosen = () => points().find(({ number }) => number == state().chosen);
  const placeOf = (point) => (local?.number == point.number ? local.at : point.at);
  const nearest = (at) => {
    const limit = MARK_REACH[matchMedia("(pointer: coarse)").matches ? "touch" : "mouse"];
    const away = (point) =>
      distance(picture().lens.toCanvas(placeOf(point)), at) / devicePixelRatio;
    const [first] = points().toSorted((one, other) => away(one) - away(other));
    return first && away(first) < limit ? first : null;
  };
  const reach = () => (snaps()
    ? Math.max((SNAP_REACH * devicePixelRatio) / picture().lens.scale, LEAST_SNAP) : 0);
  const choose = (number) => context.send({ type: "choose", point: number });
  const moveTo = (number, at) => {
    if (held?.number != number) [held, isNew] = [{ number }, true];
    local = { number, at };
    context.send({ type: "move", point: number, at, goes_on: !isNew });
    isNew = false;
    hovered(at);
    picture().later();
  };
  const letGo = () => (held = null);
  const step = (by) => {
    const all = points();
    const at = all.findIndex(({ number }) => number == state().chosen);
    const next = all[at < 0 && by < 0 ? all.length - 1 : at + by];
    if (next) choose(next.number);
    return Boolean(next);
  };
  const nudge = ({ key, shiftKey, repeat }) => {
    const far = repeat ? Math.max(1, (2 * devicePixelRatio) / picture().lens.scale) : 1;
    const by = ARROWS[key].map((side) => side * (shiftKey ? far : 0.1));
    context.send({ type: "nudge", point: state().chosen, by, goes_on: repeat });
  };
  const cut = () => {
    if (chosen()) context.send({ type: "cut", point: state().chosen });
    return Boolean(chosen());
  };
  context.on("state", () => {
    if (!held) local = null;
    picture().later();
  });
  return {
    choose, moveTo, letGo, nudge, cut, reach,
    /** Where the chosen point is, also while it is dragged. */
    chosenAt: () => (chosen() ? placeOf(chosen()) : null),
    /** The points, for a magnifying glass. */
    crosses: () => points().map((point) =>
      ({ at: placeOf(point), ink: inkOf(state(), point), isIt: point.number == state().chosen })),
    tool: {
      isActive: () => state().by == "points",
      takesDrags: () => state().by == "points",
      hover: (at) => {
        const { lens } = picture();
        hovered(at && lens.holds(at) ? lens.toPixel(at) : null, at);
      },
      click: (at) => {
        if (state().by != "points" || !picture().lens.holds(at)) return;
        const point = nearest(at);
        if (point) choose(point.number);
        else context.send({ type: "add", at: picture().lens.toPixel(at), reach: reach() });
      },
      doubleClick: () => state().by == "points",
      dragStart: (at) => {
        const point = nearest(at);
        if (!point) return false;
        choose(point.number);
        const [u, v] = picture().lens.toPixel(at);
        held = { number: point.number, off: [point.at[0] - u, point.at[1] - v] };
        isNew = true;
        return true;
      },
      drag: (_, to) => {
        const [u, v] = picture().lens.toPixel(to);
        moveTo(held.number, [u + held.off[0], v + held.off[1]]);
      },
      dragEnd: letGo,
      giveUp: letGo,
      key: (event) => {
        if (event.key == "Tab") return step(event.shiftKey ? -1 : 1);
        if (event.key == "Delete" || event.key == "Backspace") return cut();
        if (event.key == "Escape" && chosen()) return choose(null), true;
        if (event.key == "Enter" && state().by == "points") {
          const middle = [picture().canvas.width / 2, picture().canvas.height / 2];
          context.send({ type: "add", at: picture().lens.toPixel(middle), reach: 0 });
          return true;
        }
        if (!chosen()) return false;
        if (event.key == "s") {
          context.send({ type: "snap", point: state().chosen, reach: Math.max(reach(), 12) });
          return true;
        }
        if (!(event.key in ARROWS)) return false;
        nudge(event);
        return true;
      },
    },
    draw: (scene) => {
      drawResiduals(scene, state());
      for (const point of points()) {
        const isIt = point.number == state().chosen;
        drawMark(scene, placeOf(point), inkOf(state(), point), isIt);
        drawLabel(scene, { at: placeOf(point), words: String(point.number), beside: [1, -1],
          ink: inkOf(state(), point), isStrong: isIt });
      }
    },
  };
}

function inkOf(state, { number }) {
  const kind = standing(state, number);
  if (kind) return MARK_INKS[kind];
  return number == state.chosen ? MARK_INKS.chosen : MARK_INKS.fine;
}

function drawMark({ pen, pixel, unit }, at, ink, isIt) {
  const [x, y] = pixel(at);
  const [gap, long] = [3 * unit, (isIt ? 13 : 8) * unit];
  pen.beginPath();
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    pen.moveTo(x + gap * dx, y + gap * dy);
    pen.lineTo(x + long * dx, y + long * dy);
  }
  if (isIt) {
    pen.moveTo(x + long, y);
    pen.arc(x, y, long, 0, 2 * Math.PI);
  }
  for (const [width, color] of [[4, "#000b"], [1.8, ink]]) {
    pen.lineWidth = width * unit;
    pen.strokeStyle = color;
    pen.stroke();
  }
}

/** Return by how much the arrows are magnified, so that the longest one is seen well. */
export function timesOf({ fit, by }, scale) {
  if (!fit) return 1;
  const longest = Math.max(...fit.points.filter(({ used }) => used)
    .map(({ at, to }) => distance(at, to)), 1e-6);
  const wide = by == "points" ? LONGEST_ARROW : LONGEST_IN_SHEET;
  const most = (wide * devicePixelRatio) / (longest * scale);
  return TIMES.findLast((times) => times <= most) ?? 1;
}

/** Arrows from the points to where the map has them. */
function drawResiduals({ pen, pixel, unit, lens }, state) {
  if (!state.fit) return;
  const times = timesOf(state, lens.scale);
  for (const { at, to, used, name } of state.fit.points) {
    const length = distance(at, to) * lens.scale;
    const much = used ? times : Math.min(times, Math.max(1, (90 * unit) / length));
    const [x, y] = pixel(at);
    const [tx, ty] = pixel(at.map((side, i) => side + much * (to[i] - side)));
    if (Math.hypot(tx - x, ty - y) < 2 * unit) continue;
    const ink = MARK_INKS[standing(state, Number(name)) || "worst"];
    drawResidual({ pen, unit }, [x, y], [tx, ty], ink);
  }
}

function drawResidual({ pen, unit }, [x, y], [tx, ty], ink) {
  const angle = Math.atan2(ty - y, tx - x);
  const head = Math.min(7 * unit, Math.hypot(tx - x, ty - y) / 2);
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(tx, ty);
  for (const side of [-0.45, 0.45]) {
    pen.moveTo(tx, ty);
    pen.lineTo(tx - head * Math.cos(angle + side), ty - head * Math.sin(angle + side));
  }
  for (const [width, color] of [[4, "#000b"], [2, ink]]) {
    pen.lineWidth = width * unit;
    pen.strokeStyle = color;
    pen.stroke();
  }
}
