// @ts-check
// The picture of a tool, and the hands on it: each has things there that are clicked and dragged.
import { distance } from "../base/geometry.js";
import { makePicture } from "../camera/picture.js";

const REACH = 10; // px on the screen that a point takes
const FINGER = 2.2; // times that of a mouse

/**
 * Make it. Later hands lie over earlier ones; the uppermost one that `isOn()` has the pointer. Each
 * has what it wants of these, in pixels of the picture: `hover(at, where)`, null = away, and where
 * on the canvas; `click(at)`; `doubleClick(at)` and `key(event)`, which return whether they have
 * taken it; `grab(at)`, which returns what is dragged from there: {at: where it is, `key`,
 * move(at, goesOn), drop()}; `draw(scene)`. One without `isOn` draws, and has keys.
 */
export function makeHandedPicture(context, label, hands) {
  let held = null; // what is dragged, or was, until Python has it where it is
  let [isHeld, isNew, off] = [false, false, [0, 0]];
  const upper = () => hands.findLast((hand) => hand.isOn?.());
  const at = (where) => picture.lens.toPixel(where);
  const holds = (where) => picture.lens.holds(where);

  const hold = (thing, from = thing?.at) => {
    isHeld = isNew = Boolean(thing);
    if (isHeld) [held, off] = [{ ...thing }, thing.at.map((side, i) => side - from[i])];
    return isHeld;
  };
  const move = (to) => {
    held.at = to.map((side, i) => side + off[i]);
    held.move(held.at, !isNew);
    isNew = false;
    picture.later();
  };
  const drop = () => {
    isHeld = false;
    held.drop?.();
    picture.later();
  };
  const tool = {
    isActive: () => Boolean(upper()),
    takesDrags: () => Boolean(upper()),
    hover: (where) => hands.forEach((hand) =>
      hand.hover?.(where && holds(where) ? at(where) : null, where)),
    click: (where) => holds(where) && upper()?.click?.(at(where)),
    doubleClick: (where) => upper()?.doubleClick?.(at(where)),
    dragStart: (where) => hold(context.frame && upper()?.grab?.(at(where)), at(where)),
    drag: (_, to) => move(at(to)),
    dragEnd: drop,
    giveUp: drop,
    key: (event) => Boolean(upper()?.key?.(event)
      || hands.some((hand) => !hand.isOn && hand.key?.(event))),
  };
  const draw = (scene) => hands.forEach((hand) => hand.draw?.(scene));
  const picture = makePicture(context, { label, inks: [], draw, tool });
  context.on("state", () => {
    if (!isHeld) held = null;
  });
  const pixels = (length) => (length * devicePixelRatio) / picture.lens.scale;
  return {
    ...picture, hold, move, drop, pixels,
    isHeld: () => isHeld,
    /** Where something is, also while it is dragged. */
    placeOf: (key, known) => (held && held.key === key ? held.at : known),
    /** Which of some points is meant at a place; -1 = none. `reach` is in px on the screen. */
    nearest: (place, points, reach = REACH) => {
      const away = points.map((point) => distance(point, place));
      const [least, finger] = [Math.min(...away), picture.canvas.dataset.pointer == "touch"];
      return least < pixels(reach * (finger ? FINGER : 1)) ? away.indexOf(least) : -1;
    },
    /** Whether a pixel is one of the picture. */
    has: (pixel) => holds(picture.lens.toCanvas(pixel)),
    middle: () => at([picture.canvas.width / 2, picture.canvas.height / 2]),
  };
}
