// @ts-check
// Hands on a picture: each has things there that are clicked, dragged, and moved by keys.
import { watchGestures } from "../base/gestures.js";
import { distance } from "../base/geometry.js";
import { listenToKeys } from "../base/keys.js";

const REACH = 10; // px on the screen that a point takes
const FINGER = 2.2; // times that of a mouse

/**
 * Let hands do something on a picture. Later ones lie over earlier ones; the uppermost one that
 * `isOn()` has the pointer. A hand has what it wants of these, in pixels of the picture:
 * `hover(at, where)`, null = away, and where on the canvas; `click(at)`; `doubleClick(at)` and
 * `key(event)`, which return whether they have taken it; `grab(at)`, which returns what is dragged
 * from there: {at: where it is, `key`, move(at, goesOn), drop(), giveUp() if that is not the same};
 * `draw(scene)`; `drags()`, false where nothing is dragged. One without `isOn` draws, and has keys.
 */
export function makeHands(context, hands, { canvas, lens, later, zoomed }) {
  let held = null; // what is dragged, or was, until Python has it where it is
  let [isHeld, isNew, off] = [false, false, [0, 0]];
  const upper = () => hands.findLast((hand) => hand.isOn?.());
  const at = lens.toPixel;
  const pixels = (length) => (length * devicePixelRatio) / lens.scale;

  const hold = (thing, from = thing?.at) => {
    isHeld = isNew = Boolean(thing);
    if (isHeld) [held, off] = [{ ...thing }, thing.at.map((side, i) => side - from[i])];
    return isHeld;
  };
  const move = (to) => {
    held.at = to.map((side, i) => side + off[i]);
    held.move(held.at, !isNew);
    isNew = false;
    later();
  };
  const end = (how) => {
    if (!isHeld) return;
    isHeld = false;
    how?.();
    later();
  };
  const drop = () => end(held?.drop);
  watchGestures(canvas, {
    hover: (where) => hands.forEach((hand) =>
      hand.hover?.(where && lens.holds(where) ? at(where) : null, where)),
    click: (where) => lens.holds(where) && upper()?.click?.(at(where)),
    doubleClick: (where) => upper()?.doubleClick?.(at(where)) || zoomed(lens.reset),
    dragStart: (where) => hold(context.frame && upper()?.grab?.(at(where)), at(where)),
    drag: (from, to) => {
      if (isHeld) move(at(to));
      else zoomed(() => lens.move([to[0] - from[0], to[1] - from[1]]));
    },
    dragEnd: drop,
    giveUp: () => end(held?.giveUp ?? held?.drop),
    zoom: (where, factor) => zoomed(() => lens.zoomAt(where, factor)),
    takesWheel: () => lens.zoom > 1,
    ratio: () => canvas.width / canvas.getBoundingClientRect().width,
  });
  const middle = () => [canvas.width / 2, canvas.height / 2];
  const zoomBy = (factor) => zoomed(() => lens.zoomAt(middle(), factor));
  const larger = () => zoomBy(1.25);
  const keys = { "+": larger, "=": larger, "-": () => zoomBy(0.8), 0: () => zoomed(lens.reset) };
  listenToKeys(canvas, (event) => {
    if (keys[event.key]) return keys[event.key]();
    return Boolean(context.frame && (upper()?.key?.(event)
      || hands.some((hand) => !hand.isOn && hand.key?.(event))));
  });
  context.on("state", () => {
    if (!isHeld) held = null;
  });
  return {
    hold, move, drop, pixels,
    isHeld: () => isHeld,
    isOn: () => Boolean(upper()),
    drags: () => upper()?.drags?.() ?? Boolean(upper()),
    draw: (scene) => hands.forEach((hand) => hand.draw?.(scene)),
    /** Where something is, also while it is dragged. */
    placeOf: (key, known) => (held && held.key === key ? held.at : known),
    /** Which of some points is meant at a place; -1 = none. `reach` is in px on the screen. */
    nearest: (place, points, reach = REACH) => {
      const away = points.map((point) => distance(point, place));
      const [least, finger] = [Math.min(...away), canvas.dataset.pointer == "touch"];
      return least < pixels(reach * (finger ? FINGER : 1)) ? away.indexOf(least) : -1;
    },
    /** Whether a pixel is one of the picture. */
    has: (pixel) => lens.holds(lens.toCanvas(pixel)),
    middle: () => at(middle()),
  };
}
