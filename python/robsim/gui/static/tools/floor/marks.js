// The points of a floor on its picture: put by a click, dragged, moved by keys, removed; arrows to
// where the map has them.
import { distance } from "../../base/geometry.js";
import { ARROWS } from "../../base/gestures.js";
import { drawArrow, drawCross, drawLabel } from "../../camera/strokes.js";

const SNAP_REACH = 10; // px on the screen, of a click.
const LEAST_SNAP = 4; // px of the camera
const LONGEST_ARROW = 46; // px on the screen
const LONGEST_IN_SHEET = 18; // with many side by side.
const TIMES = [1, 2, 5, 10, 20, 50, 100, 200, 500]; // magnifications of the arrows
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

/** `snaps()` returns whether corners catch clicks; `hovered(pixel)` receives a drag's place. */
export function makeMarks(context, picture, snaps, hovered) {
  const state = () => context.state;
  const isOn = () => state().by == "points";
  const points = () => (isOn() ? (state().points ?? []) : []);
  const chosen = () => points().find(({ number }) => number == state().chosen);
  const placeOf = ({ number, at }) => picture.placeOf(number, at);
  const nearest = (at) => points()[picture.nearest(at, points().map(placeOf))];
  const reach = () => (snaps() ? Math.max(picture.pixels(SNAP_REACH), LEAST_SNAP) : 0);
  const choose = (number) => context.send({ type: "choose", point: number });
  const tell = (type, more = {}) => context.send({ type, point: state().chosen, ...more });
  const add = (at, within) => context.send({ type: "add", at, reach: within });
  /** Return a point as a thing to drag, also in a magnifying glass. */
  const thing = ({ number, at }) => ({ key: number, at, move: (to, goesOn) => {
    context.send({ type: "move", point: number, at: to, goes_on: goesOn });
    hovered(to);
  } });
  const step = (by) => {
    const all = points();
    const at = all.indexOf(chosen());
    const next = all[at < 0 && by < 0 ? all.length - 1 : at + by];
    if (next) choose(next.number);
    return Boolean(next);
  };
  const nudge = ({ key, shiftKey, repeat }) => {
    const far = repeat ? Math.max(1, picture.pixels(2)) : 1;
    const by = ARROWS[key].map((side) => side * (shiftKey ? far : 0.1));
    tell("nudge", { by, goes_on: repeat });
  };
  /** Apply a key to the chosen point; return whether the key has an effect. */
  const press = (event) => {
    if (!chosen()) return false;
    if (event.key == "Delete" || event.key == "Backspace") tell("cut");
    else if (event.key in ARROWS) nudge(event);
    else if (event.key == "s") tell("snap", { reach: Math.max(reach(), 12) });
    else if (event.key == "Escape") choose(null);
    else return false;
    return true;
  };
  return {
    press,
    chosen: () => chosen() && thing({ ...chosen(), at: placeOf(chosen()) }),
    /** The points, for a magnifying glass. */
    crosses: () => points().map((point) =>
      ({ at: placeOf(point), ink: inkOf(state(), point), isIt: point == chosen() })),
    isOn,
    click: (at) => {
      const point = nearest(at);
      if (point) choose(point.number);
      else add(at, reach());
    },
    doubleClick: () => true,
    grab: (at) => {
      const point = nearest(at);
      if (!point) return null;
      choose(point.number);
      return thing(point);
    },
    key: (event) => {
      if (event.key == "Tab") return step(event.shiftKey ? -1 : 1);
      if (event.key != "Enter") return press(event);
      add(picture.middle(), 0);
      return true;
    },
    draw: (scene) => {
      if (state().by == "lens") return;
      drawResiduals(scene, state());
      for (const point of points()) {
        const [at, ink, isIt] = [placeOf(point), inkOf(state(), point), point == chosen()];
        drawCross(scene, scene.pixel(at), ink, { long: isIt ? 13 : 8, width: 1.8, isRinged: isIt });
        drawLabel(scene, { at, words: String(point.number), beside: [1, -1], ink, isStrong: isIt });
      }
    },
  };
}

function inkOf(state, { number }) {
  const kind = standing(state, number);
  if (kind) return MARK_INKS[kind];
  return number == state.chosen ? MARK_INKS.chosen : MARK_INKS.fine;
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
function drawResiduals(scene, state) {
  const { pixel, unit, lens } = scene;
  const times = timesOf(state, lens.scale);
  for (const { at, to, used, name } of state.fit?.points ?? []) {
    const length = distance(at, to) * lens.scale;
    const much = used ? times : Math.min(times, Math.max(1, (90 * unit) / length));
    if (much * length < 2 * unit) continue;
    const end = at.map((side, i) => side + much * (to[i] - side));
    drawArrow(scene, pixel(at), pixel(end), MARK_INKS[standing(state, Number(name)) || "worst"],
      { head: Math.min(7 * unit, (much * length) / 2) });
  }
}
