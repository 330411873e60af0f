// Hands on a picture: each has things there that are clicked, dragged, and moved by keys.
import { distance } from "../base/geometry.js";
import { listenToKeys, watchGestures } from "../base/gestures.js";

const REACH = 10; // px on the screen that a point takes
const FINGER = 2.2; // times the reach of a mouse

/**
 * Let hands act on a picture. Later hands lie over earlier ones; the uppermost hand with a true
 * `isOn()` has the pointer. A hand has some of these methods, with pixels of the picture as `at`:
 * `hover(at, where)` (null = away; `where` is on the canvas), `click(at)`, `draw(scene)`.
 * `doubleClick(at)` and `key(event)` return whether the hand has handled the event. `grab(at)`
 * returns the dragged thing: {at, `key`, move(at, goesOn), drop(), giveUp() if unlike drop()}.
 * `drags()` is false where nothing is dragged. A hand without `isOn` draws, and has keys, also
 * before the first picture has come.
 */
export function makeHands(context, hands, { canvas, lens, later, zoomed }) {
  let held = null; // the dragged thing, until Python's first state after the drop
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
    return Boolean((context.frame && upper()?.key?.(event))
      || hands.some((hand) => !hand.isOn && hand.key?.(event)));
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
